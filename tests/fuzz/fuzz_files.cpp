#include "tests/fuzz/fuzz_files.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace lode::fuzz {

FuzzDirectory::FuzzDirectory() {
  const std::filesystem::path in_memory = "/dev/shm";
  const bool has_memory = ::access(in_memory.c_str(), W_OK) == 0;
  const std::filesystem::path parent =
      has_memory ? in_memory : std::filesystem::temp_directory_path();
  path_ = parent / ("lode_fuzz_" + std::to_string(::getpid()));
  std::filesystem::create_directories(path_);
}

FuzzDirectory::~FuzzDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string FuzzDirectory::write(const std::string& name, Input bytes) const {
  const std::filesystem::path file = path_ / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return file.string();
}

const FuzzDirectory& fuzz_directory() {
  static const FuzzDirectory directory;
  return directory;
}

void expect(bool holds, const char* promise, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s %s\n", promise, what.c_str());
  std::abort();
}

}  // namespace lode::fuzz
