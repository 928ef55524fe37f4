#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

class cli_count : public BallFixture {
 protected:
  [[nodiscard]] Finished count(const std::string& input, std::vector<std::string> options) {
    options.insert(options.begin(), {"count", input});
    return run_lode(options);
  }
};

TEST_F(cli_count, counts_what_extraction_writes) {
  for (const char* max_error : {"0", "4"}) {
    const Finished run =
        count(lode_file(), {"--isovalues", "80:120:5", "--max-error", max_error, "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const nlohmann::json report = run.json();
    EXPECT_EQ(report.at("command"), "count");
    EXPECT_EQ(report.at("max_error"), std::stod(max_error));
    ASSERT_EQ(report.at("counts").size(), 5U);
    for (int i = 0; i < 5; ++i) {
      const nlohmann::json& one = report.at("counts").at(static_cast<std::size_t>(i));
      EXPECT_EQ(one.at("isovalue"), 80 + 10 * i);
      const Finished extracted = extract(
          "s.ply", {"--isovalue", std::to_string(80 + 10 * i), "--max-error", max_error, "--json"});
      EXPECT_EQ(one.at("triangles"), extracted.json().at("triangles"));
      EXPECT_EQ(one.at("vertices"), extracted.json().at("vertices"));
      EXPECT_GT(one.at("triangles"), 0);
    }
  }
}

TEST_F(cli_count, takes_isovalues_one_by_one_in_their_order_and_a_volume) {
  const Finished run = count(volume(), {"--isovalue", "120", "--isovalue", "90", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = run.json();
  ASSERT_EQ(report.at("counts").size(), 2U);
  EXPECT_EQ(report.at("counts").at(0).at("isovalue"), 120);
  EXPECT_EQ(report.at("built_in_memory"), true);
}

TEST_F(cli_count, spreads_isovalues_inside_the_range_and_prints_a_table) {
  const Finished run = count(lode_file(), {});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("isovalue  triangles  vertices"), std::string::npos) << run.out;
  const nlohmann::json three = count(lode_file(), {"--isovalues", "3", "--json"}).json();
  ASSERT_EQ(three.at("counts").size(), 3U);
  const double first = three.at("counts").at(0).at("isovalue");
  const double middle = three.at("counts").at(1).at("isovalue");
  const double last = three.at("counts").at(2).at("isovalue");
  EXPECT_LT(first, middle);
  EXPECT_NEAR(middle - first, last - middle, 1e-9);
}

TEST_F(cli_count, has_whole_steps_of_whole_numbers) {
  const auto isovalues = [&](const char* evenly) {
    std::vector<double> found;
    const nlohmann::json report = count(lode_file(), {"--isovalues", evenly, "--json"}).json();
    for (const auto& one : report.at("counts")) found.push_back(one.at("isovalue"));
    return found;
  };
  const std::vector<double> tens = isovalues("10:200:20");
  for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(tens[i], 10 * static_cast<double>(i + 1));
  const std::vector<double> ones = isovalues("1:99:99");
  for (std::size_t i = 0; i < 99; ++i) EXPECT_EQ(ones[i], static_cast<double>(i + 1));
  EXPECT_EQ(isovalues("0.1:0.7:3").back(), 0.7);
  // What is not whole is told apart from what is.
  const Finished run = count(lode_file(), {"--isovalues", "100:101:4"});
  EXPECT_NE(run.out.find("100.33333333333333"), std::string::npos) << run.out;
}

TEST_F(cli_count, takes_a_memory_limit) {
  const Words few = {"--isovalue", "100", "--max-error", "4", "--json"};
  Words limited = few;
  limited.insert(limited.end(), {"--memory-limit", "100M"});
  EXPECT_EQ(count(lode_file(), few).json().at("counts"),
            count(lode_file(), limited).json().at("counts"));
}

TEST_F(cli_count, refuses_isovalues_that_it_cannot_read) {
  for (const char* wrong : {"0", "1:2", "2:1:5", "1:1:5", "1:2:1", "a:b:c", "1:2:3:4", ""})
    expect_refusal(count(lode_file(), {"--isovalues", wrong}), 2, {"--isovalues"});
  expect_refusal(count(lode_file(), {"--isovalue", "x"}), 2, {"--isovalue", "'x'"});
  expect_refusal(count(lode_file(), {"--isovalue", "1", "--isovalues", "4"}), 2, {"--isovalues"});
}

}  // namespace
}  // namespace lode::test
