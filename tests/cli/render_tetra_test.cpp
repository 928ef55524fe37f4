// Pictures of meshes of cells through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/cli/tetra_fixture.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// 8^3 cubes with a saddle on a slope, as legacy VTK.
std::string hexahedra() {
  constexpr int kPoints = 9;
  constexpr int kCells = kPoints - 1;
  std::string points;
  std::string values;
  std::string cells;
  const auto id = [](int x, int y, int z) { return (z * kPoints + y) * kPoints + x; };
  for (int z = 0; z < kPoints; ++z)
    for (int y = 0; y < kPoints; ++y)
      for (int x = 0; x < kPoints; ++x) {
        points += fmt::format("{} {} {}\n", x, y, z);
        values += fmt::format("{}\n", x + (y - 4) * (z - 4) * 0.3);
        if (x == kCells || y == kCells || z == kCells) continue;
        cells += fmt::format("8 {} {} {} {} {} {} {} {}\n", id(x, y, z), id(x + 1, y, z),
                             id(x + 1, y + 1, z), id(x, y + 1, z), id(x, y, z + 1),
                             id(x + 1, y, z + 1), id(x + 1, y + 1, z + 1), id(x, y + 1, z + 1));
      }
  const int n = kCells * kCells * kCells;
  std::string text = fmt::format(
      "# vtk DataFile Version 3.0\nhexahedra\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} float\n"
      "{}CELLS {} {}\n{}CELL_TYPES {}\n",
      kPoints * kPoints * kPoints, points, n, 9 * n, cells, n);
  for (int i = 0; i < n; ++i) text += "12\n";
  return text + fmt::format("POINT_DATA {}\nSCALARS wave float\nLOOKUP_TABLE default\n{}",
                            kPoints * kPoints * kPoints, values);
}

class cli_render_tetra : public testing::Test {
 protected:
  cli_render_tetra() { write_bytes(input_, hexahedra()); }

