#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

/// The ball's file with one byte changed: of its first block, samples of level 2.
class cli_salvage : public BallFixture {
 protected:
  void damage(std::size_t offset) const {
    std::string bytes = read_bytes(lode_file());
    bytes.at(offset) = static_cast<char>(bytes.at(offset) ^ 0x20);
    write_bytes(lode_file(), bytes);
  }
  const Words query_{"--isovalue", "100", "--max-error", "4"};

  [[nodiscard]] Finished extract_with(const std::string& output, Words options) {
    options.insert(options.begin(), query_.begin(), query_.end());
    return extract(output, options);
  }
};

TEST_F(cli_salvage, is_suggested_where_a_block_is_damaged) {
  damage(first_block(read_bytes(lode_file())));
  for (const Words& mode : {Words{}, Words{"--max-cells", "100000"}}) {
    const Finished run = extract_with("s.ply", mode);
    expect_refusal(run, 1, {"block (kind 1, level 2", "damaged", "--salvage"});
  }
  EXPECT_FALSE(std::filesystem::exists(file("s.ply")));
}

TEST_F(cli_salvage, writes_a_surface_and_says_what_was_lost_and_what_is_true_of_it) {
  damage(first_block(read_bytes(lode_file())));
  const Finished run = extract_with("s.ply", {"--salvage", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("lode: warning: "), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("1 of "), std::string::npos) << run.err;
  const nlohmann::json report = run.json();
  EXPECT_EQ(report.at("warnings").size(), 1U);
  EXPECT_GT(report.at("triangles"), 0);
  const nlohmann::json& salvage = report.at("salvage");
  EXPECT_EQ(salvage.at("lost_blocks"), 1);
  EXPECT_GT(salvage.at("lost_samples"), 0);
  const double fill = salvage.at("max_fill_error").get<double>();
  EXPECT_GT(fill, 0);
  EXPECT_EQ(salvage.at("achieved_error"), report.at("achieved_error").get<double>() + fill);
  EXPECT_EQ(salvage.at("box").at("lower").size(), 3U);
  ASSERT_EQ(salvage.at("levels").size(), 1U);
  EXPECT_EQ(salvage.at("levels").at(0).at("level"), 2);
  ASSERT_EQ(salvage.at("lost").size(), 1U);
  EXPECT_EQ(salvage.at("lost").at(0).at("kind"), "samples");
  EXPECT_EQ(salvage.at("lost").at(0).at("max_error"), fill);
  EXPECT_NE(read_bytes(file("s.ply")).find("of a salvaged field within"), std::string::npos);
  const Finished text = extract_with("s.ply", {"--salvage"});
  for (const char* word : {"lost blocks", "level 2", "box of the loss", "error there"})
    EXPECT_NE(text.out.find(word), std::string::npos) << text.out;
}

TEST_F(cli_salvage, goes_with_all_that_extract_writes) {
  damage(first_block(read_bytes(lode_file())));
  EXPECT_EQ(run_lode({"extract", lode_file(), file("m.vtu"), "--mesh", "--max-error", "4",
                      "--salvage", "--json"})
                .json()
                .at("salvage")
                .at("lost_blocks"),
            1);
  for (const Words& mode :
       {Words{"--max-cells", "100000"}, Words{"--progressive", file("steps")}}) {
    Words options = mode;
    options.insert(options.end(), {"--salvage", "--json"});
    const Finished run = extract_with("s.ply", options);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.json().at("salvage").at("lost_blocks"), 1);
  }
}

TEST_F(cli_salvage, of_a_whole_file_gives_the_same_surface_without_a_warning) {
  ASSERT_EQ(extract_with("whole.ply", {}).exit_code, 0);
  const Finished run = extract_with("s.ply", {"--salvage", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_EQ(run.json().at("salvage").at("lost_blocks"), 0);
  EXPECT_EQ(run.json().at("salvage").at("box"), nullptr);
  EXPECT_EQ(read_bytes(file("s.ply")), read_bytes(file("whole.ply")));
  EXPECT_FALSE(extract_with("s.ply", {"--json"}).json().contains("salvage"));
}

TEST_F(cli_salvage, takes_what_is_there_of_a_file_that_was_cut_off) {
  const std::string bytes = read_bytes(lode_file());
  write_bytes(lode_file(), bytes.substr(0, bytes.size() / 2));
  expect_refusal(extract_with("s.ply", {}), 1, {"truncated", "--salvage"});
  const Finished run = extract_with("s.ply", {"--salvage", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("lode: warning: "), std::string::npos) << run.err;
  const nlohmann::json report = run.json();
  EXPECT_GT(report.at("triangles"), 0);
  const nlohmann::json& salvage = report.at("salvage");
  EXPECT_GT(salvage.at("lost_blocks"), 0);
  EXPECT_GT(salvage.at("lost_samples"), 0);
  EXPECT_GT(salvage.at("blocks"), salvage.at("lost_blocks"));
  EXPECT_GT(salvage.at("max_fill_error"), 0);
}

TEST_F(cli_salvage, says_what_cannot_be_salvaged) {
  const std::string bytes = read_bytes(lode_file());
  write_bytes(lode_file(), bytes.substr(0, 200));
  expect_refusal(extract_with("s.ply", {"--salvage"}), 1,
                 {"truncated", "nothing can be salvaged", "directory"});
  expect_refusal(run_lode({"extract", volume(), file("s.ply"), "--isovalue", "1", "--salvage"}), 2,
                 {"--salvage", ".lode"});
  expect_refusal(extract_with("s.ply", {"--salvage", "--memory-limit", "1G"}), 2,
                 {"--salvage", "--memory-limit"});
}

}  // namespace
}  // namespace lode::test
