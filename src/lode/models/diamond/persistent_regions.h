#pragma once

#include <cstdint>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/cell_field.h"

namespace lode::diamond {

/// Regions of a volume's samples, joined by edges of the finest tetrahedra, that last from P below
/// an isovalue c to P above it. No two of them are one region of {H >= c}, or of {H < c}, if H is
/// nowhere farther than P from the samples.
struct PersistentRegions {
  std::uint64_t inside = 0;   ///< Of {F >= c - P} that have a sample >= c + P,
  std::uint64_t outside = 0;  ///< and of {F < c + P} that have one < c - P.
};

/// Counts them, by a flood through all samples: shares nothing with the search for nodes. Takes a
/// byte a sample, and what the front of a flood takes. Fails when cancelled.
[[nodiscard]] Result<PersistentRegions> count_persistent_regions(const FieldSamples& samples,
                                                                 double isovalue,
                                                                 double persistence,
                                                                 Threads threads,
                                                                 Progress& progress);

}  // namespace lode::diamond