  [[nodiscard]] Finished render(std::vector<std::string> options) const {
    options.insert(options.begin(), {"render", input_, output_, "--size", "60x50", "--json"});
    return run_lode(options);
  }
  /// The report; the picture must be there.
  [[nodiscard]] nlohmann::json report(const std::vector<std::string>& options) const {
    const Finished run = render(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(read_bytes(output_).substr(1, 3), "PNG");
    return run.json();
  }
  /// Its bytes.
  [[nodiscard]] std::string picture(const char* size, const Words& options) const {
    Words words{"render", input_, output_, "--size", size};
    words.insert(words.end(), options.begin(), options.end());
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_bytes(output_);
  }
  void expect_refused(const std::vector<std::string>& options, const char* message) const {
    const Finished run = render(options);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtk";
  std::string output_ = scratch_ / "out.png";
};

TEST_F(cli_render_tetra, draws_the_volume_of_a_budget_with_surfaces_in_it) {
  const nlohmann::json json = report({"--opacity", "viridis-smoke", "--isovalue", "4.1",
                                      "--section", "0,0,1,3.5", "--max-cells", "900"});
  EXPECT_EQ(json.at("model"), "tetra_mt");
  EXPECT_LE(json.at("cells"), 900);
  EXPECT_GT(json.at("cells"), 600);
  EXPECT_GT(json.at("triangles"), 0);
  EXPECT_GT(json.at("section_triangles"), 0);
}

TEST_F(cli_render_tetra, draws_isosurfaces_and_sections_alone) {
  EXPECT_GT(report({"--isovalue", "4.1"}).at("triangles"), 0);
  const nlohmann::json section = report({"--section", "4,4,4:1,1,0.5", "--max-error", "0"});
  EXPECT_GT(section.at("section_triangles"), 100);
  EXPECT_LT(section.at("cells"), section.at("reference_cells"));
  const nlohmann::json both =
      report({"--section", "4,4,4:1,1,0.5", "--opacity", "smoke", "--max-error", "0"});
  EXPECT_EQ(both.at("cells"), both.at("reference_cells"));
  EXPECT_EQ(section.at("section_triangles"), both.at("section_triangles"));
  const nlohmann::json lines =
      report({"--wireframe", "--points", "--boundary", "--max-error", "0"});
  EXPECT_GT(lines.at("lines"), 9 * 9 * 9 * 7 - 1000);
  EXPECT_GT(report({"--boundary"}).at("cells"), 0);
  EXPECT_FALSE(report({"--isovalue", "1e4"}).at("warnings").empty());
}

TEST_F(cli_render_tetra, draws_the_boundary_in_the_colours_of_the_field) {
  const nlohmann::json field = report({"--boundary=field", "--max-error", "0"});
  EXPECT_EQ(field.at("boundary_triangles"), 6 * 8 * 8 * 2);
  EXPECT_EQ(field.at("cells"), field.at("reference_cells"));
  const std::string picture = read_bytes(output_);
  // It is what is drawn where nothing else is named.
  EXPECT_EQ(report({"--max-error", "0"}).at("boundary_triangles"), field.at("boundary_triangles"));
  EXPECT_EQ(read_bytes(output_), picture);
  EXPECT_EQ(report({"--boundary", "--max-error", "0"}).at("boundary_triangles"), 0);
  EXPECT_NE(read_bytes(output_), picture);
}

TEST_F(cli_render_tetra, has_a_legend_where_colours_stand_for_values) {
  const auto drawn = [&](const Words& options) { return picture("400x300", options); };
  for (const Words& shown : {Words{"--boundary=field"}, {"--section", "0,0,1,3.5"}}) {
    Words without = shown;
    without.insert(without.end(), {"--legend", "off"});
    Words with = shown;
    with.insert(with.end(), {"--legend", "on"});
    EXPECT_NE(drawn(shown), drawn(without)) << shown[0];
    EXPECT_EQ(drawn(shown), drawn(with)) << shown[0];
  }
  EXPECT_EQ(drawn({"--isovalue", "4.1"}), drawn({"--isovalue", "4.1", "--legend", "off"}));
  expect_refused({"--boundary", "--legend", "maybe"}, "--legend: expected on or off");
}

/// hexahedra() with a second field, twice x.
std::string hexahedra_of_two_fields() {
  std::string text = hexahedra() + "SCALARS ramp float\nLOOKUP_TABLE default\n";
  for (int i = 0; i < 9 * 9 * 9; ++i) text += fmt::format("{}\n", 2 * (i % 9));
  return text;
}

TEST_F(cli_render_tetra, may_have_the_colours_of_another_field) {
  write_bytes(input_, hexahedra_of_two_fields());
  const auto drawn = [&](Words options) {
    options.insert(options.end(), {"--max-error", "0"});
    return picture("90x70", options);
  };
  // Of cells as they are, what is cut or round them has the other field's colours whichever it is.
  for (const Words& shown : {Words{"--boundary=field"}, {"--section", "0,0,1,3.5"}}) {
    Words by = shown;
    by.insert(by.end(), {"--field", "wave", "--color-by", "ramp"});
    Words of = shown;
    of.insert(of.end(), {"--field", "ramp"});
    EXPECT_EQ(drawn(by), drawn(of)) << shown[0];
    by.insert(by.end(), {"--color-range", "4:9"});
    of.insert(of.end(), {"--color-range", "4:9"});
    EXPECT_EQ(drawn(by), drawn(of)) << shown[0];
  }
  const Words surface{"--isovalue", "4.1", "--field", "wave"};
  Words by = surface;
  by.insert(by.end(), {"--color-by", "ramp"});
  EXPECT_NE(drawn(by), drawn(surface));
  const nlohmann::json json =
      report({"--isovalue", "4.1", "--field", "wave", "--color-by", "ramp"});
  EXPECT_EQ(json.at("color_by"), "ramp");
  EXPECT_EQ(json.at("color_range"), nlohmann::json({0, 16}));
}

TEST_F(cli_render_tetra, of_colours_that_nothing_has_are_refused) {
  write_bytes(input_, hexahedra_of_two_fields());
  expect_refused({"--field", "wave", "--wireframe", "--color-by", "ramp"}, "--color-by: expected");
  expect_refused({"--field", "wave", "--isovalue", "4.1", "--color-by", "other"}, "other");
  expect_refused({"--field", "wave", "--isovalue", "4.1", "--color-by", "wave"},
                 "--color-by: expected one scalar of another field");
  expect_refused({"--isovalue", "4.1", "--color-by", "wave"}, "--color-by: expected --field");
  expect_refused({"--field", "wave", "--isovalue", "4.1", "--color-by", "ramp", "--color", "red"},
                 "--color-by: expected no --color");
  expect_refused({"--field", "wave", "--isovalue", "4.1", "--color-range", "1:2"},
                 "--color-range: expected");
  expect_refused({"--field", "wave", "--boundary=field", "--color-range", "2:2"},
                 "--color-range: expected a smaller");
}

TEST_F(cli_render_tetra, is_fine_where_it_is_asked_to_be) {
  const auto cells = [&](const Words& foci) {
    Words words{"--boundary", "--max-error", "0"};
    words.insert(words.end(), foci.begin(), foci.end());
    return report(words).at("cells").get<int>();
  };
  const int all = cells({});
  const int base = cells({"--ball", "-9,-9,-9,0"});
  for (const Words& focus :
       {Words{"--box", "0,1,0,1,0,1"}, {"--ball", "1,1,1,1"}, {"--half-space", "2,0,0:-1,0,0"}}) {
    EXPECT_LT(cells(focus), all) << focus[0];
    EXPECT_GT(cells(focus), base) << focus[0];
  }
  EXPECT_GT(cells({"--ball", "1,1,1,1", "--max-error-outside", "0"}), cells({"--ball", "1,1,1,1"}));
  expect_refused({"--boundary", "--half-space", "1,2,3:0,0,0"}, "--half-space: expected a normal");
  expect_refused({"--boundary", "--max-error-outside", "1"}, "--half-space");
  expect_refused({"--boundary", "--region", "one"}, "--region: expected");
}

/// The same of waves on 25^3 points, in a .lode file.
class cli_render_waves : public cli_render_tetra {
 protected:
  cli_render_waves() {
    Progress progress;
    const std::string mesh = scratch_ / "waves.vtu";
    EXPECT_TRUE(write_vtu(mesh, waves(25), {.value_name = "wave"}, progress));
    input_ = scratch_ / "waves.lode";
    EXPECT_EQ(run_lode({"build", mesh, input_}).exit_code, 0);
  }
};

TEST_F(cli_render_waves, are_as_fine_outside_of_foci_as_is_said) {
  const auto largest = [&](const Words& shown, const Words& outside) {
    Words words = shown;
    words.insert(words.end(), outside.begin(), outside.end());
    const nlohmann::json json = report(words);
    EXPECT_LE(json.at("achieved_error"), json.at("max_error"));
    return json.at("largest_error").get<double>();
  };
  const std::string knots = scratch_ / "knots.txt";
  write_bytes(knots, "27 1 1 1 0\n30 1 1 1 1\n");
  // Of sections the planes are the focus, of transfer functions what is not clear.
  for (const Words& shown : {Words{"--section", "0,0,1,0.3"}, {"--opacity", knots}}) {
    Words words = shown;
    words.insert(words.end(), {"--max-error", "0.1"});
    EXPECT_GT(largest(words, {}), 0.2) << shown[0];
    EXPECT_LE(largest(words, {"--max-error-outside", "0.2"}), 0.2) << shown[0];
  }
  expect_refused({"--section", "0,0,1,0.3", "--opacity", knots, "--max-error-outside", "1"},
                 "--max-error-outside: expected a focus");
}

TEST_F(cli_render_waves, are_fine_where_their_own_camera_or_another_looks) {
  const std::string near = scratch_ / "near.json";
  write_bytes(near, R"({"eye": [-30, -20, 2], "target": [2, 2, 2], "up": [0, 0, 1],
                        "field_of_view_deg": 4})");
  const std::string far = scratch_ / "far.json";
  write_bytes(far, R"({"eye": [-60, -45, 2], "target": [12, 12, 12], "up": [0, 0, 1],
                       "field_of_view_deg": 60})");
  const auto look = [&](const std::string& tolerance, const Words& options) {
    Words words{"--isovalue", "2.6", "--max-error", tolerance};
    words.insert(words.end(), options.begin(), options.end());
    return report(words);
  };
  for (const std::string& tolerance : oracles::trials(Words{"0", "0.5"}, Words{"0.5"})) {
    const nlohmann::json whole = look(tolerance, {"--camera", near, "--view", far});
    const std::string picture = read_bytes(output_);
    const nlohmann::json part = look(tolerance, {"--camera", near});
    EXPECT_EQ(read_bytes(output_), picture);  // What is coarse is out of sight.
    EXPECT_LT(part.at("cells"), whole.at("cells"));
    EXPECT_LE(part.at("achieved_error"), std::stod(tolerance));
    const auto cells = [&](const Words& options) { return look(tolerance, options).at("cells"); };
    EXPECT_EQ(cells({"--camera", far, "--view", near, "--view-size", "60x50"}), part.at("cells"));
    EXPECT_EQ(cells({"--view", near, "--view-size", "60x50"}), part.at("cells"));
    // The size of the picture is that of the view.
    EXPECT_GT(cells({"--camera", near, "--view", near, "--view-size", "200x40"}), part.at("cells"));
  }
  EXPECT_GT(look("0.1", {"--camera", near}).at("largest_error"), 0.2);
  EXPECT_LE(look("0.1", {"--camera", near, "--max-error-outside", "0.2"}).at("largest_error"), 0.2);
  expect_refused({"--boundary", "--view-size", "60x50"}, "--view-size: expected --view");
  expect_refused({"--boundary", "--camera", near, "--view-size", "6x5"}, "--view-size: expected");
  expect_refused({"--boundary", "--view", scratch_ / "none.json"}, "none.json");
  expect_refused({"--boundary", "--camera", near, "--max-error-px", "1"}, "space errors");
  expect_refused({"--boundary", "--max-error-px", "1"}, "of a picture --camera");
  input_ = scratch_ / "in_space.lode";
  ASSERT_EQ(run_lode({"build", scratch_ / "waves.vtu", input_, "--space-errors"}).exit_code, 0);
  const nlohmann::json seen = report({"--boundary", "--camera", far, "--max-error-px", "4"});
  EXPECT_LE(seen.at("achieved_px"), 4);
  EXPECT_LE(report({"--boundary", "--max-space-error", "0.5"}).at("achieved_space_error"), 0.5);
}

