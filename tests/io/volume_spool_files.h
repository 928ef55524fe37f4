#pragma once

#include <sys/resource.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/io/volume_test_files.h"

namespace lode::io::test {

/// Of every spooled volume: a few times what the spool's buffer holds.
constexpr Index3 kSpoolDims{{64, 50, 48}};

/// Bytes that deflate cannot make smaller, always the same.
std::string noise(std::size_t n);

/// A volume of kSpoolDims that is decoded rather than read where it is.
struct SpoolSeed {
  std::string name;
  std::vector<std::pair<std::string, std::string>> files;  ///< Names and bytes; the last is opened.
  ReadOptions options;
  std::uint64_t n_bytes = 0;  ///< Of the decoded samples: all components and times.
  bool is_spooled = true;     ///< Else decoded again for every read, beyond the memory limit.

  /// Of one pass upwards through the volume.
  [[nodiscard]] std::uint64_t most_file_bytes() const;
};

std::vector<SpoolSeed> spool_seeds();

/// The options with a memory limit that no volume keeps to.
ReadOptions spooling(ReadOptions options, const std::string& directory);

/// A limit of file sizes while it lives: the one full disk that every machine has.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t n_bytes);
  ~FileSizeLimit();
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

}  // namespace lode::io::test
