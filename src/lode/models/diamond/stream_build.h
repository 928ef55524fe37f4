#pragma once

#include <string>

#include "lode/core/atomic_file.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/coarse_field.h"
#include "lode/models/diamond/persist.h"

namespace lode::diamond {

struct StreamSettings {
  Threads threads;
  /// Bytes that the build may take; 0: as it likes. The least is about a chunk and n / 33 for n
  /// samples.
  std::uint64_t memory_limit = 0;
  Unfinished unfinished = Unfinished::nothing;
  bool* has_part = nullptr;          ///< Set when a part file is begun or gone on with.
  std::int32_t chunks_per_part = 0;  ///< Side by side in x; 0: as many as the limit allows.
};

/// What a build from a source to a file did.
struct StreamReport {
  Metadata metadata;
  std::uint64_t file_bytes = 0;
  std::uint64_t bytes_read = 0;        ///< Samples asked of the source, in its type.
  IoCounts io;                         ///< Of the source, and of the spool of border layers.
  std::uint64_t n_parts = 0;           ///< That were built,
  std::uint64_t n_chunks_resumed = 0;  ///< after so many chunks that were there.
  double scan_seconds = 0;   ///< First time through the source: range, holes, coarse samples.
  double read_seconds = 0;   ///< Second time,
  double build_seconds = 0;  ///< errors and ranges,
  double write_seconds = 0;  ///< compressing and writing.
};

/// Builds the hierarchy of a volume straight into a .lode file, in bounded memory: the source is
/// read once for the coarse samples, and once again part by part, with border layers; those come
/// from a nameless file beside the output where decoding them again would move more bytes
/// (io/border_spool.h). The file has
/// the same bytes as build() and save() would give it, whatever the limit and the threads. Fails
/// as build() does, and where the limit is too small, saying what is needed.
template <int D>
[[nodiscard]] Result<StreamReport> build_file(VolumeSource& source, const std::string& path,
                                              const StreamSettings& settings, Progress& progress);

}  // namespace lode::diamond