TEST_F(cli_render_tetra, shows_what_is_in_a_threshold_and_what_a_deadline_leaves_time_for) {
  const nlohmann::json warm = report({"--boundary", "--threshold", "2:5", "--max-error", "0"});
  const Finished extracted = run_lode({"extract", input_, scratch_ / "out.vtu", "--mesh",
                                       "--threshold", "2:5", "--max-error", "0", "--json"});
  for (const char* const key : {"cells", "left_out", "achieved_error"})
    EXPECT_EQ(warm.at(key), extracted.json().at(key)) << key;
  EXPECT_GT(warm.at("cells"), 100);
  EXPECT_GT(warm.at("left_out"), 100);
  const nlohmann::json none = report({"--boundary", "--isovalue", "4", "--threshold", "90:91"});
  EXPECT_EQ(none.at("cells"), 0);
  EXPECT_EQ(none.at("warnings").size(), 2U);
  expect_refused({"--boundary", "--threshold", "5:2"}, "--threshold: expected A <= B");
  const nlohmann::json whole = report({"--boundary", "--deadline-ms", "60000"});
  EXPECT_EQ(whole.at("cells"), whole.at("reference_cells"));
  EXPECT_TRUE(whole.at("is_settled"));
  const nlohmann::json base = report({"--boundary", "--deadline-ms", "0"});
  EXPECT_FALSE(base.at("is_settled"));
  EXPECT_LT(base.at("cells").get<int>(), whole.at("cells").get<int>() / 10);
  expect_refused({"--boundary", "--deadline-ms", "-1"}, "--deadline-ms");
}

