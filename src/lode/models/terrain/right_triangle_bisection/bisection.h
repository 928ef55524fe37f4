#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/uninitialized_array.h"
#include "lode/models/terrain/right_triangle_bisection/bisection_lattice.h"

namespace lode::bisection {

/// Right triangles over a raster of any size, bisected at the middles of their longest edges: the
/// hierarchy of M. Duchaineau et al., "ROAMing terrain" (1997), and W. Evans, D. Kirkpatrick,
/// G. Townsend, "Right-triangulated irregular networks" (2001), which is diamond2d of
/// docs/models/diamond3d.md, with an array of errors for all that it stores.
///
/// The error of a node is the largest own error (own_errors.h) of it and of all nodes that wait for
/// it, so the nodes with errors above a tolerance are a mesh without gaps, and no sample is farther
/// from that than the tolerance. Infinite where a diamond is partly outside the domain, the union
/// of the cells with four heights: so its outline is in every mesh.
class Bisection {
 public:
  /// Fails where no cell has four heights, on heights beyond 1e30, on rasters whose columns and
  /// rows need more than 32 bits together, and when cancelled. The same for any number of threads.
  /// Memory: 4 bytes a sample; while it is built 5 more where heights are missing, and 2 where
  /// those in floating point are whole numbers.
  [[nodiscard]] static Result<Bisection> build(const HeightGrid& grid, Threads threads,
                                               Progress& progress);

  [[nodiscard]] const Lattice& lattice() const { return lattice_; }
  /// Of the lattice's nodes but its corners, whose diamonds have some area.
  [[nodiscard]] float error(LatticePoint node) const { return errors_[lattice_.index(node)]; }
  [[nodiscard]] const float* errors() const { return errors_.data(); }
  /// Of a cell of the raster, by its lower corner.
  [[nodiscard]] bool has_cell(LatticePoint cell) const {
    return cells_.empty() ||
           cells_[static_cast<std::size_t>(std::int64_t{cell.y} * lattice_.last().x + cell.x)] != 0;
  }
  [[nodiscard]] bool is_whole() const { return cells_.empty(); }
  /// Of a triangle of a mesh, its last corner the one at the right angle: as all of its cells are
  /// in the domain or none, the one in that corner tells.
  [[nodiscard]] bool has_triangle(const std::array<LatticePoint, 3>& corners) const;
  /// Whether a sample is a corner of a cell of the domain.
  [[nodiscard]] bool has_node(LatticePoint p) const;

  /// Makes samples vertices of all meshes: different nodes of the domain, in rows.
  void keep(std::vector<LatticePoint> nodes);
  [[nodiscard]] const std::vector<LatticePoint>& kept() const { return kept_; }
  [[nodiscard]] std::uint64_t n_bytes() const {
    return errors_.size() * sizeof(float) + cells_.size();
  }

 private:
  explicit Bisection(const Lattice& lattice) : lattice_(lattice) {}

  Lattice lattice_;
  UninitializedArray<float> errors_;
  std::vector<std::uint8_t> cells_;  ///< Empty: all are in the domain.
  std::vector<LatticePoint> kept_;
};

}  // namespace lode::bisection
