// Several fields of one mesh of cells, and time steps, through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/tetra_fields_fixture.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

TEST_F(cli_tetra_fields, come_with_meshes_and_surfaces) {
  const nlohmann::json info = done({"info", model_});
  ASSERT_EQ(info.at("fields").size(), 3U);
  EXPECT_EQ(info.at("field"), "noise");
  EXPECT_EQ(info.at("fields")[2].at("name"), "shift:0");
  const nlohmann::json plain = done({"extract", model_, out_, "--mesh", "--max-error", "0.1"});
  EXPECT_EQ(fields_of(out_), std::vector<std::string>{"noise"});
  EXPECT_TRUE(plain.at("with").empty());
  const nlohmann::json all = done({"extract", model_, out_, "--mesh", "--max-error", "0.1",
                                   "--with", "shift:x", "--with", "square"});
  EXPECT_EQ(fields_of(out_), (std::vector<std::string>{"noise", "shift:0", "square"}));
  EXPECT_EQ(all.at("cells"), plain.at("cells"));
  EXPECT_EQ(all.at("with")[1].at("field"), "square");
  EXPECT_GT(all.at("with")[1].at("largest_error"), 0);
  EXPECT_GT(all.at("bytes_read"), plain.at("bytes_read"));
  for (const char* other : {"m.vtk", "m.msh"}) {
    done({"extract", model_, scratch_ / other, "--mesh", "--with", "square"});
    EXPECT_EQ(fields_of(scratch_ / other).front(), "noise");
    EXPECT_EQ(fields_of(scratch_ / other).back(), "square");
  }
  // At all vertices the square is one.
  const auto cells = read_cell_mesh(out_, {});
  ASSERT_TRUE(cells);
  const auto& noise = cells->point_fields[0].values;
  for (std::size_t v = 0; v < noise.size(); ++v)
    EXPECT_NEAR(cells->point_fields[2].values[v], noise[v] * noise[v], 1e-5);
  // Other formats have the same, and what cells state.
  for (const char* const extension : {".vtk", ".msh"}) {
    const std::string other = scratch_ / "other" + extension;
    const nlohmann::json same = done({"extract", model_, other, "--mesh", "--max-error", "0.1",
                                      "--with", "shift:x", "--with", "square"});
    EXPECT_EQ(same.at("with"), all.at("with"));
    EXPECT_EQ(same.at("with")[1].at("error_kind"), "at samples");
    EXPECT_EQ(fields_of(other), fields_of(out_));
    const auto read = read_cell_mesh(other, {});
    ASSERT_TRUE(read);
    std::vector<double> errors;
    for (const MeshField& field : read->cell_fields)
      if (field.name == "error_square") errors = field.values;
    ASSERT_EQ(errors.size(), read->n_cells());
    EXPECT_EQ(std::ranges::max(errors), all.at("with")[1].at("largest_error"));
  }
  // The other field measures.
  EXPECT_EQ(done({"extract", model_, out_, "--mesh", "--field", "square"}).at("field"), "square");
  const std::string surface = scratch_ / "s.vtp";
  EXPECT_GT(done({"extract", model_, surface, "--isovalue", "0.1", "--max-error", "0", "--with",
                  "shift:x"})
                .at("triangles"),
            100);
  std::ifstream file(surface, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("Name=\"shift:0\""), std::string::npos);
  EXPECT_EQ(done({"probe", model_, "--point", "0.5,0.5,0.5", "--field", "square"}).at("field"),
            "square");
  EXPECT_EQ(done({"verify", model_, "--against", mesh_}).at("passed"), true);
}

TEST_F(cli_tetra_fields, come_with_meshes_that_are_built_in_memory) {
  const nlohmann::json made =
      done({"extract", mesh_, out_, "--mesh", "--field", "noise", "--with", "square"});
  EXPECT_EQ(made.at("with")[0].at("field"), "square");
  EXPECT_EQ(fields_of(out_), (std::vector<std::string>{"noise", "square"}));
}

