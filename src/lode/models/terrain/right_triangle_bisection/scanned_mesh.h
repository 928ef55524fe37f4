#pragma once

#include <cstddef>

#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/models/terrain/right_triangle_bisection/sample_numbers.h"

namespace lode::bisection {

/// Whether it pays to look at all errors first: that is where they fit the caches of a core.
[[nodiscard]] inline bool is_scanned(const Lattice& lattice) {
  constexpr std::size_t kMost = 1 << 20;
  return lattice.size() <= kMost;
}

/// The mesh whose nodes with errors above the limit are refined, of a whole domain, in the order of
/// Walk and with its samples numbered. The samples
/// that they stand on are known and numbered before any triangle is: so those get their corners'
/// numbers on the way. The same for any number of threads.
[[nodiscard]] SampleMesh mesh_by_scan(const Bisection& bisection, float limit, Threads threads);

}  // namespace lode::bisection
