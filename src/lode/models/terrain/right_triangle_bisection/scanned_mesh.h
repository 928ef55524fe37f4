#pragma once

#include <cstddef>

#include "lode/core/parallel.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/right_triangle_bisection/bisection.h"
#include "lode/models/terrain/right_triangle_bisection/sample_numbers.h"

namespace lode::bisection {

/// Whether it pays to look at all errors first: that is where they fit the caches of a core.
[[nodiscard]] inline bool is_scanned(const Lattice& lattice) {
  constexpr std::size_t kMost = 1 << 20;
  return lattice.size() <= kMost;
}

/// The mesh whose nodes with errors above a limit are refined, of a whole domain, in the order of
/// Walk and with its samples numbered. The samples that they stand on are known and numbered before
/// any triangle is: so those get their corners' numbers on the way, and vertices can be made
/// meanwhile. The same for any number of threads.
class MeshScan {
 public:
  /// Marks samples and counts them.
  MeshScan(const Bisection& bisection, float limit, Threads threads);

  /// With marks that are counted; without triangles.
  [[nodiscard]] const SampleMesh& mesh() const { return mesh_; }
  /// No fewer than there are triangles: of each refined node two, or one.
  [[nodiscard]] std::size_t most_triangles() const { return most_triangles_; }
  /// Adds the triangles of the lower or of the upper half, and their errors, to others; both halves
  /// at once, if one likes.
  void walk(std::size_t half, delaunay::Tin& tin) const;

 private:
  const Bisection& bisection_;
  float limit_;
  SampleMesh mesh_;
  std::size_t most_triangles_ = 0;
};

}  // namespace lode::bisection
