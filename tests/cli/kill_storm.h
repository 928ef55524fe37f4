#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <random>
#include <thread>

#include "tests/cli/program.h"

namespace lode::test {

/// Builds of six parts that are killed at random moments, and gone on with.
class KillStorm {
 public:
  KillStorm() {
    write_nrrd(input_, {{20, 270, 530}}, [](int x, int y, int z) {
      return static_cast<int>((static_cast<unsigned>(x * 7 + y * 3 + z * 5) * 2654435761U) >> 26) +
             (x + y + z) / 8;
    });
    const auto start = Clock::now();
    EXPECT_EQ(run_lode({"build", input_, scratch_ / "whole.lode", "--no-resume"}).exit_code, 0);
    whole_ = Clock::now() - start;
    expected_ = read_bytes(scratch_ / "whole.lode");
  }

  /// Kills builds until `n` have been, whatever they had done; finishes one now and then.
  void run(int n, unsigned seed) {
    std::mt19937 random(seed);
    int n_killed = 0;
    int n_finished = 0;
    write_bytes(output_, "old");
    while (n_killed < n) {
      Running running({"build", input_, output_, "--resume"});
      const auto share = std::uniform_real_distribution<>(0, 0.8)(random);
      std::this_thread::sleep_for(whole_ * share);
      running.send(SIGKILL);
      const Finished run = running.finish();
      if (run.exit_code == 0) {
        ++n_finished;
        expect_finished();
        continue;
      }
      ++n_killed;
      ASSERT_EQ(run.exit_code, 128 + SIGKILL) << run.err;
      // The last thing a build does is to delete its journal.
      if (read_bytes(output_) == expected_) continue;
      ASSERT_EQ(read_bytes(output_), "old");
    }
    const Finished last = run_lode({"build", input_, output_, "--resume"});
    ASSERT_EQ(last.exit_code, 0) << last.err;
    expect_finished();
    std::printf("%d killed, %d finished before\n", n_killed, n_finished);
  }

 private:
  using Clock = std::chrono::steady_clock;

  void expect_finished() {
    EXPECT_TRUE(read_bytes(output_) == expected_);
    for (const std::string& name : scratch_.files())
      EXPECT_TRUE(name == "in.nrrd" || name == "out.lode" || name == "whole.lode") << name;
    write_bytes(output_, "old");
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.nrrd";
  std::string output_ = scratch_ / "out.lode";
  std::string expected_;
  Clock::duration whole_{};
};

}  // namespace lode::test
