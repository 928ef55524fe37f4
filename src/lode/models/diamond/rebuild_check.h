#pragma once

#include "lode/models/diamond/compare_blocks.h"
#include "lode/models/diamond/persist.h"

namespace lode::diamond {

struct RebuildSettings {
  Threads threads;  ///< Fewer where memory is short.
  /// Bytes that it may take, the directory's aside, or what it needs at least if that is more; 0:
  /// as it likes.
  std::uint64_t memory_limit = 0;
};

/// Bytes that rebuild_check() takes at least.
template <int D>
[[nodiscard]] std::uint64_t least_rebuild_bytes(const VolumeInfo& info);

/// Builds the hierarchy again of a file's own samples, part by part as build_file() does, and
/// compares all blocks with what that gives: so errors, ranges and world errors are those of the
/// samples, in bounded memory. Samples of a part and its border layers are read chunk by chunk;
/// blocks that several parts need are kept as far as the limit allows. Fails where blocks are
/// missing, of another size or damaged, where there are others, where samples beyond the data are
/// not the nearest ones, where range, holes and largest errors are not those of the metadata, and
/// on cancel.
template <int D>
[[nodiscard]] Result<BlockFindings> rebuild_check(const store::Reader& reader,
                                                  const RebuildSettings& settings,
                                                  Progress& progress);

}  // namespace lode::diamond
