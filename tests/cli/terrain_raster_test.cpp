// Rasters that `lode extract` writes of terrain.
#include <gtest/gtest.h>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_terrain_raster, has_the_grid_of_the_raster_that_is_read_and_the_largest_difference) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto made = run_lode({"extract", dem, scratch / "near.tif", "--max-error", "10",
                              "--difference", scratch / "less.tif", "--json"})
                        .json();
  EXPECT_EQ(made.at("outputs").size(), 2U);
  const auto& raster = made.at("raster");
  EXPECT_EQ(raster.at("type"), "float32");
  EXPECT_EQ(raster.at("columns"), 40);
  EXPECT_EQ(raster.at("heights"), 40 * 30 - 1);
  EXPECT_EQ(raster.at("nodata"), -9999);
  EXPECT_EQ(raster.at("error_kind"), "measured at samples");
  EXPECT_LE(raster.at("error").get<double>(), 10);
  EXPECT_GT(raster.at("error").get<double>(), 1);
  // Read again it is a raster like the one before, and so are the differences.
  const auto before = run_lode({"info", dem, "--json"}).json();
  const auto after = run_lode({"info", scratch / "near.tif", "--json"}).json();
  for (const char* key : {"to_world", "columns", "rows", "missing_samples", "cells"})
    EXPECT_EQ(after.at(key), before.at(key)) << key;
  EXPECT_EQ(after.at("type"), "float32");
  const auto less = run_lode({"info", scratch / "less.tif", "--json"}).json();
  EXPECT_EQ(less.at("missing_samples"), 1);
  EXPECT_EQ(std::max(-less.at("range").at(0).get<double>(), less.at("range").at(1).get<double>()),
            raster.at("error").get<double>());
}

TEST(cli_terrain_raster, comes_of_files_of_lode_and_of_points_too) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  ASSERT_EQ(run_lode({"build", dem, scratch / "dem.lode", "--levels", "20,5"}).exit_code, 0);
  const auto made = run_lode({"extract", scratch / "dem.lode", scratch / "near.tif", "--max-error",
                              "5", "--json"})
                        .json();
  EXPECT_EQ(made.at("raster").at("error_kind"), "bound at samples");
  EXPECT_LE(made.at("raster").at("error").get<double>(), 5);
  EXPECT_EQ(run_lode({"info", scratch / "near.tif", "--json"}).json().at("to_world"),
            run_lode({"info", dem, "--json"}).json().at("to_world"));
  write_bytes(scratch / "points.xyz", "0 0 1\n9 0 2\n9 7 3\n0 7 4\n4 4 9\n");
  const auto points = run_lode({"extract", scratch / "points.xyz", scratch / "points.tif",
                                "--max-error", "0", "--cell", "1", "--json"})
                          .json();
  EXPECT_EQ(points.at("raster").at("columns"), 9);
  EXPECT_EQ(points.at("raster").at("rows"), 7);
  EXPECT_EQ(points.at("raster").at("heights"), 63);
  EXPECT_EQ(points.at("raster").at("error_kind"), "of the TIN at points");
}

/// What models keep all heights, and what they are of, has the differences of the raster itself.
TEST(cli_terrain_raster, of_files_of_lode_has_differences_from_what_they_are_of) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string lode = scratch / "dem.lode";
  const std::string less = scratch / "less.tif";
  write_dem(dem);
  const auto extract = [&](const std::string& input, std::vector<std::string> more) {
    more.insert(more.begin(), {"extract", input, scratch / "near.tif", "--max-error", "10"});
    more.insert(more.end(), {"--difference", less, "--json"});
    return run_lode(more);
  };
  for (const char* model :
       {"delaunay_pyramid", "restricted_quadtree", "right_triangle_bisection"}) {
    SCOPED_TRACE(model);
    const bool has_heights = std::string(model) != "delaunay_pyramid";
    ASSERT_EQ(run_lode({"build", dem, lode, "--model", model, "--levels", "10"}).exit_code, 0);
    if (!has_heights)
      expect_refusal(run_lode({"extract", lode, scratch / "near.tif", "--max-error", "10",
                               "--difference", less}),
                     1, {"dem.lode", "raster that the model is of"});
    const Finished run = has_heights ? extract(lode, {}) : extract(lode, {"--against", dem});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto raster = run.json().at("raster");
    EXPECT_EQ(raster.at("error_kind"), "measured at samples");
    EXPECT_LE(raster.at("error").get<double>(), 10);
    const auto read = run_lode({"info", less, "--json"}).json();
    EXPECT_EQ(read.at("missing_samples"), 1);
    EXPECT_EQ(std::max(-read.at("range").at(0).get<double>(), read.at("range").at(1).get<double>()),
              raster.at("error").get<double>());
    const std::string of_file = read_bytes(less);
    // The same as of the raster, of which the model is built first.
    const Finished of_raster = extract(dem, {"--model", model});
    ASSERT_EQ(of_raster.exit_code, 0) << of_raster.err;
    EXPECT_EQ(of_raster.json().at("raster").at("error"), raster.at("error"));
    EXPECT_EQ(of_raster.json().at("raster").at("error_kind"), "measured at samples");
  }
}

