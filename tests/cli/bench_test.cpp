#include <gtest/gtest.h>

#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_bench, measures_a_volume_and_leaves_nothing) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  const auto json =
      run_lode({"bench", scratch / "ball.nrrd", "--isovalue", "100", "--json"}).json();
  EXPECT_GT(json["build"]["samples_per_second"], 0);
  EXPECT_GT(json["first_surface"]["cells"], 0);
  EXPECT_EQ(json["extractions"].size(), 4U);
  EXPECT_GT(json["extractions"].back()["cells"], json["extractions"].front()["cells"]);
  EXPECT_GT(json["floors"]["copy_bytes_per_second"], 0);
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.nrrd"}));
}

TEST(cli_bench, measures_a_lode_file) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  const auto json = run_lode({"bench", scratch / "ball.lode", "--json"}).json();
  EXPECT_FALSE(json.contains("build"));
  EXPECT_GT(json["extractions"].front()["bytes_read"], 0);
}

}  // namespace
}  // namespace lode::test
