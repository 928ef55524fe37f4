#pragma once

#include "lode/models/diamond/rebuild_check.h"

namespace lode::diamond {

/// Compares the samples of a file with those of the data that it was made of, box by box, in
/// bounded memory: equal as numbers, or holes that are none in both. `original` has as many samples
/// along each axis. Fails when a source does, and on cancel.
template <int D>
[[nodiscard]] Result<AttributeFinding> compare_samples(const store::Reader& reader,
                                                       VolumeSource& original,
                                                       const RebuildSettings& settings,
                                                       Progress& progress);

}  // namespace lode::diamond
