#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode::io {

/// A program of that name beside this one, else the first in PATH; none where it is nowhere.
[[nodiscard]] std::optional<std::string> find_program(const std::string& name);

/// Where a child's errors go: into what is read of it, or nowhere.
enum class ChildErrors : std::uint8_t { read, dropped };

/// A program that runs, and what it writes; what is left of it is ended with this.
class ChildProgram {
 public:
  /// words[0] is the path of the program. `passed`: an open descriptor, which it has as 3; -1:
  /// none.
  [[nodiscard]] static Result<ChildProgram> start(const std::vector<std::string>& words,
                                                  ChildErrors errors, int passed = -1);

  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram(const ChildProgram&) = delete;
  ChildProgram& operator=(const ChildProgram&) = delete;
  ChildProgram& operator=(ChildProgram&&) = delete;
  ~ChildProgram();

  /// The next line, without its end; nothing where there are no more. Fails once cancelled, where
  /// the program says nothing for so long, or has lines of more than 4 MiB. `patience`: none waits
  /// for ever.
  [[nodiscard]] Result<std::optional<std::string>> read_line(
      const Progress& progress, std::optional<std::chrono::milliseconds> patience = {});
  /// Its exit status, as a shell says it: 128 + signal where one ended it.
  int wait();

 private:
  ChildProgram(pid_t process, int output) : process_(process), output_(output) {}

  pid_t process_ = -1;
  int output_ = -1;
  std::string text_{};  ///< Read, and not yet given.
};

}  // namespace lode::io
