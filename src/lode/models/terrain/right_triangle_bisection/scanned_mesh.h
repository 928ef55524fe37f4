#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/models/terrain/right_triangle_bisection/sample_numbers.h"

namespace lode::bisection {

/// Triangles as Walk goes through them, their corners' numbers by rising indices of samples, and
/// the corners.
struct ScannedMesh {
  std::vector<SampleCorners> triangles;
  std::vector<float> errors;  ///< Of the nodes that were not refined, or 0.
  SampleMarks marks;
  std::vector<std::uint32_t> n_before;  ///< Marks before each of the words.
  std::uint32_t n_samples = 0;
};

/// Whether it pays to look at all errors first: that is where they fit the caches of a core.
[[nodiscard]] inline bool is_scanned(const Lattice& lattice) {
  constexpr std::size_t kMost = 1 << 20;
  return lattice.size() <= kMost;
}

/// The mesh whose nodes with errors above the limit are refined, of a whole domain. The samples
/// that they stand on are known and numbered before any triangle is: so those get their corners'
/// numbers on the way. The same for any number of threads.
[[nodiscard]] ScannedMesh mesh_by_scan(const Bisection& bisection, float limit, Threads threads);

}  // namespace lode::bisection
