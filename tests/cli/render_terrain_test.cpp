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

/// What is drawn in pixels is what `extract` gives for the picture's camera.
TEST(cli_render_terrain, keeps_pixels_with_models_that_vary) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string model = scratch / "dem.lode";
  const std::string camera = scratch / "camera.json";
  write_dem(dem);
  ASSERT_EQ(run_lode({"build", dem, model, "--levels", "50,0"}).exit_code, 0);
  const auto draw = [&](const std::string& input, const Words& more) {
    Words words{"render", input, scratch / "out.png", "--size", "320x240", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words).json();
  };
  const auto coarse = draw(model, {"--max-error-px", "6", "--save-camera", camera});
  const auto fine = draw(model, {"--max-error-px", "1.5"});
  EXPECT_EQ(coarse.at("max_error_px"), 6);
  EXPECT_EQ(coarse.at("max_error"), nullptr);
  EXPECT_EQ(coarse.at("error_met"), true);
  EXPECT_LE(coarse.at("achieved_px").get<double>(), 6);
  EXPECT_LE(fine.at("achieved_px").get<double>(), 1.5);
  EXPECT_LT(coarse.at("triangles"), fine.at("triangles"));
  const auto extracted = run_lode({"extract", model, scratch / "seen.ply", "--view", camera,
                                   "--view-size", "320x240", "--max-error-px", "6", "--json"})
                             .json();
  EXPECT_EQ(extracted.at("triangles"), coarse.at("triangles"));
  EXPECT_EQ(draw(dem, {"--max-error-px", "6", "--model", "right_triangle_bisection", "--top"})
                .at("max_error_px"),
            6);
  // A tolerance of heights holds there, too.
  EXPECT_GT(draw(model, {"--max-error-px", "6", "--max-error", "1"}).at("triangles"),
            coarse.at("triangles"));
  EXPECT_EQ(draw(dem, {}).at("max_error_px"), nullptr);
  const std::string out = scratch / "none.png";
  expect_refusal(run_lode({"render", dem, out, "--max-error-px", "1"}), 2,
                 {"dem.asc", "--max-error-px", "delaunay_pyramid"});
  expect_refusal(run_lode({"render", model, out, "--max-error-px", "-1"}), 2, {"--max-error-px"});
  expect_refusal(
      run_lode({"render", dem, out, "--max-error-px", "1", "--model", "restricted_quadtree"}), 2,
      {"dem.asc", "--max-error-px"});
  write_ball(scratch / "ball.nrrd");
  expect_refusal(
      run_lode({"render", scratch / "ball.nrrd", out, "--isovalue", "3", "--max-error-px", "1"}), 2,
      {"--max-error-px", "--camera-path"});
  expect_refusal(run_lode({"render", model, out, "--max-error-px", "1", "--max-cells", "50"}), 2,
                 {"--max-error-px", "--max-cells"});
}

TEST(cli_render_terrain, refuses_what_cannot_be_meant) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string out = scratch / "dem.png";
  write_dem(dem);
  write_ball(scratch / "ball.nrrd");
  expect_refusal(run_lode({"render", dem, out, "--isovalue", "3"}), 2,
                 {"--isovalue", "got terrain"});
  expect_refusal(run_lode({"render", dem, out, "--exaggeration", "0"}), 2, {"--exaggeration"});
  expect_refusal(run_lode({"render", dem, out, "--contours", "x"}), 2, {"--contours"});
  expect_refusal(run_lode({"render", dem, out, "--contours", "1e-20", "--quiet"}), 1, {"contours"});
  expect_refusal(run_lode({"render", dem, scratch / "dem.jpg"}), 2, {".png"});
  expect_refusal(run_lode({"render", dem, out, "--top", "--camera", "c.json"}), 2, {"--top"});
  expect_refusal(run_lode({"render", scratch / "ball.nrrd", out, "--isovalue", "3", "--top"}), 2,
                 {"--top", "expected terrain, got a volume"});
  write_dem(scratch / "row.asc", 40, 1);
  expect_refusal(run_lode({"render", scratch / "row.asc", out}), 1, {"row.asc", "40 x 1"});
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.nrrd", "dem.asc", "row.asc"}));
}

}  // namespace
}  // namespace lode::test
