// Scattered points as input of all commands of terrain.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/cli/program.h"
#include "tests/io/point_files.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

using io::test::LasFile;
using io::test::LasPoint;

/// 600 points of a hill in 200 by 150 m, every fifth of class 5, 20 m higher.
LasFile hill() {
  LasFile las{.geo_keys = {1, 1, 0, 2, 3072, 0, 1, 32633, 4099, 0, 1, 9001}};
  std::uint32_t random = 1;
  const auto below = [&](std::int32_t n) {
    random = random * 1664525 + 1013904223;
    return static_cast<std::int32_t>((random >> 8) % static_cast<std::uint32_t>(n));
  };
  for (int i = 0; i < 600; ++i) {
    const std::int32_t x = below(20000);
    const std::int32_t y = below(15000);
    const double z = 5000 * std::exp(-(std::pow(x - 9000, 2) + std::pow(y - 8000, 2)) / 2e7);
    const bool is_tree = i % 5 == 0;
    las.points.push_back({{x, y, static_cast<std::int32_t>(z) + (is_tree ? 2000 : 0)},
                          static_cast<std::uint8_t>(is_tree ? 5 : 2)});
  }
  return las;
}

class cli_points : public testing::Test {
 protected:
  cli_points() : las_(scratch_ / "hill.las") { write_bytes(las_, hill().bytes()); }

  Scratch scratch_;
  std::string las_;
};

TEST_F(cli_points, info_says_what_there_is_and_what_is_left_out) {
  const auto json = run_lode({"info", las_, "--class", "2", "--json"}).json();
  EXPECT_EQ(json.at("format"), "LAS 1.2, format 0");
  EXPECT_EQ(json.at("points_in_file"), 600);
  EXPECT_EQ(json.at("classes").at("5"), 120);
  EXPECT_EQ(json.at("left_out").at("other_classes"), 120);
  EXPECT_EQ(json.at("lattice_step"), 0.01);
  EXPECT_LE(json.at("largest_move").get<double>(), 1e-8);
  EXPECT_EQ(json.at("vertical_unit"), "m");
  EXPECT_NE(json.at("crs").get<std::string>().find("UTM zone 33N"), std::string::npos);
}

TEST_F(cli_points, extracts_a_tin_that_verify_finds_within_the_error) {
  for (const std::vector<std::string>& domain : {std::vector<std::string>{},
                                                 {"--max-edge", "25"},
                                                 {"--class", "2", "--duplicates", "max"}}) {
    const std::string out = scratch_ / "hill.ply";
    std::vector<std::string> extract{"extract", las_, out, "--max-error", "0.5", "--json"};
    extract.insert(extract.end(), domain.begin(), domain.end());
    const auto json = run_lode(extract).json();
    EXPECT_LE(json.at("achieved_error").get<double>(), 0.5);
    EXPECT_GT(json.at("triangles").get<int>(), 100);
    for (const char* max_error : {"0.5", "0.2"}) {
      std::vector<std::string> verify{"verify",      las_,      "--surface", out,
                                      "--max-error", max_error, "--json"};
      verify.insert(verify.end(), domain.begin(), domain.end());
      EXPECT_EQ(run_lode(verify).exit_code == 0, std::string(max_error) == "0.5");
    }
  }
}

TEST_F(cli_points, answers_all_questions) {
  const auto heights =
      run_lode({"height", las_, "--at", "500090,4000080", "--at", "1,2", "--json"}).json();
  EXPECT_EQ(heights.at("outside"), 1);
  EXPECT_GT(heights.at("points").at(0).at("height").get<double>(), 40);
  const auto profile =
      run_lode({"profile", las_, "--from", "500010,4000020", "--to", "500150,4000110", "--json"})
          .json();
  EXPECT_EQ(profile.at("parts"), 1);
  EXPECT_EQ(profile.at("distance_unit"), "metre");
  const auto contours = run_lode({"contours", las_, scratch_ / "c.geojson", "--class", "2",
                                  "--interval", "10", "--json"})
                            .json();
  EXPECT_GT(contours.at("lines").get<int>(), 3);
  const auto sight = run_lode({"sight", las_, "--from", "500010,4000080", "--to", "500180,4000080",
                               "--class", "2", "--exact", "--json"})
                         .json();
  EXPECT_EQ(sight.at("verdict"), "blocked");
  const auto render =
      run_lode({"render", las_, scratch_ / "hill.png", "--size", "64x48", "--json"}).json();
  EXPECT_EQ(render.at("outputs").size(), 1U);
}

