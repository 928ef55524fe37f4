#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/io/volume_test_files.h"

namespace lode::test {

[[nodiscard]] std::string read_bytes(const std::string& path);

/// A directory with an output that was there before, for one operation.
class FaultScratch {
 public:
  explicit FaultScratch(const std::string& output_name);

  [[nodiscard]] const std::string& output() const { return output_; }
  [[nodiscard]] std::string path(const std::string& name) const { return dir_.path(name); }
  /// A file that stays.
  std::string write(const std::string& name, const std::string& bytes);

  /// The old output, the files that stay, and no other one.
  void prepare() const;
  /// The output has these bytes, and nothing else is new.
  void expect_output(const std::string& bytes) const;
  /// The output is the old one, and but for `allowed` nothing else is new.
  void expect_untouched(const std::vector<std::string>& allowed = {}) const;

 private:
  void expect_no_others(const std::vector<std::string>& allowed) const;

  io::test::TempDir dir_;
  std::vector<std::string> kept_;
  std::string output_;
};

}  // namespace lode::test
