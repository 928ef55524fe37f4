// Pictures of rasters of heights, through the program.
#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_render_terrain, draws_a_map_and_a_view_and_says_how) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const std::string map = scratch / "map.png";
  const auto made =
      run_lode({"render", dem, map, "--top", "--contours", "100", "--size", "160x120", "--json"})
          .json();
  EXPECT_EQ(made.at("model"), "delaunay_selector");
  EXPECT_EQ(made.at("exaggeration"), 1);
  EXPECT_EQ(made.at("exaggeration_is_default"), true);
  EXPECT_EQ(made.at("extent_metres"), nlohmann::json({39 * 30.0, 29 * 30.0}));
  EXPECT_GT(made.at("contours").get<int>(), 4);
  EXPECT_LE(made.at("achieved_error").get<double>(), made.at("max_error").get<double>());
  EXPECT_NEAR(made.at("max_error").get<double>(), 0.25 * 39 * 30 / 160, 1e-9);
  EXPECT_TRUE(read_bytes(map).starts_with("\x89PNG"));
  const std::string camera = scratch / "camera.json";
  const Words view{"render", dem, scratch / "view.png", "--size", "160x120", "--max-error", "5"};
  Words saving = view;
  saving.insert(saving.end(), {"--save-camera", camera});
  ASSERT_EQ(run_lode(saving).exit_code, 0);
  Words again = view;
  again[2] = scratch / "again.png";
  again.insert(again.end(), {"--camera", camera, "--threads", "1"});
  ASSERT_EQ(run_lode(again).exit_code, 0);
  EXPECT_EQ(read_bytes(scratch / "view.png"), read_bytes(scratch / "again.png"));
}

TEST(cli_render_terrain, refuses_what_cannot_be_meant) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string out = scratch / "dem.png";
  write_dem(dem);
  write_ball(scratch / "ball.nrrd");
  expect_refusal(run_lode({"render", dem, out, "--isovalue", "3"}), 2, {"--isovalue", "raster"});
  expect_refusal(run_lode({"render", dem, out, "--exaggeration", "0"}), 2, {"--exaggeration"});
  expect_refusal(run_lode({"render", dem, out, "--contours", "x"}), 2, {"--contours"});
  expect_refusal(run_lode({"render", dem, out, "--contours", "1e-20", "--quiet"}), 1, {"contours"});
  expect_refusal(run_lode({"render", dem, scratch / "dem.jpg"}), 2, {".png"});
  expect_refusal(run_lode({"render", dem, out, "--top", "--camera", "c.json"}), 2, {"--top"});
  expect_refusal(run_lode({"render", scratch / "ball.nrrd", out, "--isovalue", "3", "--top"}), 2,
                 {"--top", "raster of heights"});
  write_dem(scratch / "row.asc", 40, 1);
  expect_refusal(run_lode({"render", scratch / "row.asc", out}), 1, {"row.asc", "40 x 1"});
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.nrrd", "dem.asc", "row.asc"}));
}

}  // namespace
}  // namespace lode::test