TEST_F(cli_points, become_models_of_all_tolerances) {
  const std::string file = scratch_ / "hill.lode";
  const std::string out = scratch_ / "hill.ply";
  for (const std::string model :
       {"delaunay_pyramid", "ternary_triangulation", "implicit_delaunay_pyramid",
        "adaptive_triangulation", "hierarchical_delaunay"}) {
    SCOPED_TRACE(model);
    std::vector<std::string> build{"build",   las_, file,         "--model", model,
                                   "--class", "2",  "--max-edge", "30",      "--json"};
    const bool has_own_levels = model == "implicit_delaunay_pyramid";
    if (!has_own_levels) build.insert(build.end(), {"--levels", "8,1,0.2"});
    const auto built = run_lode(build).json();
    if (has_own_levels)
      EXPECT_GT(built.at("levels").size(), 3U);
    else
      EXPECT_EQ(built.at("levels").size(), 3U);
    EXPECT_EQ(built.at("classes").at("5"), 120);
    EXPECT_EQ(built.at("fixed_edges"), 0);
    EXPECT_EQ(run_lode({"verify", file}).exit_code, 0);
    EXPECT_EQ(
        run_lode({"verify", file, "--against", las_, "--class", "2", "--max-edge", "30"}).exit_code,
        0);
    expect_refusal(run_lode({"verify", file, "--against", las_}), 1,
                   {"hill.las", "read as it was"});
    // One of history with levels of its own, and one hierarchy, are asked in a fast run.
    if (!oracles::trials(true, has_own_levels || model == "adaptive_triangulation")) continue;
    const auto info = run_lode({"info", file, "--json"}).json();
    EXPECT_EQ(info.at("is_of_points"), true);
    EXPECT_EQ(info.at("type"), "points");
    EXPECT_EQ(info.at("vertical_unit"), "m");
    EXPECT_EQ(run_lode({"extract", file, out, "--max-error", "0.5"}).exit_code, 0);
    // Vertices of hierarchies need not be points.
    const bool is_hierarchy = model[0] == 'a' || model[0] == 'h';
    EXPECT_EQ(run_lode({"verify", las_, "--surface", out, "--max-error", "0.5", "--class", "2",
                        "--max-edge", "30", "--model", model})
                  .exit_code,
              is_hierarchy ? 2 : 0);
    const auto fine = run_lode({"extract", file, out, "--max-error", "0.2", "--json"}).json();
    const auto focused = run_lode({"extract", file, out, "--max-error", "0.2", "--focus-point",
                                   "500050,4000050", "--growth", "0.05", "--json"})
                             .json();
    EXPECT_LT(focused.at("triangles"), fine.at("triangles"));
    const auto height =
        run_lode({"height", file, "--at", "500090,4000080", "--max-error", "1", "--json"}).json();
    EXPECT_GT(height.at("points").at(0).at("height").get<double>(), 40);
    expect_refusal(run_lode({"extract", file, out, "--class", "2"}), 2, {"hill.lode"});
    const Words features{"features", file, scratch_ / "f.gpkg", "--feature-relief", "1", "--json"};
    if (has_own_levels) {
      // It has all points.
      Words of_points = features;
      of_points[1] = las_;
      of_points.insert(of_points.end(), {"--class", "2", "--max-edge", "30"});
      const auto found = run_lode(features).json();
      const auto wanted = run_lode(of_points).json();
      for (const char* key : {"euler_number", "triangles", "kept"})
        EXPECT_EQ(found.at(key), wanted.at(key)) << key;
    } else {
      EXPECT_NE(run_lode(features).exit_code, 0);
    }
    expect_refusal(run_lode({"extract", file, scratch_ / "hill.tif"}), 1, {"a cell"});
    EXPECT_EQ(
        run_lode({"contours", las_, scratch_ / "c.gpkg", "--model", model, "--interval", "10"})
            .exit_code,
        0);
  }
  expect_refusal(run_lode({"build", las_, file, "--model", "restricted_quadtree"}), 2,
                 {"hill.las", "scattered points", "delaunay_pyramid"});
  expect_refusal(run_lode({"build", las_, file, "--band", "1"}), 2, {"--band", "points"});
}

