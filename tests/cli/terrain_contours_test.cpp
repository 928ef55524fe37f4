// lode contours: lines at heights of the TIN of a raster of heights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/api/files.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

class cli_terrain_contours : public testing::Test {
 protected:
  cli_terrain_contours() : dem_(scratch_ / "dem.asc") { write_dem(dem_); }

  /// The same with a CRS beside it, which GDAL reads.
  [[nodiscard]] std::string with_crs() const {
    write_dem_crs(scratch_ / "dem.prj");
    return dem_;
  }

  Scratch scratch_;
  std::string dem_;
};

TEST_F(cli_terrain_contours, go_to_every_format_with_the_same_lines) {
  const std::string dem = with_crs();
  const auto run = [&](const char* name) {
    return run_lode({"contours", dem, scratch_ / name, "--interval", "50", "--base", "10",
                     "--max-error", "5", "--json"})
        .json();
  };
  const auto gpkg = run("lines.gpkg");
  const auto geojson = run("lines.geojson");
  const auto vtp = run("lines.vtp");
  EXPECT_GT(gpkg.at("lines").get<int>(), 10);
  EXPECT_GT(gpkg.at("rings").get<int>(), 0);
  EXPECT_EQ(gpkg.at("uphill"), "left");
  for (const char* key : {"levels", "lines", "rings", "points"}) {
    EXPECT_EQ(geojson.at(key), gpkg.at(key));
    EXPECT_EQ(vtp.at(key), gpkg.at(key));
  }
  EXPECT_TRUE(read_bytes(scratch_ / "lines.gpkg").starts_with("SQLite format 3"));
  const auto features = nlohmann::json::parse(read_bytes(scratch_ / "lines.geojson"));
  EXPECT_EQ(features.at("type"), "FeatureCollection");
  EXPECT_FALSE(features.contains("crs")) << "RFC 7946";
  EXPECT_EQ(features.at("features").size(), gpkg.at("lines"));
  double last = -1e9;
  for (const auto& feature : features.at("features")) {
    const double height = feature.at("properties").at("height").get<double>();
    EXPECT_GE(height, last);
    last = height;
    EXPECT_EQ(std::remainder(height - 10, 50), 0);
    EXPECT_EQ(feature.at("geometry").at("type"), "LineString");
    for (const auto& at : feature.at("geometry").at("coordinates")) {
      EXPECT_NEAR(at[0].get<double>(), -117, 0.02);
      EXPECT_NEAR(at[1].get<double>(), 36.15, 0.02);
    }
  }
  // A line is one cell, not as many as it has pieces.
  EXPECT_NE(read_bytes(scratch_ / "lines.vtp").find("NumberOfLines=\"" + gpkg.at("lines").dump()),
            std::string::npos);
  const auto surface = read_surface(scratch_ / "lines.vtp");
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_EQ(surface->lines.size() + gpkg.at("lines").get<std::size_t>(), gpkg.at("points"));
}

TEST_F(cli_terrain_contours, lie_within_the_error_of_the_samples) {
  const auto json = run_lode({"contours", dem_, scratch_ / "lines.vtp", "--isovalue", "800,1000.5",
                              "--isovalue", "650", "--max-error", "0", "--json"})
                        .json();
  EXPECT_EQ(json.at("levels"), 3);
  const auto surface = read_surface(scratch_ / "lines.vtp");
  ASSERT_TRUE(surface);
  for (std::uint32_t v = 0; v < surface->positions.size(); ++v) {
    const Vec3d at = surface->world_position(v);
    EXPECT_TRUE(at[2] == 650 || at[2] == 800 || at[2] == 1000.5);
    const double x = (at[0] - 500015) / 30;
    const double y = 29 - (at[1] - 4000015) / 30;
    // The function between samples differs from planes by its second derivative times 1 / 8 in
    // either direction, 300 (0.04 + 0.09) / 8 * 2, and by 0.5 for rounded samples.
    EXPECT_NEAR(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y), at[2], 11);
  }
}

TEST_F(cli_terrain_contours, have_coordinates_in_float64_in_vtp) {
  ASSERT_EQ(run_lode({"contours", dem_, scratch_ / "lines.vtp", "--isovalue", "800.1",
                      "--max-error", "0"})
                .exit_code,
            0);
  const auto placed = read_placed_surface(scratch_ / "lines.vtp");
  ASSERT_TRUE(placed) << placed.error().message;
  ASSERT_FALSE(placed->places.empty());
  for (const Vec3d& place : placed->places) EXPECT_EQ(place[2], 800.1);
}

TEST_F(cli_terrain_contours, are_the_same_bytes_for_any_number_of_threads) {
  for (const char* n : {"1", "4"})
    ASSERT_EQ(run_lode({"contours", dem_, scratch_ / (std::string(n) + ".vtp"), "--interval", "20",
                        "--threads", n})
                  .exit_code,
              0);
  EXPECT_EQ(read_bytes(scratch_ / "1.vtp"), read_bytes(scratch_ / "4.vtp"));
}

/// Twice the area that a ring of GeoJSON turns left round, in degrees.
double ring_area(const nlohmann::json& ring) {
  double area = 0;
  for (std::size_t i = 1; i < ring.size(); ++i)
    area += (ring[i - 1][0].get<double>() + 117) * (ring[i][1].get<double>() - 36.15) -
            (ring[i - 1][1].get<double>() - 36.15) * (ring[i][0].get<double>() + 117);
  return area;
}

