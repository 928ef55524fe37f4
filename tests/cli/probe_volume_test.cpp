// `lode probe` of volumes, from files and built in memory.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

class cli_probe_volume : public BallFixture {
 protected:
  [[nodiscard]] nlohmann::json probed(const std::string& path, std::vector<std::string> options) {
    options.insert(options.begin(), {"probe", path});
    options.emplace_back("--json");
    const Finished run = run_lode(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
};

TEST_F(cli_probe_volume, shows_values_at_samples_and_between_from_file_and_memory) {
  for (const std::string& path : {volume(), lode_file()}) {
    SCOPED_TRACE(path);
    const std::string out = file("values.csv");
    const nlohmann::json report = probed(path, {"--point", "8,8,8", "--point", "0,16,3", "--point",
                                                "8.5,8,8", "--point", "8,8,17", "-o", out});
    EXPECT_EQ(report.at("model"), "diamond3d");
    EXPECT_EQ(report.at("outside"), 1);
    EXPECT_EQ(report.at("achieved_error"), 0);
    const auto& points = report.at("points");
    EXPECT_EQ(points[0].at("status"), "exact");
    EXPECT_EQ(points[3].at("status"), "outside");
    const auto at = [&](std::size_t i) { return points[i].at("value").get<double>(); };
    // The ball's values fall by 20 for each step from its middle.
    EXPECT_NEAR(at(0), 200, 1e-9);
    EXPECT_NEAR(at(1), 0, 1e-9);
    EXPECT_NEAR(at(2), 190, 1e-9);
    EXPECT_EQ(report.contains("bytes_read"), path == lode_file());
    EXPECT_EQ(read_bytes(out).substr(0, 35), "x,y,z,status,value,low,high,error\n8");
  }
}

TEST_F(cli_probe_volume, integrates_boxes_and_follows_lines_within_bounds) {
  const nlohmann::json all = probed(lode_file(), {"--integral"});
  EXPECT_DOUBLE_EQ(all.at("volume").at("value"), 16 * 16 * 16);
  EXPECT_EQ(all.at("cells"), 6 * 16 * 16 * 16);
  EXPECT_EQ(all.at("maximum").at("value"), 200);
  const nlohmann::json box =
      probed(lode_file(), {"--integral", "--box", "7.5,8.5,7.5,8.5,7.5,8.5"});
  EXPECT_NEAR(box.at("volume").at("value").get<double>(), 1, 1e-12);
  EXPECT_GT(box.at("mean").at("value"), 180);
  EXPECT_LT(box.at("mean").at("value"), 200);
  const nlohmann::json coarse = probed(lode_file(), {"--integral", "--max-error", "10%"});
  const auto exact = all.at("mean").at("value").get<double>();
  EXPECT_LE(coarse.at("mean").at("low"), exact);
  EXPECT_GE(coarse.at("mean").at("high"), exact);
  const nlohmann::json line = probed(lode_file(), {"--line", "0,8,8:16,8,8:17"});
  ASSERT_EQ(line.at("line").size(), 17U);
  EXPECT_NEAR(line.at("line")[4].at("value").get<double>(), 120, 1e-9);
  const Finished empty = run_lode({"probe", lode_file(), "--integral", "--box", "20,21,0,1,0,1"});
  EXPECT_EQ(empty.exit_code, 0);
  EXPECT_NE(empty.err.find("the integral is empty"), std::string::npos) << empty.err;
}

TEST_F(cli_probe_volume, tells_units_and_holes) {
  const Finished text = run_lode({"probe", volume(), "--point", "8,8,8", "--length-unit", "mm",
                                  "--value-unit", "HU", "--nodata", "200"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("lengths in mm, values in HU"), std::string::npos) << text.out;
  EXPECT_NE(text.err.find("1 of 1 points are outside, or where a hole is near"), std::string::npos)
      << text.err;
}

TEST_F(cli_probe_volume, refuses_what_volumes_have_not) {
  const auto refused = [&](std::vector<std::string> options, const char* word, int code = 2) {
    options.insert(options.begin(), {"probe", lode_file()});
    expect_refusal(run_lode(options), code, {word});
  };
  refused({"--integral", "--region", "2"}, "--region");
  refused({"--point", "1,1,1", "--with", "p"}, "--with");
  refused({"--point", "1,1,1", "--memory-limit", "x"}, "--memory-limit");
  refused({"--point", "1,1,1", "--snap", "-1"}, "--snap");
  write_bytes(file("flat.raw"), std::string(16, 'a'));
  expect_refusal(run_lode({"probe", file("flat.raw"), "--dims", "4x4x1", "--type", "uint8",
                           "--point", "1,1,0"}),
                 1, {"4 x 4 x 1"});
  write_bytes(file("dem.asc"),
              "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  expect_refusal(run_lode({"probe", file("dem.asc"), "--point", "1,1,0"}), 2, {"lode height"});
  expect_refusal(run_lode({"probe", file("none.nrrd"), "--point", "1,1,0"}), 1, {"none.nrrd"});
  expect_refusal(run_lode({"probe", file("note.txt"), "--point", "1,1,0"}), 2, {"note.txt"});
}

}  // namespace
}  // namespace lode::test
