// --vertical-crs and --to-vertical-crs, in the commands that take terrain.
#include <gtest/gtest.h>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

/// 5 x 5 heights at 45 north, 10 east, in the format of SRTM, which has a CRS.
void write_tile(const std::string& path) {
  std::string bytes;
  for (int i = 0; i < 25; ++i) {
    bytes += '\1';
    bytes += static_cast<char>(i * i % 41);
  }
  write_bytes(path, bytes);
}

class cli_vertical_crs : public testing::Test {
 protected:
  cli_vertical_crs() : tile_(scratch_ / "N45E010.hgt") { write_tile(tile_); }

  Scratch scratch_;
  std::string tile_;
};

TEST_F(cli_vertical_crs, is_said_by_info_and_kept_by_rasters_contours_and_models) {
  EXPECT_TRUE(run_lode({"info", tile_, "--json"}).json().at("vertical_crs").is_null());
  const Words to_feet{"--vertical-crs", "EPSG:5703", "--to-vertical-crs", "EPSG:6360"};
  const auto with = [&](Words words) {
    words.insert(words.end(), to_feet.begin(), to_feet.end());
    return words;
  };
  const auto info = run_lode(with({"info", tile_, "--json"})).json();
  EXPECT_EQ(info.at("vertical_crs"), "NAVD88 height (ftUS)");
  EXPECT_EQ(info.at("vertical_unit"), "US survey foot");
  EXPECT_EQ(info.at("vertical_transformation").at("accuracy"), 0);
  EXPECT_NEAR(info.at("range").at(0).get<double>(), 256 * 3937 / 1200.0, 1e-9);
  ASSERT_EQ(run_lode(with({"build", tile_, scratch_ / "dem.lode", "--levels", "1"})).exit_code, 0);
  const auto raster = run_lode(with({"extract", tile_, scratch_ / "dem.tif", "--max-error", "1"}));
  ASSERT_EQ(raster.exit_code, 0) << raster.err;
  for (const char* made : {"dem.lode", "dem.tif"})
    EXPECT_EQ(run_lode({"info", scratch_ / made, "--json"}).json().at("vertical_crs"),
              "NAVD88 height (ftUS)");
  for (const char* out : {"lines.gpkg", "lines.geojson"})
    EXPECT_EQ(run_lode(with({"contours", tile_, scratch_ / out, "--interval", "10"})).exit_code, 0);
  const Words verify{"verify", tile_, "--surface", scratch_ / "dem.ply", "--max-error", "1"};
  ASSERT_EQ(run_lode(with({"extract", tile_, scratch_ / "dem.ply", "--max-error", "1"})).exit_code,
            0);
  EXPECT_EQ(run_lode(with(verify)).exit_code, 0) << "errors hold where heights are";
  EXPECT_EQ(run_lode(verify).exit_code, 1);
}

TEST_F(cli_vertical_crs, of_depths_is_refused_where_what_is_above_counts) {
  const auto with = [&](Words words, Words more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const Words sight{"sight", tile_, "--from", "10.1,45.1", "--to", "10.9,45.9"};
  const Words render{"render", tile_, scratch_ / "dem.png", "--size", "64x48"};
  const Words depths{"--vertical-crs", "EPSG:5715"};
  const Words heights{"--vertical-crs", "EPSG:5715", "--to-vertical-crs", "EPSG:5714"};
  for (const Words& command : {sight, render}) {
    expect_refusal(run_lode(with(command, depths)), 1, {"MSL depth", "--to-vertical-crs"});
    EXPECT_EQ(run_lode(with(command, heights)).exit_code, 0);
  }
  EXPECT_EQ(run_lode(with({"info", tile_}, depths)).exit_code, 0);
}

TEST_F(cli_vertical_crs, warns_where_a_file_says_something_else) {
  ASSERT_EQ(run_lode({"extract", tile_, scratch_ / "dem.tif", "--max-error", "1", "--vertical-crs",
                      "EPSG:5773"})
                .exit_code,
            0);
  const Finished run =
      run_lode({"info", scratch_ / "dem.tif", "--vertical-crs", "EPSG:6360", "--json"});
  EXPECT_EQ(run.json().at("vertical_crs"), "NAVD88 height (ftUS)");
  EXPECT_NE(run.err.find("EGM96 height in metre; NAVD88 height (ftUS)"), std::string::npos)
      << run.err;
}

TEST_F(cli_vertical_crs, refuses_what_cannot_be_meant) {
  expect_refusal(run_lode({"info", tile_, "--vertical-crs", "EPSG:4326"}), 1,
                 {"N45E010.hgt", "vertical CRS", "WGS 84"});
  expect_refusal(run_lode({"info", tile_, "--to-vertical-crs", "ellipsoid"}), 1,
                 {"N45E010.hgt", "--vertical-crs"});
  expect_refusal(
      run_lode({"info", tile_, "--vertical-crs", "EPSG:5773", "--to-vertical-crs", "EPSG:3855"}), 1,
      {"N45E010.hgt", "us_nga_egm08_25.tif", "PROJ_DATA"});
  ASSERT_EQ(run_lode({"build", tile_, scratch_ / "dem.lode", "--levels", "1"}).exit_code, 0);
  expect_refusal(run_lode({"info", scratch_ / "dem.lode", "--vertical-crs", "EPSG:5773"}), 2,
                 {"dem.lode", "heights"});
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode({"info", scratch_ / "ball.nrrd", "--vertical-crs", "EPSG:5773"}), 2,
                 {"ball.nrrd", "--vertical-crs"});
}

}  // namespace
}  // namespace lode::test
