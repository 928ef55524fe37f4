#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

/// A ball in a NRRD file whose header has these lines more.
void write_ball_with(const std::string& path, const std::string& fields) {
  write_ball(path);
  std::string bytes = read_bytes(path);
  bytes.insert(bytes.find("encoding"), fields);
  write_bytes(path, bytes);
}

TEST(cli_units, go_from_the_file_through_the_model_to_reports_and_surfaces) {
  const Scratch scratch;
  const std::string input = scratch / "ball.nrrd";
  const std::string model = scratch / "ball.lode";
  const std::string surface = scratch / "ball.ply";
  write_ball_with(input, "units: \"mm\" \"mm\" \"mm\"\nsample units: \"HU\"\n");
  ASSERT_EQ(run_lode({"build", input, model}).exit_code, 0);
  for (const std::string& path : {input, model}) {
    SCOPED_TRACE(path);
    const Finished text = run_lode({"info", path});
    EXPECT_NE(text.out.find("lengths in mm, values in HU"), std::string::npos) << text.out;
    const nlohmann::json info = run_lode({"info", path, "--json"}).json();
    EXPECT_EQ(info["length_unit"], "mm");
    EXPECT_EQ(info["value_unit"], "HU");
    const Finished answer = run_lode({"extract", path, surface, "--isovalue", "100", "--json"});
    ASSERT_EQ(answer.exit_code, 0) << answer.err;
    EXPECT_EQ(answer.json()["length_unit"], "mm");
    EXPECT_NE(read_bytes(surface).find(", lengths in mm, values in HU\n"), std::string::npos);
  }
  EXPECT_EQ(run_lode({"verify", model, "--against", input, "--quiet"}).exit_code, 0);
}

TEST(cli_units, are_null_where_nothing_says_them) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  const Finished run = run_lode({"info", scratch / "ball.nrrd", "--json"});
  EXPECT_TRUE(run.json()["length_unit"].is_null());
  EXPECT_TRUE(run.json()["value_unit"].is_null());
  EXPECT_EQ(run_lode({"info", scratch / "ball.nrrd"}).out.find("units"), std::string::npos);
}

TEST(cli_units, that_are_given_are_kept_in_the_model_and_wanted_of_foreign_files_alone) {
  const Scratch scratch;
  const std::string input = scratch / "ball.nrrd";
  const std::string model = scratch / "ball.lode";
  write_ball_with(input, "units: \"mm\" \"mm\" \"mm\"\n");
  ASSERT_EQ(run_lode({"build", input, model, "--length-unit", "cm", "--value-unit", "g/cm\u00b3"})
                .exit_code,
            0);
  const nlohmann::json info = run_lode({"info", model, "--json"}).json();
  EXPECT_EQ(info["length_unit"], "cm");
  EXPECT_EQ(info["value_unit"], "g/cm\u00b3");
  expect_refusal(run_lode({"info", model, "--value-unit", "HU"}), 2, {"--value-unit"});
}

}  // namespace
}  // namespace lode::test
