// Pictures of meshes of cells through moving cameras.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/cli/tetra_fixture.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// Waves in two regions, in a .lode file.
class cli_tetra_path : public testing::Test {
 protected:
  cli_tetra_path() { build("half-edge"); }

  void build(const char* placement) const {
    SimplexMesh mesh = waves(13);
    for (const auto& cell : mesh.tetrahedra)
      mesh.regions.push_back(mesh.positions[cell[0]][0] < 6 ? 1 : 2);
    const std::string file = scratch_ / "waves.vtu";
    Progress progress;
    ASSERT_TRUE(write_vtu(file, mesh, {.value_name = "wave"}, progress));
    const Finished built =
        run_lode({"build", file, input_, "--space-errors", "--placement", placement});
    ASSERT_EQ(built.exit_code, 0) << built.err;
  }
  [[nodiscard]] Finished render(const Words& options) const {
    Words words{"render", input_, output_, "--size", "40x30", "--samples", "1", "--json"};
    words.insert(words.end(), options.begin(), options.end());
    return run_lode(words);
  }
  [[nodiscard]] nlohmann::json report(const Words& options) const {
    const Finished run = render(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  /// The report of a path, in place of the frames that were there.
  [[nodiscard]] nlohmann::json film(const std::string& path, const Words& options) const {
    std::filesystem::remove_all(frames_);
    Words words = options;
    words.insert(words.end(), {"--camera-path", path, "--frames", frames_});
    return report(words);
  }
  [[nodiscard]] std::string frame(std::size_t i) const {
    return read_bytes(fmt::format("{}/frame-{:04}.png", frames_, i));
  }
  /// Cameras far and near, outside and inside, of which one comes twice.
  [[nodiscard]] std::string path() const {
    const std::string file = scratch_ / "path.json";
    write_bytes(file, R"([{"eye": [-30, -20, 9], "target": [6, 6, 6]},
                          {"eye": [-8, -9, 7], "target": [6, 6, 6]},
                          {"eye": [5, 4, 6], "target": [12, 12, 6], "field_of_view_deg": 20},
                          {"eye": [5, 4, 6], "target": [12, 12, 6], "field_of_view_deg": 20},
                          {"eye": [30, 41, 2], "target": [6, 6, 3], "field_of_view_deg": 9}])");
    return file;
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "waves.lode";
  std::string output_ = scratch_ / "out.png";
  std::string frames_ = scratch_ / "frames";
};

TEST_F(cli_tetra_path, frames_are_the_pictures_of_their_cameras) {
  const std::string camera = scratch_ / "camera.json";
  for (const char* const placement : {"half-edge", "midpoint"}) {
    std::filesystem::remove(input_);
    build(placement);
    for (const Words& options :
         {Words{"--isovalue", "2.6", "--max-error", "0.2"},
          {"--isovalue", "2.6,5", "--section", "0,0,1,5.5", "--opacity", "viridis-smoke",
           "--max-cells", "3000"},
          {"--wireframe", "--points", "--boundary", "--max-error-px", "3"},
          {"--boundary", "--threshold", "2:9", "--max-error", "0", "--max-error-outside", "20%"},
          {"--section", "0,0,1,5.5", "--opacity", "smoke", "--region", "2"}}) {
      Words with_threads = options;
      with_threads.insert(with_threads.end(), {"--threads", "3"});
      const nlohmann::json made = film(path(), with_threads).at("camera_path");
      EXPECT_EQ(made.at("view"), "each frame's");
      ASSERT_EQ(made.at("frames").size(), 5U);
      // The first, and one that is where another was, in a fast run.
      for (const std::size_t i :
           oracles::trials<std::vector<std::size_t>>({0, 1, 2, 3, 4}, {0, 3})) {
        SCOPED_TRACE(fmt::format("{} {} frame {}", placement, options[0], i));
        const nlohmann::json& told = made.at("frames")[i];
        write_bytes(camera, told.at("camera").dump());
        Words alone = options;
        alone.insert(alone.end(), {"--camera", camera, "--threads", "1"});
        const nlohmann::json one = report(alone);
        EXPECT_EQ(read_bytes(output_), frame(i));
        for (const char* const key : {"cells", "achieved_error", "achieved_px", "triangles",
                                      "section_triangles", "lines", "camera"})
          if (told.contains(key)) EXPECT_EQ(told.at(key), one.at(key)) << key;
      }
      EXPECT_GT(made.at("frames")[0].at("updates"), 0);
      // Budgets are filled in order: what came last is done again.
      if (std::ranges::find(options, "--max-cells") == options.end())
        EXPECT_EQ(made.at("frames")[3].at("updates"), 0);
    }
  }
}

TEST_F(cli_tetra_path, small_steps_take_few_updates) {
  const Words options{"--isovalue", "2.6", "--max-error", "0.1"};
  std::string cameras = "[";
  for (int i = 0; i < 8; ++i)
    cameras +=
        fmt::format(R"({}{{"eye": [{}, -14, 7], "target": [{}, 6, 6], "field_of_view_deg": 20}})",
                    i == 0 ? "" : ", ", 4 + 0.2 * i, 4 + 0.2 * i);
  const std::string file = scratch_ / "steps.json";
  write_bytes(file, cameras + "]");
  const nlohmann::json made = film(file, options).at("camera_path").at("frames");
  const auto first = made[0].at("updates").get<int>();
  EXPECT_GT(first, 100);
  for (std::size_t i = 1; i < made.size(); ++i) EXPECT_LT(made[i].at("updates"), first / 3) << i;
  // Named paths are about the mesh, and all of it is in sight of the first camera.
  const nlohmann::json in = film("fly-in", options).at("camera_path").at("frames");
  EXPECT_EQ(in.size(), 200U);
  EXPECT_EQ(in[0].at("cells"), report(options).at("cells"));
}

TEST_F(cli_tetra_path, has_one_mesh_where_the_view_is_another) {
  const std::string view = scratch_ / "view.json";
  write_bytes(view, R"({"eye": [-30, -20, 9], "target": [2, 2, 2], "field_of_view_deg": 9})");
  const nlohmann::json made =
      film(path(), {"--boundary", "--view", view, "--max-error", "0"}).at("camera_path");
  EXPECT_EQ(made.at("view"), "one for all frames");
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(made.at("frames")[i].at("cells"), made.at("frames")[0].at("cells"));
    EXPECT_EQ(made.at("frames")[i].at("updates") == 0, i > 0);
  }
}

TEST_F(cli_tetra_path, the_picture_is_that_of_the_first_camera_or_of_its_own) {
  const std::string saved = scratch_ / "saved.json";
  const nlohmann::json made = film(path(), {"--boundary", "--save-camera", saved});
  EXPECT_EQ(read_bytes(output_), frame(0));
  EXPECT_EQ(made.at("camera"), made.at("camera_path").at("frames")[0].at("camera"));
  write_bytes(saved, made.at("camera_path").at("frames")[4].at("camera").dump());
  static_cast<void>(film(path(), {"--boundary", "--camera", saved}));
  EXPECT_EQ(read_bytes(output_), frame(4));
  EXPECT_NE(read_bytes(output_), frame(0));
}

TEST_F(cli_tetra_path, keeps_deadlines) {
  const Words exact{"--boundary", "--max-error", "0"};
  const auto within = [&](const char* ms) {
    Words words = exact;
    words.insert(words.end(), {"--deadline-ms", ms});
    return film(path(), words).at("camera_path").at("frames");
  };
  const nlohmann::json all = film(path(), exact).at("camera_path").at("frames");
  const nlohmann::json in_time = within("60000");
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_TRUE(in_time[i].at("is_settled"));
    EXPECT_EQ(in_time[i].at("cells"), all[i].at("cells"));
  }
  const nlohmann::json at_once = within("0");
  for (const auto& frame : at_once) {
    EXPECT_FALSE(frame.at("is_settled"));
    EXPECT_EQ(frame.at("updates"), 0);
  }
}