TEST(cli_terrain_raster, refuses_another_raster_than_the_model_is_of) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string lode = scratch / "dem.lode";
  write_dem(dem);
  ASSERT_EQ(run_lode({"build", dem, lode, "--levels", "10"}).exit_code, 0);
  const auto extract = [&](const std::string& input, const std::string& against,
                           bool has_difference = true) {
    std::vector<std::string> words{"extract",   input,  scratch / "near.tif", "--max-error", "10",
                                   "--against", against};
    if (has_difference) words.insert(words.end(), {"--difference", scratch / "less.tif"});
    return run_lode(words);
  };
  write_dem(scratch / "small.asc", 40, 29);
  expect_refusal(extract(lode, scratch / "small.asc"), 1, {"small.asc", "40 x 30", "40 x 29"});
  write_bytes(scratch / "far.asc",
              read_bytes(dem).replace(read_bytes(dem).find("500000"), 6, "500030"));
  expect_refusal(extract(lode, scratch / "far.asc"), 1, {"far.asc", "elsewhere"});
  std::string heights = read_bytes(dem);
  heights.replace(heights.rfind(' '), 1, " 9");  // the last one is far higher
  write_bytes(scratch / "high.asc", heights);
  expect_refusal(extract(lode, scratch / "high.asc"), 1, {"high.asc", "is of", "from it"});
  expect_refusal(extract(dem, dem), 2, {"--against", ".lode"});
  expect_refusal(extract(lode, dem, false), 2, {"--against", "--difference"});
  expect_refusal(extract(lode, lode), 2, {"--against", "raster"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "near.tif"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "less.tif"));
}

TEST(cli_terrain_raster, refuses_what_cannot_be_meant) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string out = scratch / "out.tif";
  const std::string less = scratch / "less.tif";
  write_dem(dem);
  write_bytes(scratch / "points.xyz", "0 0 1\n9 0 2\n9 7 3\n");
  const std::string points = scratch / "points.xyz";
  expect_refusal(run_lode({"extract", points, out}), 2, {"points.xyz", "--cell"});
  expect_refusal(run_lode({"extract", points, out, "--cell", "0"}), 2, {"--cell", "> 0"});
  expect_refusal(run_lode({"extract", points, out, "--cell", "1", "--difference", less}), 2,
                 {"--difference"});
  expect_refusal(run_lode({"extract", points, out, "--cell", "1e-9"}), 1, {"points.xyz", "2^32"});
  expect_refusal(run_lode({"extract", dem, scratch / "out.ply", "--cell", "1"}), 2,
                 {"out.ply", "--cell", ".tif"});
  expect_refusal(run_lode({"extract", dem, out, "--difference", out}), 2, {"out.tif", "differ"});
  expect_refusal(run_lode({"extract", dem, out, "--difference", scratch / "less.png"}), 2,
                 {"--difference", ".tif"});
  expect_refusal(run_lode({"extract", dem, scratch / "out.jpg"}), 2, {"out.jpg", ".tif"});
  expect_refusal(run_lode({"extract", dem, scratch / "none/out.tif"}), 1, {"none/out.tif"});
  write_ball(scratch / "ball.nrrd");
  expect_refusal(run_lode({"extract", scratch / "ball.nrrd", scratch / "b.ply", "--isovalue", "3",
                           "--cell", "1"}),
                 2, {"ball.nrrd", "--cell"});
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.nrrd", "dem.asc", "points.xyz"}));
}

}  // namespace
}  // namespace lode::test
