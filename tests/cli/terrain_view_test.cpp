// Meshes for a view, through the program: its cameras are those of pictures.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/cli/ball_fixture.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

/// A raster, a .lode file of it, and the camera of its picture.
class cli_terrain_view : public testing::Test {
 protected:
  cli_terrain_view() {
    write_dem(dem_);
    EXPECT_EQ(run_lode({"build", dem_, model_, "--levels", "50,0"}).exit_code, 0);
    EXPECT_EQ(run_lode({"render", dem_, scratch_ / "dem.png", "--save-camera", camera_, "--size",
                        "160x120"})
                  .exit_code,
              0);
  }
  Finished extract(const Words& more, const std::string& input = "") {
    Words words{"extract", input.empty() ? model_ : input, surface_};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  }
  nlohmann::json report(Words more, const std::string& input = "") {
    more.emplace_back("--json");
    const Finished run = extract(more, input);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  const std::string camera_ = scratch_ / "camera.json";
  const std::string surface_ = scratch_ / "seen.ply";
};

TEST_F(cli_terrain_view, extracts_what_a_saved_camera_needs_and_says_so) {
  const Words view{"--view", camera_, "--view-size", "1600x1200"};
  const auto with = [&](const Words& more) {
    Words words = view;
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const auto made = report(with({"--max-error-px", "1"}));
  EXPECT_EQ(made.at("is_uniform"), false);
  EXPECT_EQ(made.at("error_met"), true);
  EXPECT_EQ(made.at("max_error"), nullptr);
  EXPECT_EQ(made.at("max_error_px"), 1);
  EXPECT_LE(made.at("achieved_px").get<double>(), 1);
  EXPECT_GT(made.at("achieved_px").get<double>(), 0.5);
  const auto& seen = made.at("focus").at("view");
  EXPECT_EQ(seen.at("size"), "1600x1200");
  EXPECT_EQ(seen.at("exaggeration"), 1);
  EXPECT_EQ(seen.at("exaggeration_is_default"), true);
  EXPECT_EQ(seen.at("height_unit_is_known"), false);
  EXPECT_EQ(seen.at("shown_triangles"), made.at("triangles")) << "all of it is in its picture";
  EXPECT_EQ(seen.at("camera"), nlohmann::json::parse(read_bytes(camera_)));
  EXPECT_NE(made.at("warnings").dump().find("taken for metres"), std::string::npos);
  const auto n = [](const nlohmann::json& of) { return of.at("triangles").get<int>(); };
  EXPECT_LT(n(report(with({"--max-error-px", "8"}))), n(made));
  EXPECT_LT(n(report({"--view", camera_, "--view-size", "160x120", "--max-error-px", "1"})),
            n(made));
  EXPECT_GT(n(report(with({"--max-error-px", "1", "--exaggeration", "4"}))), n(made));
  EXPECT_NE(read_bytes(surface_).find("max_error_px 1 in view"), std::string::npos);
  // Of the raster, by a model made for this.
  EXPECT_EQ(n(report(with({"--max-error-px", "1", "--model", "delaunay_pyramid"}), dem_)), n(made));
}

TEST_F(cli_terrain_view, joins_tolerances_of_heights_pixels_and_places) {
  const auto n = [&](const Words& more) {
    Words words{"--view", camera_};
    words.insert(words.end(), more.begin(), more.end());
    return report(words).at("triangles").get<int>();
  };
  // As of volumes: without pixels --max-error holds in the view, here everywhere.
  const auto uniform = report({"--max-error", "20"}).at("triangles").get<int>();
  EXPECT_EQ(n({"--max-error", "20"}), uniform);
  EXPECT_EQ(n({"--max-error", "20", "--max-error-px", "500"}), uniform);
  const int coarse = n({"--max-error-px", "500"});
  EXPECT_LT(coarse, uniform);
  EXPECT_EQ(n({"--max-error-px", "500", "--max-error-outside", "20"}), uniform);
  const Words box{"--max-error", "20",    "--max-error-px",
                  "500",         "--box", "500000,500300,4000000,4000300"};
  const int boxed = n(box);
  EXPECT_GT(boxed, coarse);
  EXPECT_LT(boxed, uniform);
  EXPECT_GT(n({"--max-error", "2", "--max-error-px", "500", "--focus-point", "500600,4000400",
               "--growth", "0.5"}),
            coarse);
  const Finished raster = run_lode({"extract", model_, scratch_ / "seen.tif", "--view", camera_,
                                    "--max-error-px", "2", "--json"});
  EXPECT_EQ(raster.exit_code, 0) << raster.err;
  EXPECT_LE(raster.json().at("achieved_px").get<double>(), 2);
}

TEST_F(cli_terrain_view, says_when_nothing_is_seen_or_the_model_is_too_coarse) {
  write_bytes(scratch_ / "away.json", R"({"eye": [0, 0, 5000], "target": [0, 9, 9000]})");
  const auto away = report({"--view", scratch_ / "away.json", "--max-error-px", "0.1"});
  EXPECT_EQ(away.at("focus").at("view").at("shown_triangles"), 0);
  EXPECT_EQ(away.at("achieved_px"), 0);
  EXPECT_EQ(away.at("triangles"), report({"--max-error", "1e6"}).at("triangles"));
  EXPECT_NE(away.at("warnings").dump().find("shows no terrain"), std::string::npos);
  ASSERT_EQ(run_lode({"build", dem_, model_, "--levels", "40"}).exit_code, 0);
  const auto coarse = report({"--view", camera_, "--max-error-px", "1"});
  EXPECT_EQ(coarse.at("error_met"), false);
  EXPECT_GT(coarse.at("achieved_px").get<double>(), 1);
  EXPECT_NE(coarse.at("warnings").dump().find("built within"), std::string::npos);
}

TEST_F(cli_terrain_view, refuses_what_cannot_be_meant) {
  const auto refused = [&](const Words& more, int exit_code, const Words& why) {
    expect_refusal(extract(more), exit_code, why);
  };
  refused({"--max-error-px", "1"}, 2, {"--max-error-px", "--view"});
  refused({"--view-size", "10x10"}, 2, {"--view-size", "--view"});
  refused({"--exaggeration", "2"}, 2, {"--exaggeration", "--view"});
  refused({"--view", camera_, "--view-size", "3"}, 2, {"--view-size"});
  refused({"--view", camera_, "--max-error-px", "-1"}, 2, {"--max-error-px", ">= 0"});
  refused({"--view", camera_, "--exaggeration", "0"}, 2, {"--exaggeration", "> 0"});
  refused({"--view", camera_, "--max-cells", "100"}, 2, {"--max-cells", "--view", "one tolerance"});
  refused({"--view", camera_, "--deadline-ms", "100"}, 2, {"--deadline-ms"});
  refused({"--view", scratch_ / "none.json"}, 1, {"none.json", "cannot open"});
  write_bytes(scratch_ / "bad.json", R"({"eye": [0, 0, 1]})");
  refused({"--view", scratch_ / "bad.json"}, 1, {"bad.json", "target"});
  write_bytes(scratch_ / "bad.json", R"({"eye": [0, 0, 1], "target": [0, 0, 1]})");
  refused({"--view", scratch_ / "bad.json"}, 1, {"bad.json", "same point"});
  write_bytes(scratch_ / "bad.json", "eye");
  refused({"--view", scratch_ / "bad.json"}, 1, {"bad.json", "JSON"});
  expect_refusal(run_lode({"extract", model_, camera_ + ".ply", "--view", camera_ + ".ply"}), 2,
                 {"camera.json.ply"});
  const Words view{"--view", camera_, "--max-error-px", "1"};
  expect_refusal(extract(view, dem_), 2, {"delaunay_pyramid", "got a focus"});
  Words words = view;
  words.insert(words.end(), {"--model", "restricted_quadtree"});
  expect_refusal(extract(words, dem_), 1, {"restricted_quadtree", "got a focus"});
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(extract({"--isovalue", "3", "--exaggeration", "2"}, scratch_ / "ball.nrrd"), 2,
                 {"--exaggeration", "terrain"});
}

}  // namespace
}  // namespace lode::test
