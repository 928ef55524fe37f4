#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace lode::test {

inline constexpr const char* kVtkMissing =
    "expected VTK for /usr/bin/python3: package python3-vtk9, which ./dev test installs";

inline std::string output_of(const std::string& command) {
  std::string output;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  std::array<char, 4096> part;
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe))
    output.append(part.data(), n);
  ::pclose(pipe);
  return output;
}

/// What a Python script of the tests prints, run by the Python that has VTK.
inline std::string run_oracle(const std::string& script, const std::string& arguments) {
  return output_of("/usr/bin/python3 " + script + " " + arguments);
}

/// Looks for VTK's core alone: all of it takes ten times as long to load.
inline bool has_vtk() {
  return output_of("/usr/bin/python3 -c 'import vtkmodules.vtkCommonCore; print(1)' 2>/dev/null") ==
         "1\n";
}

}  // namespace lode::test
