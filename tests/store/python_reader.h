#pragma once

#include <fmt/format.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace lode::store {

/// What a reader in Python, written from docs/format.md alone, makes of a file.
struct PythonOutcome {
  int exit_code = -1;  ///< 0, 1 for a bad file; 2 without libzstd, 127 without /usr/bin/python3: no
                       ///< reason to skip, as ./dev installs both.
  std::string output;
};

inline PythonOutcome run_python(const std::string& script, const std::string& path) {
  const std::string command = fmt::format("/usr/bin/python3 -B '{}' '{}' 2>&1", script, path);
  PythonOutcome run;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    run.output.append(buffer.data(), n);
  const int status = ::pclose(pipe);
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

}  // namespace lode::store