TEST_F(cli_tetra_fields, come_all_where_all_are_wanted) {
  const std::string model = scratch_ / "all.lode";
  const nlohmann::json built = done({"build", mesh_, model, "--field", "square", "--with", "all"});
  std::vector<std::string> names;
  for (const auto& field : built.at("fields")) names.push_back(field.at("name"));
  EXPECT_EQ(names, (std::vector<std::string>{"square", "noise", "shift:0", "shift:1", "shift:2"}));
  const std::string out = scratch_ / "all.vtu";
  const auto fields_of = [&](const std::string& input, const Words& fields) {
    Words words{"extract", input, out, "--mesh"};
    words.insert(words.end(), fields.begin(), fields.end());
    done(words);
    std::vector<std::string> written;
    const nlohmann::json info = done({"info", out});
    for (const auto& field : info.at("point fields")) written.push_back(field.at("name"));
    return written;
  };
  const std::vector<std::string> all{"square", "noise", "shift"};
  EXPECT_EQ(fields_of(model, {"--with", "all"}), all);
  EXPECT_EQ(fields_of(mesh_, {"--field", "square", "--with", "all"}), all);
  EXPECT_EQ(fields_of(model, {}), std::vector<std::string>{"square"});
}

TEST_F(cli_tetra_fields, are_attached_as_steps) {
  const std::string all = scratch_ / "all.lode";
  const nlohmann::json report =
      done({"attach-field", model_, later_, latest_, all, "--field", "noise", "--at", "0.5,1.5"});
  EXPECT_EQ(report.at("attached"), 2);
  ASSERT_EQ(report.at("fields").size(), 5U);
  EXPECT_EQ(report.at("fields")[4].at("time"), 1.5);
  EXPECT_EQ(report.at("file_bytes"), std::filesystem::file_size(all));
  EXPECT_EQ(done({"verify", all}).at("passed"), true);
  const auto range = [&](const char* step) {
    return done({"extract", all, out_, "--mesh", "--max-error", "0", "--field", "noise", "--time",
                 step})
        .at("cells");
  };
  EXPECT_EQ(range("0"), range("2"));
  const auto value = [&](const char* step) {
    return done({"probe", all, "--point", "0.3,0.6,0.55", "--field", "noise", "--time", step})
        .at("points")[0]
        .at("value")
        .get<double>();
  };
  EXPECT_NEAR(value("1"), 2 * value("0"), 1e-12);
  EXPECT_NEAR(value("2"), 3 * value("0"), 1e-12);
  // Each step against what it was attached from, and no other.
  const auto against = [&](const std::string& mesh, const char* step) {
    return run_lode({"verify", all, "--against", mesh, "--field", "noise", "--time", step})
        .exit_code;
  };
  EXPECT_EQ(against(mesh_, "0"), 0);
  EXPECT_EQ(against(later_, "1"), 0);
  EXPECT_EQ(against(latest_, "2"), 0);
  EXPECT_EQ(against(later_, "2"), 1);
  refused({"probe", all, "--point", "0,0,0", "--field", "noise", "--time", "3"}, "--time");
}

TEST_F(cli_tetra_fields, of_an_answer_are_of_one_time) {
  const std::string one = scratch_ / "one.lode";
  const std::string two = scratch_ / "two.lode";
  const std::string all = scratch_ / "all.lode";
  // Not in order of time.
  done({"attach-field", model_, latest_, one, "--field", "noise", "--at", "1.5"});
  done({"attach-field", one, later_, two, "--field", "noise", "--at", "0.5"});
  done({"attach-field", two, latest_, all, "--field", "square", "--at", "1.5"});
  const auto probed = [&](const std::vector<std::string>& field) {
    std::vector<std::string> words{"probe", all, "--point", "0.3,0.6,0.55", "--field"};
    words.insert(words.end(), field.begin(), field.end());
    return done(words);
  };
  const auto value_of = [](const nlohmann::json& json) {
    return json.at("points")[0].at("value").get<double>();
  };
  const double first = value_of(probed({"noise"}));
  EXPECT_TRUE(probed({"noise", "--time", "0"}).at("time").is_null());
  EXPECT_EQ(probed({"noise", "--time", "1"}).at("time"), 0.5);
  EXPECT_NEAR(value_of(probed({"noise", "--time", "1"})), 2 * first, 1e-12);
  EXPECT_NEAR(value_of(probed({"noise", "--time", "2"})), 3 * first, 1e-12);
  EXPECT_NEAR(value_of(probed({"noise at 0.5"})), 2 * first, 1e-12);
  EXPECT_EQ(value_of(probed({"square", "--time", "1"})), value_of(probed({"square at 1.5"})));
  // A field without times goes with all.
  const nlohmann::json made =
      done({"extract", all, out_, "--mesh", "--max-error", "0", "--field", "noise", "--with",
            "square", "--with", "shift:x", "--time", "2"});
  EXPECT_EQ(made.at("time"), 1.5);
  const auto cells = read_cell_mesh(out_, {});
  ASSERT_TRUE(cells);
  ASSERT_EQ(cells->point_fields[1].name, "square");
  // 3 v and 3 v^2.
  const auto& noise = cells->point_fields[0].values;
  for (std::size_t v = 0; v < noise.size(); ++v)
    EXPECT_NEAR(cells->point_fields[1].values[v], noise[v] * noise[v] / 3, 1e-5);
  const std::string missing = "field square: expected a step at 0.5";
  refused({"extract", all, out_, "--mesh", "--field", "noise", "--with", "square", "--time", "1"},
          missing);
  refused({"extract", all, out_, "--mesh", "--field", "noise at 0.5", "--with", "square"}, missing);
  refused({"extract", all, out_, "--mesh", "--field", "noise at 0.7"}, "without a time, at 0.5");
  refused({"extract", all, out_, "--mesh", "--field", "noise at 0.5", "--time", "1"}, "--time");
}

