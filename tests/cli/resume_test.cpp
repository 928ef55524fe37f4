#include "tests/cli/kill_storm.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

TEST(cli_resume, goes_on_after_kills) { KillStorm().run(oracles::trials(10, 4), 1); }

/// Starts builds of six parts until one is interrupted while its part file has blocks.
class cli_part : public ::testing::Test {
 protected:
  void SetUp() override {
    write_nrrd(input_, {{20, 270, 530}}, [](int x, int y, int z) { return (x * y + z) % 256; });
    for (int i = 0; i < 40; ++i) {
      Running running({"build", input_, output_});
      while (!std::filesystem::exists(part_) && !std::filesystem::exists(output_))
        std::this_thread::yield();
      running.send(SIGINT);
      stopped_ = running.finish();
      if (std::filesystem::exists(part_)) return;
      std::filesystem::remove(output_);
    }
    FAIL() << "no build was slow enough";
  }

  /// Until the journal tells of a part.
  void finish_a_part() {
    const std::string journal = part_ + ".journal";
    const std::uintmax_t head_bytes = std::filesystem::file_size(journal);
    for (int i = 0; i < 100; ++i) {
      Running running({"build", input_, output_, "--resume"});
      const auto size = [&] {
        std::error_code status;
        const std::uintmax_t n = std::filesystem::file_size(journal, status);
        return status ? head_bytes : n;
      };
      while (size() == head_bytes && !std::filesystem::exists(output_)) std::this_thread::yield();
      running.send(SIGINT);
      if (running.finish().exit_code != 0) return;
      std::filesystem::remove(output_);
      write_bytes(part_, "");
      write_bytes(journal, "");
    }
    FAIL() << "no build was stopped between parts";
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.nrrd";
  std::string output_ = scratch_ / "out.lode";
  std::string part_ = output_ + ".part";
  Finished stopped_;
};

TEST_F(cli_part, is_named_when_a_build_is_stopped) {
  expect_refusal(stopped_, 128 + SIGINT, {"stopped", part_, "--resume"});
  EXPECT_FALSE(std::filesystem::exists(output_));
}

TEST_F(cli_part, of_other_samples_is_refused_and_kept) {
  write_nrrd(input_, {{20, 270, 530}}, [](int x, int y, int z) { return (x * y + z + 1) % 256; });
  expect_refusal(run_lode({"build", input_, output_, "--resume"}), 1,
                 {part_, "other samples", "without --resume"});
  EXPECT_TRUE(std::filesystem::exists(part_));
  EXPECT_EQ(run_lode({"build", input_, output_}).exit_code, 0);
  EXPECT_EQ(scratch_.files(), (std::vector<std::string>{"in.nrrd", "out.lode"}));
}

TEST_F(cli_part, that_was_cut_is_refused) {
  // Blocks that the journal promises are missing only where somebody has cut the file.
  finish_a_part();
  std::filesystem::resize_file(part_, 1);
  expect_refusal(run_lode({"build", input_, output_, "--resume"}), 1, {part_, "got 1"});
}

TEST_F(cli_part, whose_blocks_have_changed_is_refused) {
  finish_a_part();
  std::string blocks = read_bytes(part_);
  ASSERT_GT(blocks.size(), 400U);
  blocks[300] = static_cast<char>(blocks[300] ^ 4);
  write_bytes(part_, blocks);
  expect_refusal(run_lode({"build", input_, output_, "--resume"}), 1,
                 {part_, "not as it was written", "without --resume"});
}

TEST_F(cli_part, whose_journal_is_damaged_is_begun_again_from_the_damage) {
  const std::string journal = part_ + ".journal";
  finish_a_part();
  ASSERT_EQ(run_lode({"build", input_, scratch_ / "whole.lode"}).exit_code, 0);
  const std::string bytes = read_bytes(journal);
  const std::string blocks = read_bytes(part_);
  for (const std::size_t at : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write_bytes(journal, damaged);
    write_bytes(part_, blocks);
    ASSERT_EQ(run_lode({"build", input_, output_, "--resume"}).exit_code, 0) << at;
    EXPECT_TRUE(read_bytes(output_) == read_bytes(scratch_ / "whole.lode")) << at;
  }
}

TEST_F(cli_part, of_earlier_builds_goes_when_the_output_is_finished) {
  write_ball(scratch_ / "ball.nrrd");
  EXPECT_EQ(run_lode({"build", scratch_ / "ball.nrrd", output_}).exit_code, 0);
  EXPECT_EQ(scratch_.files(), (std::vector<std::string>{"ball.nrrd", "in.nrrd", "out.lode"}));
}

TEST_F(cli_part, that_is_a_link_is_refused) {
  write_bytes(scratch_ / "victim", "precious");
  std::filesystem::remove(part_);
  std::filesystem::create_symlink(scratch_ / "victim", part_);
  expect_refusal(run_lode({"build", input_, output_}), 1, {part_});
  EXPECT_EQ(read_bytes(scratch_ / "victim"), "precious");
}

TEST(cli_resume, without_a_part_just_builds) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  EXPECT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--resume"}).exit_code,
            0);
  expect_refusal(
      run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--resume", "--no-resume"}),
      2, {"--no-resume"});
}

TEST(cli_build, names_the_memory_that_it_needs) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  expect_refusal(
      run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--memory-limit", "1M"}), 1,
      {"memory limit", "at least", "MB"});
  expect_refusal(
      run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--memory-limit", "5x"}), 2,
      {"--memory-limit", "512M", "5x"});
  // What the message asks for is enough.
  const Finished refused =
      run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--memory-limit", "1M"});
  const std::size_t at = refused.err.find("at least ") + 9;
  const std::string megabytes = refused.err.substr(at, refused.err.find(' ', at) - at);
  EXPECT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode", "--memory-limit",
                      megabytes + "000000"})
                .exit_code,
            0);
}

}  // namespace
}  // namespace lode::test
