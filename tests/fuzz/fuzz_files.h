#pragma once

#include <filesystem>
#include <string>

#include "tests/fuzz/harnesses.h"

namespace lode::fuzz {

/// A directory of this process, in memory where the machine has one, gone at its end.
class FuzzDirectory {
 public:
  FuzzDirectory();
  ~FuzzDirectory();
  FuzzDirectory(const FuzzDirectory&) = delete;
  FuzzDirectory& operator=(const FuzzDirectory&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return (path_ / name).string(); }
  /// Replaces a file; directories in its name are made.
  std::string write(const std::string& name, Input bytes) const;

 private:
  std::filesystem::path path_;
};

/// The one of the harness that asks; made with its first input.
const FuzzDirectory& fuzz_directory();

/// Ends the program, which is how a fuzzer is told of a broken promise.
void expect(bool holds, const char* promise, const std::string& what = {});

}  // namespace lode::fuzz
