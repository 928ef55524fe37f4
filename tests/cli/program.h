#pragma once

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lode/core/vec.h"

namespace lode::test {

/// A command line, without the name of the program.
using Words = std::vector<std::string>;

/// What a finished run of the program left behind.
struct Finished {
  int exit_code = -1;  ///< As a shell says it: 128 + signal where a signal ended it.
  std::string out;
  std::string err;

  /// The one JSON object on stdout; fails the test when there is anything else.
  [[nodiscard]] nlohmann::json json() const;
};

/// A run of the program that has not ended yet.
class Running {
 public:
  explicit Running(const std::vector<std::string>& arguments);
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running();

  void send(int signal) const;
  /// Bytes of the largest file in `directory` that it has open and that has no name (yet).
  [[nodiscard]] std::uintmax_t unnamed_bytes(const std::string& directory) const;
  /// Waits for the end, and kills the program after a minute.
  [[nodiscard]] Finished finish();

 private:
  pid_t process_ = -1;
  int out_ = -1;
  int err_ = -1;
};

[[nodiscard]] Finished run_lode(const std::vector<std::string>& arguments);

/// A directory that is gone when the test is.
class Scratch {
 public:
  Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch();

  [[nodiscard]] std::string operator/(const std::string& name) const {
    return (directory_ / name).string();
  }
  /// The sorted names of the files in it.
  [[nodiscard]] std::vector<std::string> files() const;
  [[nodiscard]] std::string path() const { return directory_.string(); }

 private:
  std::filesystem::path directory_;
};

void write_bytes(const std::string& path, const std::string& bytes);
[[nodiscard]] std::string read_bytes(const std::string& path);

/// Writes uint8 samples value(x, y, z) as a raw NRRD file.
void write_nrrd(const std::string& path, const Index3& dims,
                const std::function<int(int, int, int)>& value);
/// A ball of values that fall from 200 in the middle to 0, 17 samples wide.
void write_ball(const std::string& path);

/// Exit code as given, nothing on stdout, one sentence on stderr that starts with "lode: " and
/// holds every one of `words`.
void expect_refusal(const Finished& run, int exit_code, const std::vector<std::string>& words);

}  // namespace lode::test