TEST_F(cli_tetra_fields, that_are_left_out_are_named_with_the_reason) {
  const std::string mesh = scratch_ / "corners.msh";
  std::ofstream(mesh) << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
                         "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
                         "$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n"
                         "$NodeData\n1\n\"heat\"\n1\n0\n3\n0\n1\n4\n"
                         "1 1\n2 2\n3 3\n4 4\n$EndNodeData\n"
                         "$ElementNodeData\n1\n\"stress\"\n1\n0\n3\n0\n1\n1\n"
                         "1 4 1 2 3 4\n$EndElementNodeData\n";
  EXPECT_EQ(done({"info", mesh}).at("reading").at("skipped_arrays"),
            nlohmann::json({"stress ($ElementNodeData)"}));
  EXPECT_NE(run_lode({"info", mesh}).out.find("stress ($ElementNodeData)"), std::string::npos);
  refused({"build", mesh, scratch_ / "x.lode", "--field", "stress"},
          "stress ($ElementNodeData) is left out");
  const std::string medit = scratch_ / "one.mesh";
  std::ofstream(medit) << "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n"
                          "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
                          "Tetrahedra\n1\n1 2 3 4 7\nEnd\n";
  for (const std::vector<std::string>& field : {std::vector<std::string>{}, {"--field", "heat"}}) {
    std::vector<std::string> words{"build", medit, scratch_ / "x.lode"};
    words.insert(words.end(), field.begin(), field.end());
    refused(words, "(RegionId)");
    refused(words, "no .sol or .solb of the same name lies beside it");
  }
}

TEST_F(cli_tetra_fields, have_the_time_of_their_step_in_files_and_take_it_from_there) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  const std::string all = scratch_ / "all.lode";
  done({"attach-field", model_, later_, latest_, all, "--field", "noise", "--at", "0.1,7"});
  const auto seen = [&](const std::string& path) {
    return nlohmann::json::parse(run_oracle(LODE_MESH_ORACLE, path), nullptr, false).at("time");
  };
  const std::string first = scratch_ / "first.vtu";
  const std::string second = scratch_ / "second.vtu";
  const std::string surface = scratch_ / "s.vtp";
  done({"extract", all, first, "--mesh", "--max-error", "0", "--field", "noise", "--time", "1"});
  done({"extract", all, second, "--mesh", "--max-error", "0", "--field", "noise", "--time", "2"});
  done({"extract", all, surface, "--boundary", "--field", "noise", "--time", "2"});
  done({"extract", all, out_, "--mesh", "--field", "noise"});
  EXPECT_EQ(seen(first), 0.1);
  EXPECT_EQ(seen(second), 7);
  EXPECT_EQ(seen(surface), 7);
  EXPECT_EQ(seen(out_), nullptr);
  // Steps of a series in files of their own.
  const std::string again = scratch_ / "again.lode";
  const std::string series = scratch_ / "series.lode";
  done({"build", first, again, "--field", "noise"});
  const nlohmann::json attached =
      done({"attach-field", again, second, first, series, "--field", "noise"});
  ASSERT_EQ(attached.at("fields").size(), 3U);
  EXPECT_EQ(attached.at("fields")[1].at("time"), 7);
  EXPECT_EQ(attached.at("fields")[2].at("time"), 0.1);
  for (const char* const name : {"step.vtk", "step.msh"}) {
    const std::string file = scratch_ / name;
    done(
        {"extract", series, file, "--mesh", "--max-error", "0", "--field", "noise", "--time", "2"});
    EXPECT_EQ(read_cell_mesh(file, {})->time, 7);
  }
}

