#pragma once

#include <cstdint>
#include <string>

#include "lode/api/dataset.h"
#include "lode/core/atomic_file.h"

namespace lode {

struct FileBuildOptions {
  Threads threads{};
  Unfinished unfinished = Unfinished::nothing;
  bool* has_part = nullptr;  ///< Set when part_path(output) is begun or gone on with.
  /// Bytes that the build may take of memory, the program's code aside; 0: a quarter of what the
  /// machine has.
  std::uint64_t memory_limit = 0;
};

struct FileBuildSeconds {
  double total = 0;
  double scan = 0;   ///< First time through the input: range, holes, coarse samples.
  double read = 0;   ///< Second time.
  double build = 0;  ///< Errors and ranges.
  double write = 0;  ///< Compressing and writing.
};

struct FileBuildReport {
  DatasetInfo info;  ///< Of the file.
  std::uint64_t file_bytes = 0;
  std::uint64_t memory_limit = 0;        ///< As it was given or chosen.
  std::uint64_t samples_bytes_read = 0;  ///< Of the input's samples, as they are in memory.
  IoCounts io;                         ///< Of the source: bytes of its files, and what it spooled.
  std::uint64_t n_parts = 0;           ///< How many were built,
  std::uint64_t n_chunks_resumed = 0;  ///< after so many chunks that an earlier build had done.
  FileBuildSeconds seconds;
};

/// Builds the hierarchy of a volume straight into a .lode file, whatever its size: the source is
/// read twice, the second time part by part. The file is that of Dataset::build() and save(), byte
/// for byte, and appears whole or not at all. An error that comes after that says "is written".
[[nodiscard]] Result<FileBuildReport> build_file(VolumeSource& source, const std::string& path,
                                                 const FileBuildOptions& options,
                                                 Progress& progress);

/// Where an unfinished build of `output` is kept.
[[nodiscard]] std::string part_path(const std::string& output);

/// Bytes of memory of this machine; 0 where it does not say.
[[nodiscard]] std::uint64_t physical_memory();

}  // namespace lode