TEST_F(cli_points, takes_text_with_an_outline_and_a_crs) {
  std::string text = "lon lat depth\n";
  for (int i = 0; i < 400; ++i)
    text += std::to_string(i % 20 * 0.01 + 10) + ' ' + std::to_string(i / 20 * 0.01 + 50) + ' ' +
            std::to_string(-(i % 7) * 10) + '\n';
  write_bytes(scratch_ / "sea.xyz", text);
  write_bytes(scratch_ / "part.csv", "x,y\n10.002,50.005\n10.105,50.005\n10.105,50.108\n");
  const auto extracted = [&](const char* outline) {
    return run_lode({"extract", scratch_ / "sea.xyz", scratch_ / "sea.ply", "--outline",
                     scratch_ / outline, "--crs", "EPSG:4326", "--max-error", "0", "--json"})
        .json();
  };
  const auto json = extracted("part.csv");
  EXPECT_EQ(json.at("positions"), 55);
  EXPECT_EQ(json.at("left_out").at("outside_outline"), 345);
  EXPECT_EQ(json.at("vertices"), 55);
  EXPECT_EQ(json.at("triangles"), 81);
  EXPECT_EQ(json.at("lattice_step"), 0.01);
  EXPECT_NE(json.at("crs").get<std::string>().find("WGS 84"), std::string::npos);
  // Longitudes a turn away are the same places.
  write_bytes(scratch_ / "turned.csv", "x,y\n370.002,50.005\n370.105,50.005\n370.105,50.108\n");
  EXPECT_EQ(extracted("turned.csv").at("positions"), 55);
}

TEST_F(cli_points, on_both_sides_of_180_degrees_lie_side_by_side) {
  const auto write = [&](const std::string& name, bool is_turned) {
    std::string text;
    for (int i = 0; i < 41 * 9; ++i) {
      const int tenths = 1780 + i % 41;
      const double x = (tenths > 1800 && is_turned ? tenths - 3600 : tenths) / 10.0;
      text += fmt::format("{} {} {}\n", x, 10 + i / 41 * 0.1, (i * 37) % 101);
    }
    write_bytes(scratch_ / name, text);
  };
  write("split.xyz", true);
  write("whole.xyz", false);
  const auto run = [&](const char* command, const std::string& name, Words more) {
    Words words{command, scratch_ / name};
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--crs", "EPSG:4326", "--json"});
    return run_lode(words);
  };
  const Finished split = run("info", "split.xyz", {});
  EXPECT_EQ(split.json().at("turned_points"), 20 * 9);
  EXPECT_NE(split.err.find("split.xyz: points lie on both sides"), std::string::npos) << split.err;
  EXPECT_EQ(run("info", "whole.xyz", {}).json().at("turned_points"), 0);
  EXPECT_EQ(split.json().at("extent").at("x"), (std::vector<double>{178, 182}));
  const auto extracted = [&](const std::string& name, Words more = {}) {
    Words words{scratch_ / (name + ".ply"), "--max-error", "9"};
    words.insert(words.end(), more.begin(), more.end());
    const auto json = run("extract", name, words).json();
    return std::pair{json.at("positions").get<int>(), json.at("triangles").get<int>()};
  };
  EXPECT_EQ(extracted("split.xyz"), extracted("whole.xyz"));
  EXPECT_EQ(extracted("split.xyz", {"--clip", "-180,180,-90,90"}), extracted("whole.xyz"));
  // An outline cuts points as they are.
  write_bytes(scratch_ / "east.csv", "170,0\n180.05,0\n180.05,20\n170,20\n");
  const auto east = run("info", "split.xyz", {"--outline", scratch_ / "east.csv"}).json();
  EXPECT_EQ(east.at("turned_points"), 0);
  EXPECT_EQ(east.at("extent").at("x"), (std::vector<double>{178, 180}));
  for (const char* at : {"179.43,10.33", "-179.57,10.33", "180.43,10.33"}) {
    const auto height = run("height", "split.xyz", {"--at", at}).json();
    const auto expected = run("height", "whole.xyz", {"--at", at}).json();
    EXPECT_EQ(height.at("points"), expected.at("points")) << at;
  }
}

/// From 178 to 182 degrees, beyond 180 as they are there, or a turn on.
std::string points_at_180(bool is_turned) {
  std::string text;
  for (int i = 0; i < 41 * 21; ++i) {
    const int tenths = 1780 + i % 41;
    const double x = (tenths > 1800 && is_turned ? tenths - 3600 : tenths) / 10.0;
    text += fmt::format("{} {} {}\n", x, 10 + i / 41 * 0.1, (i * 37) % 101);
  }
  return text;
}

