#include "free_space.h"

#include <sys/statvfs.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace lode::raster_import {

void check_space(const std::string& output, std::uint64_t n_bytes) {
  struct statvfs space {};
  std::error_code status;
  const bool is_there = std::filesystem::exists(output, status);
  const std::string folder = std::filesystem::path(output).parent_path().string();
  if (::statvfs(is_there ? output.c_str() : folder.empty() ? "." : folder.c_str(), &space) != 0)
    return;  // then writing says what is wrong
  const std::uint64_t n_free = std::uint64_t{space.f_bavail} * space.f_frsize;
  constexpr std::uint64_t kBeside = std::uint64_t{1} << 20;
  if (n_free >= n_bytes + n_bytes / 64 + kBeside) return;
  throw std::runtime_error("expected " + std::to_string(n_bytes) +
                           " bytes free for a temporary copy in the directory TMPDIR, got " +
                           std::to_string(n_free));
}

}  // namespace lode::raster_import
