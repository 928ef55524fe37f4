// Fields of meshes whose files have steps, or fields in files of their own, through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

class cli_mesh_fields : public testing::Test {
 protected:
  static nlohmann::json done(Words words) {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  static void refused(const Words& words, const std::string& why) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  }

  Scratch scratch_;
};

/// A mesh without steps, and with a time or none.
std::string write_still(const std::string& path, std::optional<double> time = {}) {
  const TetraMesh noise = oracles::noise_mesh(5, oracles::Cut::in_six, 5);
  SimplexMesh mesh;
  mesh.positions = noise.positions;
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  Progress progress;
  EXPECT_TRUE(write_mesh(path, mesh, {.value_name = "noise", .time = time}, progress));
  return path;
}

/// A mesh in Gmsh's form with three steps of heat, t + 1 times the noise.
void write_gmsh_steps(const std::string& path) {
  const TetraMesh noise = oracles::noise_mesh(7, oracles::Cut::in_six, 5);
  std::ofstream file(path);
  file.precision(17);
  file << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << noise.positions.size() << '\n';
  for (std::size_t v = 0; v < noise.positions.size(); ++v) {
    const Vec3d& p = noise.positions[v];
    file << v + 1 << ' ' << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  file << "$EndNodes\n$Elements\n" << noise.tetrahedra.size() << '\n';
  for (std::size_t i = 0; i < noise.tetrahedra.size(); ++i) {
    const auto& [a, b, c, d] = noise.tetrahedra[i];
    file << i + 1 << " 4 2 1 1 " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << ' ' << d + 1 << '\n';
  }
  file << "$EndElements\n";
  for (const double time : {0.0, 0.5, 2.0}) {
    file << "$NodeData\n1\n\"heat\"\n1\n"
         << time << "\n3\n"
         << 2 * time << "\n1\n"
         << noise.positions.size() << '\n';
    for (std::size_t v = 0; v < noise.positions.size(); ++v)
      file << v + 1 << ' ' << (time + 1) * noise.fields[0].values[v] << '\n';
    file << "$EndNodeData\n";
  }
}

/// Without a time it would come before the steps that have one, and be the answer.
TEST_F(cli_mesh_fields, that_have_steps_get_no_step_without_a_time) {
  const auto write = [&](const std::string& name, std::optional<double> time) {
    return write_still(scratch_ / name, time);
  };
  const std::string first = write("first.vtu", 0.25);
  const std::string model = scratch_ / "model.lode";
  const std::string all = scratch_ / "all.lode";
  done({"build", first, model, "--at", "file"});
  const nlohmann::json json =
      done({"attach-field", model, write("second.vtu", 0.75), all, "--field", "noise"});
  EXPECT_EQ(json.at("fields").at(1).at("time"), 0.75);
  EXPECT_EQ(done({"probe", all, "--point", "0.5,0.5,0.5"}).at("time"), 0.25);
  refused({"attach-field", model, write("still.vtu", {}), all, "--field", "noise"},
          "--at: expected a time");
  refused({"attach-field", scratch_ / "none.lode", first, all, "--field", "noise"}, "cannot open");
}

/// A mesh of two materials, by x, with a field of its cells: 1 and 200.
void write_two_materials(const std::string& path) {
  const TetraMesh noise = oracles::noise_mesh(5, oracles::Cut::in_six, 5);
  std::ofstream file(path);
  file << "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS "
       << noise.positions.size() << " double\n";
  for (const Vec3d& p : noise.positions) file << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  const std::size_t n = noise.tetrahedra.size();
  file << "CELLS " << n << ' ' << 5 * n << '\n';
  std::string types;
  std::string stresses;
  std::string materials;
  for (const auto& [a, b, c, d] : noise.tetrahedra) {
    file << "4 " << a << ' ' << b << ' ' << c << ' ' << d << '\n';
    const bool is_first = noise.positions[a][0] + noise.positions[b][0] + noise.positions[c][0] +
                              noise.positions[d][0] <
                          2 * noise.positions.back()[0];
    types += "10\n";
    stresses += is_first ? "1\n" : "200\n";
    materials += is_first ? "1\n" : "2\n";
  }
  file << "CELL_TYPES " << n << '\n'
       << types << "CELL_DATA " << n << "\nSCALARS stress double 1\nLOOKUP_TABLE default\n"
       << stresses << "SCALARS again double 1\nLOOKUP_TABLE default\n"
       << stresses << "SCALARS Material int 1\nLOOKUP_TABLE default\n"
       << materials;
}

TEST_F(cli_mesh_fields, of_cells_say_what_averaging_did_when_built_and_when_attached) {
  const std::string mesh = scratch_ / "two.vtk";
  const std::string model = scratch_ / "two.lode";
  const std::string all = scratch_ / "all.lode";
  write_two_materials(mesh);
  const nlohmann::json built = done({"build", mesh, model, "--field", "stress"});
  const nlohmann::json& averaged = built.at("reading").at("averaged").at(0);
  EXPECT_EQ(averaged.at("cell_max"), 200);
  EXPECT_EQ(averaged.at("point_max"), 200);
  ASSERT_EQ(averaged.at("mixed_regions").size(), 2U);
  EXPECT_EQ(averaged.at("mixed_regions")[0].at("region"), 1);
  EXPECT_EQ(averaged.at("mixed_regions")[0].at("cell_max"), 1);
  EXPECT_GT(averaged.at("mixed_regions")[0].at("point_max"), 1);
  const nlohmann::json one =
      done({"build", mesh, scratch_ / "one.lode", "--field", "stress", "--only-region", "1"});
  EXPECT_EQ(one.at("range"), nlohmann::json({1, 1}));
  EXPECT_GT(one.at("reading").at("other_regions"), 0);
  refused({"build", mesh, scratch_ / "one.lode", "--field", "stress", "--only-region", "3"},
          "one of its regions (1, 2)");
  const nlohmann::json attached = done({"attach-field", model, mesh, all, "--field", "again"});
  ASSERT_EQ(attached.at("notes").size(), 3U);
  const std::string note = attached.at("notes")[0].at("note");
  EXPECT_NE(note.find("again: 1 to 200 at cells, 1 to 200 at points"), std::string::npos) << note;
  const std::string kept = done({"info", all}).dump();
  for (const char* name : {"stress", "again"})
    EXPECT_NE(kept.find(std::string(name) + " in region 1: 1 to 1 at its cells"), std::string::npos)
        << kept;
}

TEST_F(cli_mesh_fields, of_a_gmsh_file_at_several_times_are_a_series) {
  const std::string mesh = scratch_ / "steps.msh";
  const std::string model = scratch_ / "steps.lode";
  const std::string all = scratch_ / "all.lode";
  const std::string still = write_still(scratch_ / "still.vtk");
  write_gmsh_steps(mesh);
  const nlohmann::json info = done({"info", mesh});
  EXPECT_EQ(info.at("times"), nlohmann::json({0.0, 0.5, 2.0}));
  EXPECT_EQ(info.at("point fields").size(), 1U);
  const auto high = [&](const nlohmann::json& report) {
    return report.at("fields")[0].at("range")[1].get<double>();
  };
  const double last = high(done({"build", mesh, model, "--field", "heat"}));
  const double first = high(done({"build", mesh, model, "--field", "heat", "--time", "0"}));
  EXPECT_NEAR(last, 3 * first, 1e-12);
  EXPECT_NE(run_lode({"info", mesh, "--time", "1"}).err.find("step 1 of 0 to 2 (time 0.5)"),
            std::string::npos);
  refused({"build", mesh, model, "--field", "heat", "--time", "3"},
          "expected a step from 0 to 2, got 3");
  // Times are the file's, unless they are told.
  const nlohmann::json attached =
      done({"attach-field", model, mesh, all, "--field", "heat", "--time", "0,1,2"});
  ASSERT_EQ(attached.at("fields").size(), 4U);
  EXPECT_FALSE(attached.at("fields")[0].contains("time"));
  EXPECT_EQ(attached.at("fields")[2].at("time"), 0.5);
  EXPECT_EQ(attached.at("fields")[3].at("time"), 2);
  EXPECT_NEAR(attached.at("fields")[3].at("range")[1].get<double>(), last, 1e-12);
  EXPECT_EQ(
      done({"attach-field", model, mesh, all, "--field", "heat", "--time", "1", "--at", "file"})
          .at("fields")[1]
          .at("time"),
      0.5);
  EXPECT_EQ(
      done({"attach-field", model, mesh, all, "--field", "heat", "--time", "0,1", "--at", "7,8"})
          .at("fields")[2]
          .at("time"),
      8);
  done({"verify", all, "--against", mesh, "--field", "heat", "--time", "0"});
  refused({"attach-field", model, still, still, all, "--field", "noise"},
          "--at: expected the times of 2 steps");
  refused({"build", still, model, "--field", "noise", "--time", "1"},
          "--region-field, --only-region, --placement, --order and --fast, got --time");
  refused({"build", mesh, model, "--field", "heat", "--time", "1", "--nodata", "3"},
          "--nodata: expected a volume or terrain, got a mesh of cells");
}

TEST_F(cli_mesh_fields, have_the_time_that_their_build_was_told) {
  const std::string mesh = scratch_ / "steps.msh";
  const std::string model = scratch_ / "steps.lode";
  const std::string all = scratch_ / "all.lode";
  write_gmsh_steps(mesh);
  for (const char* const placement : {"half-edge", "midpoint"}) {
    const Words build{"build", mesh, model, "--field", "heat", "--placement", placement};
    const auto built = [&](const Words& options) {
      Words words = build;
      words.insert(words.end(), options.begin(), options.end());
      done(words);
      return done({"info", model}).at("fields")[0];
    };
    EXPECT_FALSE(built({"--time", "1"}).contains("time"));
    EXPECT_EQ(built({"--time", "1", "--at", "-7.25"}).at("time"), -7.25);
    const nlohmann::json middle = built({"--time", "1", "--at", "file"});
    EXPECT_EQ(middle.at("time"), 0.5);
    EXPECT_NE(run_lode({"info", model}).out.find("heat at 0.5"), std::string::npos);
    EXPECT_EQ(done({"info", mesh, "--time", "1"}).at("time"), 0.5);
    // Answers from memory are of the file's own.
    const std::string direct = scratch_ / "direct.vtu";
    EXPECT_EQ(done({"extract", mesh, direct, "--mesh", "--max-error", "0", "--field", "heat",
                    "--time", "1", "--placement", placement})
                  .at("time"),
              0.5);
    const auto read = read_cell_mesh(direct, {});
    ASSERT_TRUE(read);
    EXPECT_EQ(read->time, 0.5);
    // It is a step as others are: in order of time, once.
    done({"attach-field", model, mesh, all, "--field", "heat", "--time", "0,2"});
    const double first = middle.at("range")[1].get<double>() / 1.5;
    const std::string cut = scratch_ / "cut.vtu";
    for (const auto& [step, time] : {std::pair{"0", 0.0}, {"1", 0.5}, {"2", 2.0}}) {
      const nlohmann::json json =
          done({"extract", all, cut, "--mesh", "--max-error", "0", "--time", step});
      EXPECT_EQ(json.at("time"), time);
      const auto cells = read_cell_mesh(cut, {});
      ASSERT_TRUE(cells);
      EXPECT_EQ(cells->time, time);
      EXPECT_NEAR(*std::ranges::max_element(cells->point_fields.front().values), (time + 1) * first,
                  1e-12);
      done({"verify", all, "--against", mesh, "--field", "heat", "--time", step});
    }
    refused({"attach-field", all, mesh, model, "--field", "heat", "--time", "1", "--at", "0.5"},
            "or another time, got heat at 0.5");
    EXPECT_EQ(done({"extract", model, cut, "--mesh", "--time", "0"}).at("time"), 0.5);
    refused({"extract", model, cut, "--mesh", "--time", "1"}, "--time");
  }
  const std::string still = write_still(scratch_ / "still.vtk");
  refused({"build", still, model, "--at", "file"}, "does not say its own, got 'file'");
  refused({"build", still, model, "--at", "noon"}, "--at: expected a finite number, got 'noon'");
  refused({"build", still, model, "--at", "inf"}, "--at: expected a finite number, got 'inf'");
  const std::string ball = scratch_ / "ball.nrrd";
  write_ball(ball);
  refused({"build", ball, model, "--at", "1"}, "--at: expected a mesh of cells, got a volume");
}

TEST_F(cli_mesh_fields, of_medit_meshes_come_from_solutions) {
  const TetraMesh noise = oracles::noise_mesh(7, oracles::Cut::in_six, 5);
  std::string mesh = "MeshVersionFormatted 2\nDimension 3\nVertices\n";
  mesh += fmt::format("{}\n", noise.positions.size());
  for (const Vec3d& p : noise.positions) mesh += fmt::format("{} {} {} 0\n", p[0], p[1], p[2]);
  mesh += fmt::format("Tetrahedra\n{}\n", noise.tetrahedra.size());
  for (const auto& [a, b, c, d] : noise.tetrahedra)
    mesh += fmt::format("{} {} {} {} 4\n", a + 1, b + 1, c + 1, d + 1);
  const auto solution_of = [&](double factor) {
    std::string text = fmt::format(
        "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{}\n2 1 2\n", noise.positions.size());
    for (std::size_t v = 0; v < noise.positions.size(); ++v) {
      const Vec3d& p = noise.positions[v];
      text += fmt::format("{} {} {} {}\n", factor * noise.fields[0].values[v], p[0], p[1], p[2]);
    }
    return text + "End\n";
  };
  const std::string medit = scratch_ / "room.mesh";
  std::ofstream(medit) << mesh;
  std::ofstream(scratch_ / "room.sol") << solution_of(1);
  std::ofstream(scratch_ / "later.sol") << solution_of(2);
  std::ofstream(scratch_ / "last.sol") << solution_of(3);
  const std::string model = scratch_ / "room.lode";
  const nlohmann::json built =
      done({"build", medit, model, "--field", "solution_1", "--with", "solution_2"});
  const double high = *std::ranges::max_element(noise.fields[0].values);
  EXPECT_EQ(built.at("fields")[0].at("range")[1], high);
  EXPECT_EQ(
      done({"build", medit, model, "--field", "solution_1", "--solution", scratch_ / "later.sol"})
          .at("range")[1],
      2 * high);
  done({"verify", model, "--against", medit, "--solution", scratch_ / "later.sol"});
  EXPECT_NE(run_lode({"verify", model, "--against", medit}).exit_code, 0);
  refused({"build", medit, model, "--time", "3"},
          "--region-field, --only-region, --solution, --placement, --order and --fast, got --time");
  const std::string all = scratch_ / "all.lode";
  const nlohmann::json attached =
      done({"attach-field", model, medit, all, "--field", "solution_1", "--solution",
            (scratch_ / "room.sol") + "," + (scratch_ / "last.sol"), "--at", "1,3"});
  ASSERT_EQ(attached.at("fields").size(), 3U);
  EXPECT_EQ(attached.at("fields")[1].at("time"), 1);
  EXPECT_EQ(attached.at("fields")[2].at("range")[1], 3 * high);
  refused(
      {"build", write_still(scratch_ / "still.vtk"), model, "--solution", scratch_ / "room.sol"},
      "--solution: expected a MEDIT mesh");
  refused({"build", medit, model, "--field", "solution_1", "--solution", scratch_ / "absent.sol"},
          "absent.sol");
}

}  // namespace
}  // namespace lode::test