TEST_F(cli_render_tetra, reads_transfer_functions_from_files_and_looks_through_saved_cameras) {
  const std::string knots = scratch_ / "knots.txt";
  write_bytes(knots, "0 1 0 0 0.1\n5 1 1 1 2 # bright\n");
  const std::string camera = scratch_ / "camera.json";
  const nlohmann::json first = report({"--opacity", knots, "--save-camera", camera});
  const std::string picture = read_bytes(output_);
  EXPECT_EQ(report({"--opacity", knots, "--camera", camera, "--threads", "3"}).at("camera"),
            first.at("camera"));
  EXPECT_EQ(read_bytes(output_), picture);
}

TEST_F(cli_render_tetra, says_what_it_does_not_draw) {
  expect_refused({"--boundary=skin"}, "--boundary: expected film or field, got 'skin'");
  expect_refused({"--opacity", "fog"}, "expected one of viridis-smoke, smoke");
  expect_refused({"--opacity", "smoke", "--section", "0,0,0,1"}, "--section: expected a normal");
  expect_refused({"--opacity", "smoke", "--section", "0,0,1"}, "A,B,C,D");
  expect_refused({"--opacity", "smoke", "--clip", "0,1,0,1,0,1"}, "--clip");
  expect_refused({"--opacity", "smoke", "--nodata", "1"},
                 "--nodata: expected a volume or terrain, got a mesh of cells");
  expect_refused({"--opacity", "smoke", "--field", "other"}, "other");
  expect_refused({"--opacity", "smoke", "--max-cells", "none"}, "--max-cells");
  const std::string broken = scratch_ / "broken.txt";
  write_bytes(broken, "1 0 0 0 1\n0 0 0 0 1\n");
  expect_refused({"--opacity", broken}, "expected ascending values");
  const std::string ball = scratch_ / "ball.nrrd";
  write_ball(ball);
  const Finished run = run_lode({"render", ball, output_, "--isovalue", "9", "--opacity", "smoke"});
  EXPECT_NE(run.err.find("expected a mesh of cells"), std::string::npos) << run.err;
  for (const Words& words :
       {Words{"--threshold", "1:2"}, {"--deadline-ms", "9"}, {"--view", "c.json"}}) {
    Words all{"render", ball, output_, "--isovalue", "9"};
    all.insert(all.end(), words.begin(), words.end());
    EXPECT_NE(run_lode(all).err.find("expected a mesh of cells"), std::string::npos) << words[0];
  }
}

}  // namespace
}  // namespace lode::test
