#pragma once

#include "lode/models/diamond/rebuild_check.h"

namespace lode::diamond {

/// Bytes that compare_samples() takes at least, what the original's source keeps aside.
template <int D>
[[nodiscard]] std::uint64_t least_comparison_bytes(const VolumeInfo& info, ScalarType original);

/// Compares the samples of a file with those of the data that it was made of, box by box, within
/// the memory limit: equal as numbers, or holes that are none in both. `original` has as many
/// samples along each axis. Fails when a source does, and on cancel.
template <int D>
[[nodiscard]] Result<AttributeFinding> compare_samples(const store::Reader& reader,
                                                       VolumeSource& original,
                                                       const RebuildSettings& settings,
                                                       Progress& progress);

}  // namespace lode::diamond
