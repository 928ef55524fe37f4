#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_camera_path, draws_a_frame_for_each_camera) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  write_bytes(scratch / "path.json",
              R"([{"eye": [8, -40, 8], "target": [8, 8, 8]},
                  {"eye": [8, -20, 9], "target": [8, 8, 8]},
                  {"eye": [8, 7, 9], "target": [8, 30, 8]}])");
  const Finished run =
      run_lode({"render", scratch / "ball.nrrd", scratch / "last.png", "--isovalue", "100",
                "--size", "40x30", "--samples", "1", "--camera-path", scratch / "path.json",
                "--frames", scratch / "frames", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json frames = run.json().at("camera_path").at("frames");
  ASSERT_EQ(frames.size(), 3U);
  for (const auto& frame : frames) EXPECT_LE(frame.at("achieved_px").get<double>(), 1);
  for (const char* name : {"frame-0000.png", "frame-0001.png", "frame-0002.png"})
    EXPECT_TRUE(std::filesystem::exists(scratch / ("frames/" + std::string(name))));
}

TEST(cli_camera_path, leaves_nothing_where_a_path_is_wrong) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  write_bytes(scratch / "path.json", R"([{"eye": [8, 8, 8], "target": [8, 8, 8]}])");
  expect_refusal(
      run_lode({"render", scratch / "ball.nrrd", scratch / "last.png", "--isovalue", "100",
                "--camera-path", scratch / "path.json", "--frames", scratch / "frames", "--quiet"}),
      1, {"path.json", "frame 0"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "frames"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "last.png"));
}

TEST(cli_camera_path, refuses_what_makes_no_sense) {
  const auto refused = [](Words options, const Words& words) {
    options.insert(options.begin(), {"render", "a.lode", "a.png"});
    expect_refusal(run_lode(options), 2, words);
  };
  refused({"--isovalue", "1", "--camera-path", "orbit"}, {"--camera-path", "--frames"});
  refused({"--isovalue", "1", "--frames", "f"}, {"--frames", "--camera-path"});
  refused({"--isovalue", "1,2", "--camera-path", "orbit", "--frames", "f"}, {"--isovalue", "2"});
  refused({"--isovalue", "1", "--camera-path", "orbit", "--frames", "f", "--max-error-px", "0"},
          {"--max-error-px"});
  refused({"--isovalue", "1", "--camera-path", "orbit", "--frames", "f", "--flip"}, {"--flip"});
}

}  // namespace
}  // namespace lode::test
