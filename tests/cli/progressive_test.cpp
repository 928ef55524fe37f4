#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// Until a file or directory is there, or a minute has passed.
void wait_for(const std::string& path) {
  for (int i = 0; i < 60000 && !std::filesystem::exists(path); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// A ball's .lode file and a directory for steps or frames.
class cli_progressive : public ::testing::Test {
 protected:
  void SetUp() override {
    write_ball(scratch_ / "ball.nrrd");
    const Finished run = run_lode({"build", scratch_ / "ball.nrrd", scratch_ / "ball.lode"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] std::string file(const std::string& name) const { return scratch_ / name; }
  [[nodiscard]] Finished run(const std::string& command, const std::string& output, Words options) {
    options.insert(options.begin(), {command, file("ball.lode"), file(output), "--isovalue=100",
                                     "--progressive", file("steps")});
    return run_lode(options);
  }
  [[nodiscard]] Finished draw(Words options) {
    options.insert(options.end(), {"--size=64x48", "--samples=1"});
    return run("render", "p.png", options);
  }
  [[nodiscard]] bool has_steps() const { return std::filesystem::exists(file("steps")); }

  Scratch scratch_;
};

TEST_F(cli_progressive, writes_a_surface_per_step_and_an_index) {
  const Finished done = run("extract", "s.vtp", {"--max-error=2", "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const auto index = nlohmann::json::parse(read_bytes(file("steps/index.json")));
  EXPECT_EQ(index.at("isovalue"), 100);
  EXPECT_EQ(done.json().at("steps"), index.at("steps"));
  ASSERT_GT(index.at("steps").size(), 2u);
  for (const auto& step : index.at("steps")) {
    const auto surface = read_surface(file("steps/" + step.at("file").get<std::string>()));
    ASSERT_TRUE(surface) << surface.error().message;
    EXPECT_EQ(step.at("triangles"), surface->triangles.size());
    EXPECT_EQ(step.at("vertices"), surface->positions.size());
    EXPECT_LE(step.at("achieved_error"), step.at("max_error"));
    EXPECT_EQ(surface->origins.empty(), step.at("file") == "step-000.vtp");
  }
  EXPECT_EQ(index.at("steps").back().at("max_error"), 2);
  EXPECT_EQ(index.at("steps").back().at("triangles"), done.json().at("triangles"));
  EXPECT_EQ(done.json().at("outputs").size(), index.at("steps").size() + 2);
}

TEST_F(cli_progressive, writes_the_final_surface_as_without_steps) {
  ASSERT_EQ(run("extract", "s.ply", {}).exit_code, 0);
  ASSERT_EQ(run_lode({"extract", file("ball.lode"), file("t.ply"), "--isovalue=100"}).exit_code, 0);
  EXPECT_EQ(read_bytes(file("s.ply")), read_bytes(file("t.ply")));
  EXPECT_TRUE(std::filesystem::exists(file("steps/step-000.ply")));
}

TEST_F(cli_progressive, uses_an_empty_directory_and_refuses_one_with_files) {
  std::filesystem::create_directory(file("steps"));
  EXPECT_EQ(run("extract", "s.stl", {}).exit_code, 0);
  const auto before = scratch_.files();
  expect_refusal(run("extract", "t.stl", {}), 1, {"steps", "empty directory"});
  expect_refusal(draw({}), 1, {"steps", "empty directory"});
  EXPECT_EQ(scratch_.files(), before);
  std::filesystem::remove_all(file("steps"));
  write_bytes(file("steps"), "a file");
  expect_refusal(run("extract", "t.stl", {}), 1, {"steps", "directory"});
}

TEST_F(cli_progressive, draws_frames_that_end_with_the_final_picture) {
  const Finished done = draw({"--max-error=2", "--frames-per-step=3", "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const nlohmann::json report = done.json().at("progressive");
  const std::size_t n = report.at("frames").get<std::size_t>();
  EXPECT_EQ(report.at("frames_per_step"), 3);
  EXPECT_EQ(n, 3 * report.at("steps").size() - 2);
  for (std::size_t i = 0; i < n; ++i)
    EXPECT_TRUE(std::filesystem::exists(file("steps/frame-000" + std::to_string(i) + ".png")) ||
                i > 9)
        << i;
  EXPECT_EQ(report.at("steps").back().at("frame"), n - 1);
  EXPECT_EQ(report.at("steps").back().at("triangles"), done.json().at("triangles"));
  EXPECT_NE(read_bytes(file("steps/frame-0000.png")), read_bytes(file("p.png")));
}

TEST_F(cli_progressive, looks_through_the_camera_of_the_final_surface) {
  ASSERT_EQ(draw({"--save-camera", file("c.json")}).exit_code, 0);
  const std::string drawn = read_bytes(file("p.png"));
  const Finished plain = run_lode({"render", file("ball.lode"), file("p.png"), "--isovalue=100",
                                   "--size=64x48", "--samples=1", "--save-camera", file("d.json")});
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  EXPECT_EQ(read_bytes(file("p.png")), drawn);
  EXPECT_EQ(read_bytes(file("c.json")), read_bytes(file("d.json")));
}

TEST_F(cli_progressive, refuses_what_steps_cannot_have) {
  for (const std::string option : {"--close-border", "--min-component=9", "--isovalue=50"}) {
    expect_refusal(run("extract", "s.ply", {option}), 2, {"--progressive"});
    expect_refusal(draw({option}), 2, {"--progressive"});
  }
  expect_refusal(run("extract", "s.vtu", {"--mesh"}), 2, {"--progressive", "--mesh"});
  expect_refusal(draw({"--frames-per-step=0"}), 2, {"--frames-per-step"});
  expect_refusal(run_lode({"render", file("ball.lode"), file("p.png"), "--isovalue=100",
                           "--frames-per-step=4"}),
                 2, {"--frames-per-step", "--progressive"});
  EXPECT_FALSE(has_steps());
}

TEST_F(cli_progressive, leaves_no_directory_where_it_fails) {
  expect_refusal(run_lode({"extract", file("none.lode"), file("s.ply"), "--isovalue=100",
                           "--progressive", file("steps")}),
                 1, {"none.lode"});
  EXPECT_FALSE(has_steps());
  expect_refusal(run_lode({"extract", file("ball.lode"), file("s.ply"), "--isovalue=100",
                           "--progressive", file("no/steps")}),
                 1, {"no/steps"});
}

TEST_F(cli_progressive, leaves_nothing_where_it_is_interrupted) {
  const auto before = scratch_.files();
  const int n_wanted = oracles::trials(4, 2);
  int n_stopped = 0;
  for (int i = 0; i < 20; ++i) {
    // Large pictures: a second or more, of which most is left.
    Running running({"render", file("ball.lode"), file("p.png"), "--isovalue=100", "--progressive",
                     file("steps"), "--samples=4", "--threads=1"});
    wait_for(file(i % 2 == 0 ? "steps" : "steps/frame-0001.png"));
    running.send(SIGINT);
    const Finished stopped = running.finish();
    if (stopped.exit_code == 0) {
      std::filesystem::remove_all(file("steps"));
      std::filesystem::remove(file("p.png"));
      continue;
    }
    EXPECT_EQ(stopped.exit_code, 128 + SIGINT) << stopped.err;
    EXPECT_EQ(scratch_.files(), before);
    if (++n_stopped == n_wanted) break;
  }
  EXPECT_EQ(n_stopped, n_wanted);
}

}  // namespace
}  // namespace lode::test
