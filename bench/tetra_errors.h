#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode::bench {

/// A field that is linear on tetrahedra; what it refers to must outlive it.
struct TetraField {
  std::span<const Vec3d> positions;
  std::span<const double> values;  ///< By position.
  std::span<const std::array<std::uint32_t, 4>> tetrahedra;
};

/// The field at a point, or at the nearest one of the mesh where the point is outside.
struct Located {
  double value = 0;
  double distance = 0;  ///< To the mesh.
};

/// Finds points among tetrahedra, with a lattice over their boxes. Where some overlap, the one
/// counts in which the point's smallest barycentric weight is largest. Knows nothing of how the
/// mesh came. Any number of threads may ask.
class TetraLocator {
 public:
  explicit TetraLocator(const TetraField& field);

  [[nodiscard]] Located locate(const Vec3d& p) const;

 private:
  using Cell = std::array<int, 3>;

  [[nodiscard]] int index(double x, std::size_t axis) const;
  [[nodiscard]] std::size_t number(int x, int y, int z) const;
  [[nodiscard]] double reach(const Vec3d& p, const Cell& at, int ring) const;
  void set_lattice();
  template <typename Visit>
  void visit_cells_of(std::size_t tetrahedron, const Visit& visit) const;
  template <typename Visit>
  void visit_ring(const Cell& at, int ring, const Visit& visit) const;

  TetraField field_;
  Vec3d lower_;
  double edge_ = 1;
  Cell dims_{};
  std::vector<std::uint64_t> begins_;  ///< By cell of the lattice, and one more.
  std::vector<std::uint32_t> tetrahedra_;
};

/// In the field's and the mesh's units, over all vertices of a reference mesh.
struct FieldErrors {
  double max = 0;
  double rms = 0;
  double farthest = 0;  ///< Of those outside the simplified mesh.
};

/// |F - F'| of the reference's first field.
[[nodiscard]] FieldErrors measure_errors(const TetraMesh& reference, const TetraField& simplified,
                                         Threads threads);

/// Holds the locator against a search of all tetrahedra, and against a field and a distance that
/// are known. `mesh`: of [0, 1]^3, with any field.
[[nodiscard]] Result<void> check_locator(const TetraField& mesh);

}  // namespace lode::bench