TEST_F(cli_tetra_path, says_in_words_what_frames_took) {
  const Finished run =
      run_lode({"render", input_, output_, "--isovalue", "99", "--size", "8x6", "--samples", "1",
                "--max-error-px", "2", "--camera-path", path(), "--frames", frames_});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* const words :
       {"5 in ", "updates of frames", "a frame in the mean", "pixels of frames", "cells of frames"})
    EXPECT_NE(run.out.find(words), std::string::npos) << words << "\n" << run.out;
  EXPECT_NE(run.err.find("5 of 5 frames, first frame-0000.png: no surface at isovalue 99"),
            std::string::npos)
      << run.err;
}

TEST_F(cli_tetra_path, refuses_what_makes_no_sense_and_leaves_nothing) {
  const auto expect_refused = [&](const Words& options, const Words& words) {
    const std::vector<std::string> before = scratch_.files();
    const Finished run = render(options);
    EXPECT_NE(run.exit_code, 0);
    for (const std::string& word : words)
      EXPECT_NE(run.err.find(word), std::string::npos) << word << ": " << run.err;
    EXPECT_EQ(scratch_.files(), before);
  };
  const std::string cameras = path();
  expect_refused({"--boundary", "--camera-path", "orbit"}, {"--camera-path", "--frames"});
  expect_refused({"--boundary", "--frames", frames_}, {"--frames", "--camera-path"});
  expect_refused({"--boundary", "--max-error-px", "1"}, {"--max-error-px", "--camera-path"});
  expect_refused({"--boundary", "--camera-path", "orbit", "--frames", scratch_.path()},
                 {"frames alone", output_});
  std::filesystem::create_directory(scratch_ / "full");
  write_bytes(scratch_ / "full/frame-0000.png", "an older one");
  expect_refused({"--boundary", "--camera-path", "orbit", "--frames", scratch_ / "full"},
                 {"empty directory"});
  expect_refused({"--boundary=skin", "--camera-path", "orbit", "--frames", frames_},
                 {"--boundary", "'skin'"});
  expect_refused({"--boundary", "--camera-path", "zigzag", "--frames", frames_}, {"zigzag"});
  expect_refused({"--boundary", "--camera-path", "orbit", "--frames", frames_, "--region", "none"},
                 {"none"});
  expect_refused({"--boundary", "--progressive", frames_}, {"--progressive"});
  const std::string broken = scratch_ / "broken.json";
  write_bytes(broken, R"([{"eye": [8, 9, 9], "target": [8, 8, 8]},
                          {"eye": [8, 8, 8], "target": [8, 8, 8]}])");
  expect_refused({"--boundary", "--camera-path", broken, "--frames", frames_},
                 {"broken.json", "frame 1"});
  ASSERT_EQ(run_lode({"build", scratch_ / "waves.vtu", scratch_ / "plain.lode"}).exit_code, 0);
  const Finished plain =
      run_lode({"render", scratch_ / "plain.lode", output_, "--boundary", "--max-error-px", "1",
                "--camera-path", "orbit", "--frames", frames_});
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_NE(plain.err.find("--space-errors"), std::string::npos) << plain.err;
  EXPECT_FALSE(std::filesystem::exists(frames_));
}

TEST_F(cli_tetra_path, is_stopped_between_frames_and_in_them) {
  const std::vector<std::string> before = scratch_.files();
  const Words words{"render", input_,          output_, "--opacity", "smoke", "--size",
                    "32x24",  "--camera-path", "jump",  "--frames",  frames_, "--max-error",
                    "0",      "--threads",     "1"};
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(run_lode(words).exit_code, 0);
  const auto whole = std::chrono::steady_clock::now() - start;
  int n_stopped = 0;
  for (const int eighth : oracles::trials<std::vector<int>>({0, 1, 2, 3, 4, 5, 6, 7}, {1, 4})) {
    std::filesystem::remove_all(frames_);
    std::filesystem::remove(output_);
    Running running(words);
    std::this_thread::sleep_for(whole * eighth / 8);
    running.send(SIGINT);
    const Finished run = running.finish();
    if (run.exit_code == 0) continue;
    ++n_stopped;
    EXPECT_EQ(run.exit_code, 128 + SIGINT) << run.err;
    EXPECT_EQ(scratch_.files(), before);
  }
  EXPECT_GT(n_stopped, 0);
}

}  // namespace
}  // namespace lode::test