TEST_F(cli_terrain_contours, of_bands_fill_the_domain) {
  const std::string dem = with_crs();
  const std::string out = scratch_ / "bands.geojson";
  const auto json = run_lode({"contours", dem, out, "--interval", "100", "--polygons",
                              "--max-error", "5", "--json"})
                        .json();
  const auto features = nlohmann::json::parse(read_bytes(out)).at("features");
  EXPECT_EQ(features.size(), json.at("polygons"));
  double area = 0;
  std::size_t n_holes = 0;
  for (const auto& feature : features) {
    EXPECT_LT(feature.at("properties").at("lower").get<double>(),
              feature.at("properties").at("upper").get<double>());
    const auto& rings = feature.at("geometry").at("coordinates");
    n_holes += rings.size() - 1;
    EXPECT_GT(ring_area(rings[0]), 0) << "outer rings turn left";
    for (const auto& ring : rings) area += ring_area(ring);
  }
  EXPECT_EQ(json.at("holes"), n_holes);
  // 39 x 29 cells of 30 m, less four round the missing sample; a degree of latitude and longitude
  // there, from the radii of curvature at 36.15.
  const double metres = 110962.0 * 89992.0;
  EXPECT_NEAR(area / 2 * metres / (900.0 * (39 * 29 - 4)), 1, 0.01);
  ASSERT_EQ(run_lode({"contours", dem, scratch_ / "bands.gpkg", "--isovalue", "900", "--polygons"})
                .exit_code,
            0);
}

TEST_F(cli_terrain_contours, refuse_what_cannot_be_meant) {
  const std::string out = scratch_ / "out.gpkg";
  const auto refuse = [&](Words options, const std::vector<std::string>& words, int code = 2) {
    options.insert(options.begin(), {"contours", dem_});
    expect_refusal(run_lode(options), code, words);
  };
  refuse({out}, {"--interval", "neither"});
  refuse({out, "--interval", "5", "--isovalue", "3"}, {"--interval", "both"});
  refuse({out, "--interval", "0"}, {"--interval", "> 0"});
  refuse({out, "--interval", "nan"}, {"--interval"});
  refuse({out, "--isovalue", "3", "--base", "1"}, {"--base"});
  refuse({out, "--isovalue", "3,4,3"}, {"--isovalue", "3 twice"});
  refuse({out, "--isovalue", "3,,4"}, {"--isovalue"});
  refuse({scratch_ / "out.shp", "--interval", "5"}, {"out.shp", ".gpkg"});
  refuse({scratch_ / "out.ply", "--interval", "5"}, {"out.ply", ".vtp"});
  for (const char* name : {"out.vtp", "out.shp"})
    refuse({scratch_ / name, "--interval", "5", "--polygons"},
           {"--polygons", ".gpkg or .geojson", name});
  refuse({out, "--interval", "1e-9"}, {"--interval", "at most"}, 1);
  refuse({scratch_ / "out.geojson", "--interval", "50"}, {"out.geojson", "CRS", ".gpkg"}, 1);
  refuse({"/none/such/out.gpkg", "--interval", "50"}, {"out.gpkg"}, 1);
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode({"contours", scratch_ / "ball.nrrd", out, "--interval", "5"}), 2,
                 {"ball.nrrd", "lode extract --isovalue"});
  auto files = scratch_.files();
  EXPECT_EQ(files, (std::vector<std::string>{"ball.nrrd", "dem.asc"}));
}

TEST_F(cli_terrain_contours, warn_where_there_are_none) {
  const Finished run =
      run_lode({"contours", dem_, scratch_ / "out.gpkg", "--isovalue", "5000", "--json"});
  EXPECT_EQ(run.json().at("lines"), 0);
  EXPECT_NE(run.err.find("there are no contours"), std::string::npos) << run.err;
}

TEST(cli_contours_of_no_crs, are_lines_for_terrain_of_none) {
  const Scratch scratch;
  write_dem(scratch / "dem.asc");
  const std::string lines = scratch / "lines.gpkg";
  ASSERT_EQ(run_lode({"contours", scratch / "dem.asc", lines, "--interval", "200"}).exit_code, 0);
  const Finished run = run_lode({"extract", scratch / "dem.asc", scratch / "out.ply", "--max-error",
                                 "50", "--breaklines", lines, "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(run.json().at("lines").at("breaklines").at("lines"), 0);
}

TEST(cli_contours_of_no_crs, are_in_degrees_once_it_is_told) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string lines = scratch / "lines.geojson";
  write_dem(dem);
  Words words{"contours", dem, lines, "--interval", "200"};
  expect_refusal(run_lode(words), 1, {"dem.asc", "--crs"});
  words.insert(words.end(), {"--crs", "EPSG:32611"});
  ASSERT_EQ(run_lode(words).exit_code, 0);
  Words lined{"extract", dem, scratch / "out.ply", "--max-error", "50", "--breaklines", lines};
  expect_refusal(run_lode(lined), 1, {"lines.geojson", "--crs"});
  lined.insert(lined.end(), {"--crs", "EPSG:32611", "--json"});
  const auto json = run_lode(lined).json();
  EXPECT_EQ(json.at("lines").at("breaklines").at("outside"), 0);
  EXPECT_GT(json.at("lines").at("edges"), 0);
  write_dem_crs(scratch / "dem.prj");
  lined[lined.size() - 2] = "EPSG:4326";
  lined.pop_back();
  expect_refusal(run_lode(lined), 1, {"dem.asc", "one of its own", "EPSG:4326"});
}

}  // namespace
}  // namespace lode::test
