#include <gtest/gtest.h>

#include "lode/api/files.h"
#include "tests/cli/ball_fixture.h"
#include "tests/io/vtk_oracle.h"

namespace lode::test {
namespace {

class cli_mesh : public BallFixture {
 protected:
  [[nodiscard]] nlohmann::json report(const std::string& output, std::vector<std::string> options) {
    options.emplace_back("--json");
    const Finished run = extract(output, options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  [[nodiscard]] nlohmann::json seen_by_vtk(const std::string& name) const {
    return nlohmann::json::parse(run_oracle(LODE_MESH_ORACLE, file(name)), nullptr, false);
  }
};

TEST_F(cli_mesh, writes_what_it_reports_and_vtk_reads_it) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  for (const char* tolerance : {"0", "7", "1000"}) {
    const nlohmann::json json = report("m.vtu", {"--mesh", "--max-error", tolerance});
    for (const char* key : {"largest_error", "cut_cells", "left_out", "budget_met", "seconds",
                            "warnings", "outputs", "max_error_is_default", "built_in_memory"})
      EXPECT_TRUE(json.contains(key)) << key;
    const nlohmann::json seen = seen_by_vtk("m.vtu");
    EXPECT_EQ(seen.at("cells"), json.at("cells"));
    EXPECT_EQ(seen.at("points"), json.at("vertices"));
    EXPECT_NEAR(seen.at("size").get<double>(), 16 * 16 * 16, 1e-6);
    EXPECT_GT(seen.at("smallest").get<double>(), 0);
    EXPECT_LE(seen.at("cell_data").at("error").at("range")[1], json.at("max_error"));
    EXPECT_EQ(seen.at("cell_data").at("error").at("range")[1], json.at("achieved_error"));
  }
}

TEST_F(cli_mesh, is_the_same_in_every_format) {
  const Words options{"--mesh", "--max-error", "7"};
  EXPECT_GT(report("m.vtu", options).at("cells"), 100);
  const auto expected = read_cell_mesh(file("m.vtu"), {});
  ASSERT_TRUE(expected);
  for (const char* const name : {"m.vtk", "m.msh"}) {
    const nlohmann::json json = report(name, options);
    const auto seen = read_cell_mesh(file(name), {});
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_EQ(json.at("cells"), seen->n_cells());
    EXPECT_EQ(seen->points, expected->points);
    EXPECT_EQ(seen->corners, expected->corners);
    EXPECT_EQ(seen->point_fields.at(0).values, expected->point_fields.at(0).values);
    EXPECT_EQ(seen->cell_fields.at(0).values, expected->cell_fields.at(0).values);
  }
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  const nlohmann::json json = report("m.e", options);
  const auto seen =
      nlohmann::json::parse(run_oracle(LODE_MESH_CONTENT, file("m.e")), nullptr, false);
  EXPECT_EQ(seen.at("cells").size(), json.at("cells"));
  EXPECT_EQ(seen.at("points").size(), expected->points.size());
}

TEST_F(cli_mesh, takes_foci_and_budgets) {
  const auto cells = [&](const std::vector<std::string>& options) {
    std::vector<std::string> all{"--mesh"};
    all.insert(all.end(), options.begin(), options.end());
    const nlohmann::json json = report("m.vtu", all);
    EXPECT_LE(json.at("achieved_error"), json.at("largest_error"));
    return json.at("cells").get<std::uint64_t>();
  };
  const std::uint64_t all = cells({"--max-error", "2"});
  for (const auto& focus :
       {Words{"--isovalue", "100"}, Words{"--field-range", "150:200"}, Words{"--ball", "8,8,8,2"},
        Words{"--box", "0,3,0,3,0,3", "--box", "-9,1,-9,1,-9,1"},
        Words{"--section", "8,8,8.3:0.1,0,1"}, Words{"--section=1,0,0,2", "--section=1,0,0,14"}}) {
    Words options = focus;
    options.insert(options.end(), {"--max-error", "2"});
    const std::uint64_t focused = cells(options);
    EXPECT_LT(focused, all) << focus[0];
    options.insert(options.end(), {"--max-error-outside", "4", "--mesh"});
    const nlohmann::json bounded = report("m.vtu", options);
    EXPECT_LE(bounded.at("largest_error"), 4) << focus[0];
    EXPECT_GE(bounded.at("cells"), focused) << focus[0];
  }
  const nlohmann::json limited = report("m.vtu", {"--mesh", "--max-cells", "500"});
  EXPECT_LE(limited.at("cells"), 500);
  EXPECT_EQ(limited.at("max_error"), 0);
  EXPECT_EQ(report("m.vtu", {"--mesh", "--max-cells", "1"}).at("warnings").size(), 1u);
}

TEST_F(cli_mesh, writes_sections_also_in_the_border) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  for (const char* plane : {"0,0,0:0,0,1", "0,0,0:0,0,-1", "3,4,16:0,0,2", "3,4,16:0,0,-1",
                            "0,8,0:0,1,0", "5.5,-2,3:1,0,0"}) {
    const nlohmann::json json = report("s.vtp", {"--section", plane, "--max-error", "3"});
    EXPECT_LE(json.at("achieved_error"), 3);
    const nlohmann::json seen = seen_by_vtk("s.vtp");
    EXPECT_EQ(seen.at("cells"), json.at("triangles"));
    EXPECT_EQ(seen.at("points"), json.at("vertices"));
    EXPECT_NEAR(seen.at("size").get<double>(), 16 * 16, 1e-3) << plane;
    EXPECT_EQ(seen.at("point_data").at("value").at("tuples"), json.at("vertices"));
    EXPECT_EQ(seen.at("cell_data").at("error").at("range")[1], json.at("achieved_error"));
  }
}

TEST_F(cli_mesh, writes_isolines_of_sections) {
  const nlohmann::json json =
      report("l.vtp", {"--section", "0,0,8:0,0,1", "--isovalue", "100", "--isovalue", "900"});
  EXPECT_EQ(json.at("triangles"), 0);
  EXPECT_GT(json.at("lines"), 0);
  ASSERT_EQ(json.at("warnings").size(), 1u);
  EXPECT_NE(json.at("warnings")[0].get<std::string>().find("900"), std::string::npos);
  const auto lines = read_surface(file("l.vtp"));
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_EQ(lines->lines.size(), json.at("lines"));
  // A ball's section is one closed line.
  EXPECT_EQ(lines->lines.size(), lines->positions.size());
}

TEST_F(cli_mesh, warns_of_formats_without_values_and_of_planes_beside_the_data) {
  EXPECT_EQ(report("s.vtp", {"--section", "0,0,8:0,0,1"}).at("warnings").size(), 0u);
  for (const char* name : {"s.stl", "s.obj", "s.glb"}) {
    const nlohmann::json json = report(name, {"--section", "0,0,8:0,0,1"});
    ASSERT_EQ(json.at("warnings").size(), 1u);
    EXPECT_NE(json.at("warnings")[0].get<std::string>().find(".vtp and .ply"), std::string::npos);
  }
  EXPECT_EQ(report("s.vtp", {"--section", "0,0,80:0,0,1"}).at("warnings").size(), 1u);
}

TEST_F(cli_mesh, of_2d_data_has_triangles_and_no_section) {
  write_nrrd(file("flat.nrrd"), {{20, 30, 1}}, [](int x, int y, int) { return 3 * x + y; });
  const Finished run = run_lode({"extract", file("flat.nrrd"), file("m.vtu"), "--mesh", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json().at("model"), "diamond2d");
  EXPECT_GT(run.json().at("cells"), 0);
  expect_refusal(
      run_lode({"extract", file("flat.nrrd"), file("s.vtp"), "--section", "0,0,0:1,0,0"}), 1,
      {"--section", "expected 3D data", "20 x 30 x 1"});
}

TEST(cli_mesh_usage, refuses_what_makes_no_sense) {
  const auto refused = [](const std::string& output, Words options, const Words& words) {
    options.insert(options.begin(), {"extract", "a.lode", output});
    expect_refusal(run_lode(options), 2, words);
  };
  refused("m.ply", {"--mesh"}, {"m.ply", ".vtu"});
  refused("s.vtu", {"--section", "0,0,0:0,0,1"}, {"s.vtu", "extension"});
  refused("s.vtp", {"--boundary"}, {"a.lode", "cannot open"});
  for (const Words& of_cells : {Words{"--mesh", "--threshold", "1:2"}, {"--boundary"}}) {
    Words words{"extract", "a.nrrd", "m.vtu"};
    words.insert(words.end(), of_cells.begin(), of_cells.end());
    expect_refusal(run_lode(words), 2,
                   {of_cells.front() == "--mesh" ? "--threshold" : "--boundary",
                    "expected a mesh of cells, got a volume"});
  }
  refused("s.vtp", {"--section", "0,0,0:0,0,1", "--section", "0,0,1:0,0,1"}, {"--section", "one"});
  refused("m.vtu", {"--mesh", "--section", "0,0,0:0,0,0"}, {"--section", "normal"});
  for (const char* plane : {"0,0,0", "0,0:0,0,1", "0,0,0:0,0,0", "0,0,0:1,2", "0,0,0:1:2", "x"})
    refused("s.vtp", {"--section", plane}, {"--section"});
  for (const auto& option :
       {Words{"--clip", "0,1,0,1,0,1"}, Words{"--close-border"}, Words{"--flip"},
        Words{"--min-component", "3"}, Words{"--normals", "off"}}) {
    Words options = option;
    options.emplace_back("--mesh");
    refused("m.vtu", options, {option[0], "no --mesh"});
    options.back() = "--section=0,0,0:0,0,1";
    refused("s.vtp", options, {option[0], "no --section"});
  }
  refused("s.ply", {"--field-range", "1:2", "--isovalue", "3"},
          {"--field-range", "--mesh or --section"});
  for (const auto& option : {Words{"--view", "camera.json"}, Words{"--max-error-px", "1"},
                             Words{"--deadline-ms", "5"}}) {
    Words options = option;
    options.emplace_back("--mesh");
    refused("m.vtu", options, {option[0], "no --mesh"});
  }
  refused("m.vtu", {"--mesh", "--field-range", "2:1"}, {"--field-range", "A <= B"});
  refused("m.vtu", {"--mesh", "--field-range", "2"}, {"--field-range", "A:B"});
  refused("m.vtu", {"--mesh", "--box", "0,1,0,1,1,0"}, {"--box"});
  refused("m.vtu", {"--mesh", "--ball", "0,1,0,-1"}, {"--ball"});
  refused("m.vtu", {"--mesh", "--max-cells", "0"}, {"--max-cells"});
  refused("m.vtu", {"--mesh", "--max-error-outside", "3"}, {"--max-error-outside", "--ball"});
  for (const auto& option : {Words{"--box", "0,1,0,1,0,1"}, Words{"--ball", "0,0,0,1"},
                             Words{"--max-error-outside", "3"}}) {
    Words options = option;
    options.emplace_back("--section=0,0,0:0,0,1");
    refused("s.vtp", options, {option[0], "no --section"});
  }
  refused("s.stl", {"--section", "0,0,0:0,0,1", "--isovalue", "1"}, {"s.stl", ".vtp"});
  refused("a.lode", {"--mesh"}, {".vtu"});
}

}  // namespace
}  // namespace lode::test