/// A field's own name comes before what it would be short for.
TEST_F(cli_tetra_fields, may_be_called_as_components_are) {
  const std::string mesh = scratch_ / "named.vtk";
  std::string text = read_bytes(mesh_);
  for (std::size_t at = text.find("square"); at != std::string::npos; at = text.find("square", at))
    text.replace(at, 6, "shift:x");
  write_bytes(mesh, text);
  const std::string model = scratch_ / "named.lode";
  done({"build", mesh, model, "--field", "noise", "--with", "all"});
  const auto probed = [&](const std::string& input, const std::string& field) {
    return done({"probe", input, "--point", "0.5,0.5,0.5", "--field", field})
        .at("points")[0]
        .at("value")
        .get<double>();
  };
  for (const std::string& input : {mesh, model}) {
    const double noise = probed(input, "noise");
    EXPECT_NEAR(probed(input, "shift:x"), noise * noise, 1e-12) << input;
    EXPECT_NEAR(probed(input, "shift:0"), 0.05, 1e-12) << input;
  }
  done({"build", mesh, model, "--field", "shift:x"});
  EXPECT_EQ(done({"info", model}).at("field"), "shift:x");
}

TEST_F(cli_tetra_fields, of_one_value_need_no_cells_but_the_bases) {
  const std::string mesh = scratch_ / "zero.vtk";
  const std::string model = scratch_ / "zero.lode";
  write_step(mesh, 0);
  done({"build", mesh_, model_, "--field", "noise", "--at", "1"});
  done({"attach-field", model_, mesh, model, "--field", "noise", "--at", "0"});
  const nlohmann::json info = done({"info", model});
  EXPECT_EQ(info.at("fields")[0].at("step"), 1);
  EXPECT_EQ(info.at("fields")[1].at("step"), 0);
  for (const Words& tolerance : {Words{}, Words{"--max-error", "1%"}}) {
    Words words{"extract", model, out_, "--mesh", "--time", "0"};
    words.insert(words.end(), tolerance.begin(), tolerance.end());
    const nlohmann::json json = done(words);
    EXPECT_EQ(json.at("cells"), json.at("base_cells"));
    EXPECT_EQ(json.at("achieved_error"), 0);
  }
  const nlohmann::json all = done({"extract", model, out_, "--mesh", "--max-error", "0"});
  EXPECT_EQ(all.at("cells"), all.at("reference_cells"));
}

TEST_F(cli_tetra_fields, have_a_tolerance_outside_as_a_share_of_their_range) {
  const nlohmann::json info = done({"info", model_});
  const double range = info.at("fields")[0].at("range")[1].get<double>() -
                       info.at("fields")[0].at("range")[0].get<double>();
  const auto extracted = [&](const std::string& outside) {
    return done({"extract", model_, out_, "--mesh", "--box", "0,0.2,0,0.2,0,0.2", "--max-error",
                 "0.5%", "--max-error-outside", outside});
  };
  const nlohmann::json share = extracted("10%");
  EXPECT_EQ(share.at("cells"), extracted(fmt::format("{}", range * 0.1)).at("cells"));
  EXPECT_LE(share.at("achieved_error"), share.at("max_error"));
  EXPECT_LE(share.at("largest_error").get<double>(), range * 0.1);
  EXPECT_GT(share.at("largest_error"), share.at("max_error"));
  const nlohmann::json picture =
      done({"render", model_, scratch_ / "p.png", "--boundary", "--size", "32x32", "--box",
            "0,0.2,0,0.2,0,0.2", "--max-error", "0.5%", "--max-error-outside", "10%"});
  EXPECT_EQ(picture.at("cells"), share.at("cells"));
  refused({"extract", model_, out_, "--mesh", "--box", "0,1,0,1,0,1", "--max-error-outside", "-1%"},
          "--max-error-outside");
}