std::string feature(const std::string& kind, const std::string& coordinates) {
  return R"({"type":"Feature","properties":{},"geometry":{"type":")" + kind +
         R"(","coordinates":[)" + coordinates + "]}}";
}

/// Positions and triangles of a mesh of them.
std::pair<int, int> mesh_at_180(const std::string& points, const std::string& out,
                                const Words& more) {
  Words words{"extract", points, out, "--max-error", "9", "--crs", "EPSG:4326", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const Finished run = run_lode(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto json = run.json();
  return {json.at("positions").get<int>(), json.at("triangles").get<int>()};
}

TEST_F(cli_points, on_both_sides_of_180_degrees_are_turned_with_their_outline) {
  write_bytes(scratch_ / "split.xyz", points_at_180(true));
  write_bytes(scratch_ / "whole.xyz", points_at_180(false));
  const auto extracted = [&](const char* name, const std::string& outline) {
    return mesh_at_180(scratch_ / name, scratch_ / "out.ply", {"--outline", outline});
  };
  const std::string plain = scratch_ / "plain.csv";
  write_bytes(plain, "178.45,10.25\n181.55,10.25\n181.55,11.65\n178.45,11.65\n");
  const auto expected = extracted("whole.xyz", plain);
  // 31 columns, of which those from 180.1 on are turned, and 14 rows.
  EXPECT_EQ(expected.first, 31 * 14);
  const auto ring = [](double west, double east) {
    return fmt::format("[[[{0},10.25],[{1},10.25],[{1},11.65],[{0},11.65],[{0},10.25]]]", west,
                       east);
  };
  const auto geojson = [&](const std::string& name, const std::string& parts) {
    write_bytes(scratch_ / name, feature("MultiPolygon", parts));
    return scratch_ / name;
  };
  // As RFC 7946 has it, as it is forbidden there, and a turn further west.
  for (const std::string& outline :
       {plain, geojson("parts.geojson", ring(178.45, 180) + "," + ring(-180, -178.45)),
        geojson("jump.geojson", ring(178.45, -178.45)),
        geojson("west.geojson", ring(-181.55, -178.45))})
    for (const char* const points : {"split.xyz", "whole.xyz"})
      EXPECT_EQ(extracted(points, outline), expected) << points << " " << outline;
  const auto info = run_lode({"info", scratch_ / "split.xyz", "--outline",
                              scratch_ / "jump.geojson", "--crs", "EPSG:4326", "--json"})
                        .json();
  EXPECT_EQ(info.at("extent").at("x"), (std::vector<double>{178.5, 181.5}));
  EXPECT_EQ(info.at("turned_points"), 15 * 14);
}

TEST_F(cli_points, on_both_sides_of_180_degrees_have_breaklines_that_jump_there) {
  write_bytes(scratch_ / "split.xyz", points_at_180(true));
  write_bytes(scratch_ / "whole.xyz", points_at_180(false));
  write_bytes(scratch_ / "there.geojson", feature("LineString", "[178.52,10.33],[181.41,11.57]"));
  write_bytes(scratch_ / "jumps.geojson", feature("LineString", "[178.52,10.33],[-178.59,11.57]"));
  const auto lined = [&](const char* points, const char* lines) {
    return mesh_at_180(scratch_ / points, scratch_ / "out.ply",
                       {"--breaklines", scratch_ / lines, "--drape"});
  };
  const auto expected = lined("whole.xyz", "there.geojson");
  EXPECT_NE(expected, mesh_at_180(scratch_ / "whole.xyz", scratch_ / "out.ply", {}));
  EXPECT_EQ(lined("whole.xyz", "jumps.geojson"), expected);
  EXPECT_EQ(lined("split.xyz", "jumps.geojson"), expected);
}

TEST_F(cli_points, takes_outlines_of_geojson_with_holes_in_their_own_crs) {
  // The hill is round 500100, 4000075 of zone 33 (15 degrees east): 200 x 150 m.
  const auto ring = [](double west, double east, double south, double north) {
    std::string text;
    for (const auto& [x, y] :
         {std::pair{west, south}, {east, south}, {east, north}, {west, north}, {west, south}})
      text += fmt::format("{}[{},{}]", text.empty() ? "" : ",", x, y);
    return "[" + text + "]";
  };
  const auto geojson = [](const std::string& geometry) {
    return R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":)" +
           geometry + "}]}";
  };
  const std::string outer = ring(15.0004, 15.0018, 36.1444, 36.1452);
  const std::string inner = ring(15.0009, 15.0013, 36.1446, 36.1450);
  write_bytes(scratch_ / "whole.geojson",
              geojson(R"({"type":"Polygon","coordinates":[)" + outer + "]}"));
  write_bytes(scratch_ / "holed.geojson",
              geojson(R"({"type":"Polygon","coordinates":[)" + outer + "," + inner + "]}"));
  write_bytes(scratch_ / "line.geojson",
              geojson(R"({"type":"LineString","coordinates":[[15,36],[15.1,36.1]]})"));
  const auto left_out = [&](const std::string& outline) {
    const auto json = run_lode({"info", las_, "--outline", outline, "--json"}).json();
    return json.at("left_out").at("outside_outline").get<int>();
  };
  const int outside = left_out(scratch_ / "whole.geojson");
  EXPECT_GT(outside, 100);
  EXPECT_LT(outside, 500);
  EXPECT_GT(left_out(scratch_ / "holed.geojson"), outside + 20);
  expect_refusal(run_lode({"info", las_, "--outline", scratch_ / "line.geojson"}), 1,
                 {"line.geojson", "linestring in feature 0"});
  expect_refusal(run_lode({"info", las_, "--outline", scratch_ / "none.gpkg"}), 1, {"none.gpkg"});
  write_bytes(scratch_ / "few.xyz", "0 0 1\n9 0 1\n0 9 1\n");
  expect_refusal(run_lode({"info", scratch_ / "few.xyz", "--outline", scratch_ / "whole.geojson"}),
                 1, {"whole.geojson", "--crs"});
}

TEST_F(cli_points, says_which_heights_are_not_those_of_the_file) {
  write_bytes(scratch_ / "twice.xyz", "0 0 1\n9 0 1\n0 9 1\n0 9 4\n");
  const Finished info = run_lode({"info", scratch_ / "twice.xyz"});
  EXPECT_NE(info.err.find("differ by up to 3; the mean"), std::string::npos) << info.err;
  expect_refusal(run_lode({"info", scratch_ / "twice.xyz", "--duplicates", "error"}), 1,
                 {"twice.xyz", "got 2 at 0, 9"});
}

TEST_F(cli_points, refuses_what_cannot_be_meant) {
  const std::string out = scratch_ / "out.ply";
  const auto extract = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command{"extract", las_, out};
    command.insert(command.end(), more.begin(), more.end());
    return run_lode(command);
  };
  expect_refusal(extract({"--band", "1"}), 2, {"--band", "points"});
  expect_refusal(extract({"--isovalue", "1"}), 2, {"--isovalue", "got terrain"});
  expect_refusal(extract({"--class", "256"}), 2, {"--class"});
  expect_refusal(extract({"--class", "2,,3"}), 2, {"--class"});
  expect_refusal(extract({"--duplicates", "some"}), 2, {"mean", "some"});
  expect_refusal(extract({"--max-edge", "0"}), 2, {"--max-edge"});
  expect_refusal(extract({"--class", "7"}), 1, {"hill.las", "got none"});
  expect_refusal(extract({"--max-edge", "0.001"}), 1, {"hill.las", "got none of"});
  expect_refusal(extract({"--crs", "EPSG:none"}), 1, {"hill.las", "EPSG:none"});
  expect_refusal(extract({"--crs", "EPSG:5773"}), 1,
                 {"hill.las", "geographic or projected", "heights alone", "--vertical-crs"});
  expect_refusal(extract({"--crs", "EPSG:4978"}), 1,
                 {"hill.las", "geographic or projected", "geocentric"});
  expect_refusal(extract({"--outline", scratch_ / "none.csv"}), 1, {"none.csv"});
  write_bytes(scratch_ / "line.xyz", "0 0 1\n1 1 2\n2 2 3\n");
  expect_refusal(run_lode({"extract", scratch_ / "line.xyz", out}), 1,
                 {"line.xyz", "not on one line"});
  write_bytes(scratch_ / "a.asc",
              "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  expect_refusal(run_lode({"extract", scratch_ / "a.asc", out, "--max-edge", "3"}), 2,
                 {"a.asc", "--max-edge", "raster"});
  EXPECT_EQ(std::ranges::count(scratch_.files(), "out.ply"), 0);
}

}  // namespace
}  // namespace lode::test
