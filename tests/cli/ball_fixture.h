#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>

#include "tests/cli/program.h"

namespace lode::test {

/// A place in the first block of a .lode file, behind its index.
inline std::size_t first_block(const std::string& bytes) {
  constexpr std::size_t kIndexAt = 128;
  std::uint64_t frame = 0;
  std::memcpy(&frame, bytes.data() + kIndexAt + 24, sizeof frame);
  return kIndexAt + 56 + frame + 9;
}

/// A ball's volume, 17 samples wide, and its .lode file, ready to be extracted from.
class BallFixture : public ::testing::Test {
 protected:
  void SetUp() override {
    write_ball(volume());
    const Finished run = run_lode({"build", volume(), lode_file()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] std::string volume() const { return scratch_ / "ball.nrrd"; }
  [[nodiscard]] std::string lode_file() const { return scratch_ / "ball.lode"; }
  [[nodiscard]] std::string file(const std::string& name) const { return scratch_ / name; }
  [[nodiscard]] Finished extract(const std::string& output, std::vector<std::string> options) {
    options.insert(options.begin(), {"extract", lode_file(), file(output)});
    return run_lode(options);
  }

  Scratch scratch_;
};

}  // namespace lode::test
