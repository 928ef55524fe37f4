#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lode/api/files.h"
#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

class cli_extract : public BallFixture {};

TEST_F(cli_extract, reports_every_promised_key) {
  const Finished run = extract("s.ply", {"--isovalue", "100", "--max-error", "4", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  const nlohmann::json report = run.json();
  for (const char* key : {"achieved_error", "triangles", "vertices", "nodes_visited", "seconds",
                          "max_error", "coordinate_slack", "isovalues", "outputs", "warnings"})
    EXPECT_TRUE(report.contains(key)) << key;
  EXPECT_TRUE(report.at("seconds").is_object());
  EXPECT_EQ(report.at("max_error"), 4);
  EXPECT_LE(report.at("achieved_error").get<double>(), 4);
  EXPECT_EQ(report.at("isovalues"), nlohmann::json{100});
  EXPECT_EQ(report.at("warnings"), nlohmann::json::array());
  const auto surface = read_surface(file("s.ply"));
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_EQ(report.at("triangles"), surface->triangles.size());
  EXPECT_EQ(report.at("vertices"), surface->positions.size());
  EXPECT_GT(surface->triangles.size(), 0u);
}

TEST_F(cli_extract, says_how_far_cubes_are_from_the_level_set_and_verify_knows_them) {
  const Finished run = extract("s.ply", {"--isovalue=100", "--max-error=0", "--style=cubes"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("cubes: vertices on grid edges alone"), std::string::npos);
  const nlohmann::json cubes =
      extract("s.ply", {"--isovalue=100", "--max-error=0", "--style=cubes", "--json"}).json();
  const nlohmann::json tetra =
      extract("t.ply", {"--isovalue=100", "--max-error=0", "--json"}).json();
  EXPECT_EQ(cubes.at("style"), "cubes");
  EXPECT_GT(cubes.at("style_error").get<double>(), 0);
  EXPECT_GT(cubes.at("style_distance").get<double>(), 0);
  EXPECT_FALSE(tetra.contains("style_error"));
  EXPECT_LT(cubes.at("triangles").get<double>(), 0.4 * tetra.at("triangles").get<double>());
  const auto verified = [&](const char* style) {
    return run_lode({"verify", lode_file(), "--surface", file("s.ply"), "--isovalue=100",
                     "--max-error=0", std::string("--style=") + style});
  };
  EXPECT_EQ(verified("cubes").exit_code, 0);
  EXPECT_EQ(verified("tetra").exit_code, 1);
}

TEST_F(cli_extract, has_cubes_where_the_max_error_allows_them) {
  const std::vector<std::string> query{"--isovalue=600", "--max-error=40"};
  const auto extracted = [&](const char* style) {
    std::vector<std::string> arguments{"extract", LODE_SAMPLES_DIR "/tooth.nrrd", file("c.ply"),
                                       "--json", std::string("--style=") + style};
    arguments.insert(arguments.end(), query.begin(), query.end());
    return run_lode(arguments).json();
  };
  const nlohmann::json tetra = extracted("tetra");
  const nlohmann::json cubes = extracted("cubes");
  EXPECT_GT(cubes.at("style_error").get<double>(), 0);
  EXPECT_LE(cubes.at("style_error").get<double>(), 40);
  EXPECT_LT(cubes.at("triangles").get<double>(), tetra.at("triangles").get<double>());
  EXPECT_EQ(run_lode({"verify", LODE_SAMPLES_DIR "/tooth.nrrd", "--surface", file("c.ply"),
                      query[0], query[1], "--style=cubes"})
                .exit_code,
            0);
}

TEST_F(cli_extract, refuses_styles_that_are_none) {
  EXPECT_EQ(extract("s.ply", {"--isovalue=100", "--max-error=0", "--style=hexa"}).exit_code, 2);
}

TEST_F(cli_extract, takes_half_a_percent_of_the_range_by_default_and_says_so) {
  const nlohmann::json report = extract("s.ply", {"--isovalue", "100", "--json"}).json();
  EXPECT_DOUBLE_EQ(report.at("max_error").get<double>(), 1);
  EXPECT_EQ(report.at("max_error_is_default"), true);
  EXPECT_NE(extract("s.ply", {"--isovalue", "100"}).out.find("default: 0.5 % of the value range"),
            std::string::npos);
}

TEST_F(cli_extract, says_why_nothing_is_below_the_least_value) {
  // The ball's values are 0 where it ends, and not below.
  const Finished run = extract("s.ply", {"--isovalue", "0", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_EQ(run.json().at("warnings").size(), 1U);
  const std::string warning = run.json().at("warnings")[0];
  EXPECT_NE(warning.find("no surface at isovalue 0: no value is below it"), std::string::npos)
      << warning;
}

TEST_F(cli_extract, warns_where_a_memory_limit_is_not_kept) {
  const auto warnings = [&](const std::string& input) {
    const Finished run = run_lode({"extract", input, scratch_ / "s.ply", "--isovalue", "100",
                                   "--memory-limit", "1G", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json().at("warnings").size();
  };
  EXPECT_EQ(warnings(volume()), 1U);
  EXPECT_EQ(warnings(lode_file()), 0U);
}

TEST_F(cli_extract, writes_an_empty_file_and_warns_where_an_isovalue_meets_nothing) {
  for (const char* name : {"s.ply", "s.stl", "s.obj", "s.vtp", "s.glb"}) {
    const Finished run = extract(name, {"--isovalue", "1000", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.err.find("lode: warning: "), std::string::npos) << run.err;
    const nlohmann::json report = run.json();
    ASSERT_EQ(report.at("warnings").size(), 1u);
    EXPECT_EQ(report.at("triangles"), 0);
    EXPECT_TRUE(std::filesystem::exists(file(name)));
    const auto surface = read_surface(file(name));
    ASSERT_TRUE(surface) << surface.error().message;
    EXPECT_TRUE(surface->is_empty());
  }
}

TEST(cli_far_volume, gives_an_empty_file_of_any_format_where_an_isovalue_meets_nothing) {
  const Scratch scratch;
  write_bytes(scratch / "far.raw", std::string(8, '\7'));
  for (const char* name : {"s.ply", "s.stl", "s.obj", "s.vtp", "s.glb"}) {
    const Finished run =
        run_lode({"extract", scratch / "far.raw", scratch / name, "--isovalue=100", "--dims=2x2x2",
                  "--type=uint8", "--spacing=0.2,0.2,0.2", "--origin=0,0,-1100", "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.json().at("warnings").size(), 1u);
    const auto surface = read_surface(scratch / name);
    ASSERT_TRUE(surface) << surface.error().message;
    EXPECT_TRUE(surface->is_empty());
  }
}

TEST(cli_holes, are_named_where_a_field_has_nothing_else) {
  const Scratch scratch;
  const std::vector<float> samples(8, std::numeric_limits<float>::quiet_NaN());
  write_bytes(scratch / "nan.raw", {reinterpret_cast<const char*>(samples.data()), 32});
  write_bytes(scratch / "seven.raw", std::string(8, '\7'));
  for (const Words& options : {Words{scratch / "nan.raw", "--type=float32"},
                               Words{scratch / "seven.raw", "--type=uint8", "--nodata=7"}}) {
    Words extract{"extract", scratch / "s.ply", "--isovalue=1", "--dims=2x2x2", "--json"};
    extract.insert(extract.begin() + 1, options.begin(), options.end());
    const Finished run = run_lode(extract);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    ASSERT_EQ(run.json().at("warnings").size(), 1u);
    const auto warning = run.json().at("warnings").at(0).get<std::string>();
    EXPECT_NE(warning.find("no finite sample"), std::string::npos) << warning;
    EXPECT_EQ(warning.find("from 0 to 0"), std::string::npos) << warning;
  }
}

TEST_F(cli_extract, puts_several_isovalues_into_one_file_where_it_can) {
  const Finished run = extract("s.ply", {"--isovalue", "60", "--isovalue", "120,500", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = run.json();
  EXPECT_EQ(report.at("isovalues"), (nlohmann::json{60, 120, 500}));
  EXPECT_EQ(report.at("outputs"), nlohmann::json{file("s.ply")});
  ASSERT_EQ(report.at("warnings").size(), 1u);
  EXPECT_NE(report.at("warnings").at(0).get<std::string>().find("500"), std::string::npos);
}

TEST_F(cli_extract, writes_a_file_for_each_isovalue_where_it_must_and_names_them) {
  const Finished run = extract("s.stl", {"--isovalue", "60", "--isovalue", "120.5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"s-60.stl", "s-120.5.stl"}) {
    EXPECT_TRUE(std::filesystem::exists(file(name))) << name;
    EXPECT_NE(run.out.find(name), std::string::npos) << run.out;
  }
  EXPECT_FALSE(std::filesystem::exists(file("s.stl")));
}

TEST_F(cli_extract, puts_isovalues_of_one_cut_into_files_that_verify_holds_together) {
  const std::vector<std::string> query{"--isovalue",     "60", "--isovalue", "100",
                                       "--max-distance", "2"};
  const Finished run =
      extract("s.stl", {"--isovalue", "60", "--isovalue", "100", "--max-distance", "2", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(run.json().at("warnings").empty()) << run.out;
  EXPECT_EQ(run.json().at("outputs"), (nlohmann::json{file("s-60.stl"), file("s-100.stl")}));
  const auto verify = [&](std::vector<std::string> surfaces) {
    std::vector<std::string> command{"verify", lode_file()};
    for (const std::string& surface : surfaces) {
      command.emplace_back("--surface");
      command.push_back(file(surface));
    }
    command.insert(command.end(), query.begin(), query.end());
    command.emplace_back("--json");
    return run_lode(command);
  };
  const Finished both = verify({"s-60.stl", "s-100.stl"});
  EXPECT_EQ(both.exit_code, 0) << both.err;
  EXPECT_EQ(both.json().at("surface").size(), 2u);
  EXPECT_EQ(verify({"s-100.stl", "s-60.stl"}).exit_code, 1) << "not where they belong";
  const Finished three = verify({"s-60.stl", "s-100.stl", "s-60.stl"});
  EXPECT_EQ(three.exit_code, 2);
  EXPECT_NE(three.err.find("--isovalue for each of 3"), std::string::npos) << three.err;
}

TEST_F(cli_extract, warns_of_files_simplified_apart_in_bands_that_overlap) {
  const auto warnings = [&](const std::string& error) {
    const Finished run = extract("b.stl", {"--isovalue", "60", "--isovalue", "100", "--simplify",
                                           "--max-error", error, "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json().at("warnings");
  };
  EXPECT_TRUE(warnings("15").empty());
  ASSERT_EQ(warnings("21").size(), 1u);
  EXPECT_NE(warnings("21").at(0).get<std::string>().find("60 and 100"), std::string::npos);
}

TEST_F(cli_extract, replaces_an_older_output_whole_or_not_at_all) {
  write_bytes(file("s.ply"), "old");
  const Finished failed =
      run_lode({"extract", file("none.lode"), file("s.ply"), "--isovalue", "100"});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_EQ(read_bytes(file("s.ply")), "old");
  EXPECT_EQ(extract("s.ply", {"--isovalue", "100"}).exit_code, 0);
  EXPECT_TRUE(read_bytes(file("s.ply")).starts_with("ply"));
}

TEST_F(cli_extract, refuses_an_output_it_cannot_write_before_any_work) {
  for (const auto& arguments : {Words{"extract", volume(), file("no/s.ply"), "--isovalue", "1"},
                                Words{"render", volume(), file("no/s.png"), "--isovalue", "1"},
                                Words{"build", volume(), file("no/s.lode")}}) {
    expect_refusal(run_lode(arguments), 1, {"no/s."});
  }
  std::filesystem::create_directory(file("d.ply"));
  expect_refusal(extract("d.ply", {"--isovalue", "1"}), 1, {"d.ply", "directory"});
}

/// A picture is a way to find out; a file should not depend on a guess.
TEST_F(cli_extract, chooses_an_isovalue_for_pictures_alone) {
  const Finished run = run_lode({"render", volume(), file("s.png"), "--size", "64x48", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const double isovalue = run.json().at("isovalues").at(0);
  EXPECT_NE(run.err.find("--isovalue "), std::string::npos) << run.err;
  EXPECT_GT(run.json().at("triangles"), 0);
  EXPECT_NE(isovalue, std::floor(isovalue));
  const std::string chosen = read_bytes(file("s.png"));
  EXPECT_EQ(run_lode({"render", volume(), file("s.png"), "--size", "64x48", "--isovalue",
                      nlohmann::json(isovalue).dump()})
                .exit_code,
            0);
  EXPECT_EQ(read_bytes(file("s.png")), chosen);
  expect_refusal(run_lode({"extract", volume(), file("s.ply")}), 2, {"--isovalue", "lode count"});
}

TEST_F(cli_extract, builds_a_foreign_file_in_memory_and_says_so) {
  const Finished run = run_lode({"extract", volume(), file("s.ply"), "--isovalue", "100"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("in memory"), std::string::npos) << run.err;
  const std::string bytes = read_bytes(file("s.ply"));
  EXPECT_EQ(run_lode({"extract", volume(), file("s.ply"), "--isovalue", "100", "-q"}).err, "");
  EXPECT_EQ(extract("s.ply", {"--isovalue", "100"}).exit_code, 0);
  EXPECT_EQ(read_bytes(file("s.ply")), bytes);
}

TEST_F(cli_extract, writes_the_same_bytes_for_any_number_of_threads) {
  std::string first;
  for (const char* threads : {"1", "2", "7"}) {
    const Finished run = extract("s.ply", {"--isovalue", "100", "--threads", threads});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    if (first.empty()) first = read_bytes(file("s.ply"));
    EXPECT_EQ(read_bytes(file("s.ply")), first);
  }
}

TEST_F(cli_extract, accepts_negative_isovalues_in_any_spelling) {
  for (const auto& options :
       {Words{"--isovalue", "-5"}, Words{"--isovalue", "-.5"}, Words{"--isovalue=-1e3"}})
    EXPECT_EQ(extract("s.ply", options).exit_code, 0);
}

TEST_F(cli_extract, closes_a_surface_at_the_border_and_proves_it) {
  // The isosurface at 10 leaves the ball's box through all six faces.
  const Finished open = extract("s.ply", {"--isovalue", "10", "--max-error", "4", "--json"});
  const Finished closed =
      extract("c.ply", {"--isovalue", "10", "--max-error", "4", "--close-border", "--json"});
  ASSERT_EQ(closed.exit_code, 0) << closed.err;
  EXPECT_GT(closed.json().at("cap_cells"), 0);
  EXPECT_EQ(closed.err, "");  // no warning that it stays open somewhere
  EXPECT_GT(closed.json().at("triangles"), open.json().at("triangles"));
  const Words query{"--isovalue", "10", "--max-error", "4"};
  Words verify{"verify", lode_file(), "--surface", file("c.ply"), "--close-border"};
  verify.insert(verify.end(), query.begin(), query.end());
  const Finished proof = run_lode(verify);
  EXPECT_EQ(proof.exit_code, 0) << proof.err;
  for (const std::string option : {"--clip=0,8,0,8,0,8", "--isovalue=20"}) {
    const Finished refused = extract("r.ply", {"--isovalue", "10", "--close-border", option});
    EXPECT_NE(refused.exit_code, 0) << option;
    EXPECT_FALSE(std::filesystem::exists(file("r.ply"))) << option;
  }
}

TEST_F(cli_extract, keeps_no_topology_of_what_is_clipped) {
  const Words query{"--isovalue", "100", "--keep-topology"};
  for (const char* option : {"--clip=0,8,0,8,0,8", "--min-component=9"}) {
    Words with = query;
    with.emplace_back(option);
    expect_refusal(extract("s.ply", with), 2, {"--keep-topology", "expected no --"});
  }
}

TEST_F(cli_extract, says_what_full_resolution_keeps) {
  const auto extracted = [&](Words options, const char* max_error) {
    options.insert(options.end(), {"--isovalue", "100", "--max-error", max_error});
    const Finished text = extract("s.ply", options);
    options.emplace_back("--json");
    return std::pair{text.out, extract("s.ply", options).json()};
  };
  const auto [near_text, near] = extracted({"--max-distance", "0.5"}, "0");
  EXPECT_EQ(near.at("distance").at("proven_distance"), 0);
  EXPECT_EQ(near.at("distance").at("full_triangles"), near.at("triangles"));
  EXPECT_EQ(near_text.find("(0 triangles)"), std::string::npos) << near_text;
  const auto [kept_text, kept] = extracted({"--keep-topology"}, "0");
  EXPECT_TRUE(kept.at("topology").at("critical_nodes").is_null());
  EXPECT_TRUE(kept.at("topology").at("nodes").is_null());
  EXPECT_NE(kept_text.find("of full resolution, which the surface is"), std::string::npos);
  const auto [coarse_text, coarse] = extracted({"--keep-topology"}, "9");
  EXPECT_TRUE(coarse.at("topology").at("nodes").is_number());
  EXPECT_NE(coarse_text.find("critical nodes"), std::string::npos);
}

TEST_F(cli_extract, writes_into_files_what_they_keep) {
  const auto head_of = [&](const Words& options) {
    Words all{"--isovalue", "100", "--max-error", "9"};
    all.insert(all.end(), options.begin(), options.end());
    EXPECT_EQ(extract("s.ply", all).exit_code, 0);
    return read_bytes(file("s.ply")).substr(0, 400);
  };
  EXPECT_NE(head_of({"--keep-topology"}).find(", keep_topology 0\n"), std::string::npos);
  const std::string both = head_of({"--keep-topology=2.5", "--max-distance", "0.5"});
  EXPECT_NE(both.find(", keep_topology 2.5, max_distance 0.5"), std::string::npos) << both;
  EXPECT_EQ(head_of({}).find("keep_topology"), std::string::npos);
}

TEST_F(cli_extract, leaves_no_normals_where_none_are_wanted) {
  ASSERT_EQ(extract("s.ply", {"--isovalue", "100", "--normals", "off"}).exit_code, 0);
  const auto surface = read_surface(file("s.ply"));
  ASSERT_TRUE(surface);
  EXPECT_TRUE(surface->normals.empty());
}

TEST_F(cli_extract, separates_thousands_for_people) {
  const Finished run = extract("s.ply", {"--isovalue", "20", "--max-error", "0"});
  EXPECT_TRUE(run.out.find(",") != std::string::npos) << run.out;
}

TEST(cli_contours, go_to_formats_with_lines_only) {
  const Scratch scratch;
  write_nrrd(scratch / "flat.nrrd", {{9, 9, 1}}, [](int x, int y, int) { return 10 * (x + y); });
  const std::string flat = scratch / "flat.nrrd";
  expect_refusal(run_lode({"extract", flat, scratch / "c.stl", "--isovalue", "55"}), 1,
                 {"c.stl", "contour lines"});
  const Finished run = run_lode({"extract", flat, scratch / "c.obj", "--isovalue", "55", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(run.json().at("lines").get<int>(), 0);
}

TEST_F(cli_extract, refuses_what_only_meshes_of_cells_have) {
  for (const Words& option : {Words{"--region", "1"}, Words{"--patch", "a"}})
    for (const Words& kind : {Words{}, Words{"--mesh"}, Words{"--max-cells", "100"}}) {
      Words words{"--isovalue", "100"};
      words.insert(words.end(), option.begin(), option.end());
      words.insert(words.end(), kind.begin(), kind.end());
      expect_refusal(extract("s.vtp", words), 2, {option[0], "mesh of cells"});
    }
}

TEST_F(cli_extract, says_where_the_tolerance_has_left_nothing) {
  const std::string bubble = scratch_ / "bubble.nrrd";
  write_nrrd(bubble, {{17, 17, 17}},
             [](int x, int y, int z) { return x == 8 && y == 9 && z == 7 ? 50 : 200; });
  const auto warned = [&](const char* isovalue, const char* max_error) {
    return run_lode({"extract", bubble, scratch_ / "b.ply", "--isovalue", isovalue, "--max-error",
                     max_error})
        .err;
  };
  EXPECT_NE(warned("100", "200").find("nothing of it is left within the tolerance"),
            std::string::npos);
  EXPECT_NE(warned("300", "200").find("it meets nothing"), std::string::npos);
  EXPECT_EQ(warned("100", "0").find("no surface"), std::string::npos);
}

TEST_F(cli_extract, says_where_there_are_no_cells) {
  const std::string line = scratch_ / "line.nrrd";
  write_nrrd(line, {{9, 1, 1}}, [](int x, int, int) { return 10 * x; });
  const std::string even = scratch_ / "even.nrrd";
  write_nrrd(even, {{5, 5, 5}}, [](int, int, int) { return 7; });
  const auto warned = [&](const std::string& input, const char* isovalue) {
    return run_lode({"extract", input, scratch_ / "b.ply", "--isovalue", isovalue}).err;
  };
  EXPECT_NE(warned(line, "35").find("one sample along two axes"), std::string::npos);
  EXPECT_NE(warned(even, "7").find("the field has one value"), std::string::npos);
}

TEST_F(cli_extract, says_where_coordinates_are_too_coarse_or_none) {
  const std::string raw = scratch_ / "noise.raw";
  {
    std::ofstream file(raw, std::ios::binary);
    for (int i = 0; i < 512; ++i) file.put(static_cast<char>(i * 37 % 251));
  }
  const auto run = [&](const char* spacing, const std::string& origin) {
    return run_lode({"extract", raw, scratch_ / "n.ply", "--dims", "8x8x8", "--type", "uint8",
                     "--spacing", spacing, "--origin=" + origin, "--isovalue", "100", "--max-error",
                     "0"});
  };
  EXPECT_EQ(run("1,1,1", "0,0,0").err.find("coordinates"), std::string::npos);
  EXPECT_EQ(run("1,1,1", "5e6,0,0").err.find("coordinates"), std::string::npos);
  const Finished coarse = run("1e-6,1e-6,1e-6", "1e9,0,0");
  EXPECT_EQ(coarse.exit_code, 0);
  EXPECT_NE(coarse.err.find("vertices may be at one place"), std::string::npos) << coarse.err;
  const Finished huge = run("1e38,1e38,1e38", "0,0,0");
  EXPECT_EQ(huge.exit_code, 1);
  EXPECT_NE(huge.err.find("no larger than"), std::string::npos) << huge.err;
}

}  // namespace
}  // namespace lode::test