TEST_F(cli_tetra_fields, are_not_drawn_by_a_bad_file_of_knots_which_alone_is_told) {
  const std::string knots = scratch_ / "knots.txt";
  write_bytes(knots, "0 0 0\n");
  const Finished run =
      run_lode({"render", model_, scratch_ / "p.png", "--opacity", knots, "--field", "noise"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("knots.txt"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("viridis-smoke"), std::string::npos) << run.err;
}

TEST_F(cli_tetra_fields, colour_isosurfaces_in_ply_files_too) {
  const std::string out = scratch_ / "coloured.ply";
  done({"extract", model_, out, "--field", "noise", "--isovalue", "0.1", "--with", "square",
        "--max-error", "0"});
  std::ifstream file(out, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(bytes.find("property double square\n"), std::string::npos);
}

TEST_F(cli_tetra_fields, of_lean_files_give_the_same_but_for_normals) {
  const std::string whole = scratch_ / "whole.lode";
  const std::string lean = scratch_ / "lean.lode";
  const auto built = [&](const std::string& path, std::vector<std::string> more) {
    std::vector<std::string> arguments{"build", mesh_, path, "--field", "noise"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return done(arguments).at("file_bytes").get<std::uint64_t>();
  };
  EXPECT_LT(built(lean, {"--lean"}), built(whole, {}));
  EXPECT_TRUE(done({"info", lean}).at("lean").get<bool>());
  EXPECT_FALSE(done({"info", whole}).at("lean").get<bool>());
  const auto surface = [&](const std::string& path) {
    const std::string out = scratch_ / "surface.ply";
    done({"extract", path, out, "--isovalue", "0.1", "--max-error", "0.05"});
    return read_surface(out).value();
  };
  const Surface ours = surface(lean);
  const Surface theirs = surface(whole);
  EXPECT_EQ(ours.positions, theirs.positions);
  EXPECT_EQ(ours.triangles, theirs.triangles);
  ASSERT_EQ(ours.normals.size(), theirs.normals.size());
  EXPECT_FALSE(ours.normals.empty());
  EXPECT_NE(ours.normals, theirs.normals);
  double sum = 0;
  for (std::size_t i = 0; i < ours.normals.size(); ++i)
    sum += static_cast<double>(dot(ours.normals[i], theirs.normals[i]));
  EXPECT_GT(sum / static_cast<double>(ours.normals.size()), 0.7);
  done({"verify", lean, "--against", mesh_});
  refused({"attach-field", lean, later_, scratch_ / "more.lode", "--field", "noise"},
          "a lean one is without");
  refused({"build", mesh_, lean, "--field", "noise", "--lean", "--placement", "midpoint"},
          "no --lean");
}

TEST_F(cli_tetra_fields, that_make_no_sense_are_refused) {
  const std::string all = scratch_ / "all.lode";
  refused({"verify", model_, "--against", mesh_, "--time", "7"}, "--time: expected none");
  refused({"attach-field", model_, later_, all, "--field", "noise"}, "has not got");
  refused({"attach-field", model_, later_, latest_, all, "--field", "noise"}, "--at: expected");
  refused({"attach-field", model_, later_, all, "--field", "noise", "--at", "1,2"},
          "expected 1 times");
  refused({"attach-field", model_, later_, all}, "--field");
  refused({"attach-field", mesh_, later_, all, "--field", "noise"}, "expected a .lode file");
  refused({"attach-field", model_, all, "--field", "noise"}, "got 2 files");
  refused({"attach-field", model_, later_, scratch_ / "all.vtu", "--field", "noise"}, ".lode");
  refused({"extract", model_, out_, "--mesh", "--with", "heat"}, "expected one of the fields");
  refused({"extract", model_, scratch_ / "out.stl", "--boundary", "--with", "square"},
          "--with: expected an output that ends in .vtp or .ply");
  refused({"extract", mesh_, out_, "--mesh", "--with", "square"}, "--field");
  refused({"extract", model_, out_, "--mesh", "--field", "square", "--time", "3"}, "has no steps");
  refused(
      {"render", model_, scratch_ / "p.png", "--boundary", "--field", "noise", "--with", "square"},
      "--with");
  EXPECT_FALSE(std::filesystem::exists(all));
}

}  // namespace
}  // namespace lode::test
