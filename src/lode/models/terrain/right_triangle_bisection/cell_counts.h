#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/bisection_lattice.h"

namespace lode::bisection {

/// 1 for each cell with four heights, else 0; cells in rows.
[[nodiscard]] std::vector<std::uint8_t> domain_cells(const HeightGrid& grid);

/// How many cells of rectangles are in the domain.
class CellCounts {
 public:
  CellCounts(const std::vector<std::uint8_t>& cells, const Lattice& lattice);

  /// Of the cells between two nodes of the raster.
  [[nodiscard]] std::uint32_t between(LatticePoint lower, LatticePoint upper) const {
    return at(upper) - at({lower.x, upper.y}) - at({upper.x, lower.y}) + at(lower);
  }
  [[nodiscard]] std::uint32_t all() const { return sums_.back(); }

 private:
  [[nodiscard]] std::uint32_t at(LatticePoint p) const {
    return sums_[static_cast<std::size_t>(std::int64_t{p.y} * width_ + p.x)];
  }

  std::int64_t width_;
  std::vector<std::uint32_t> sums_;  ///< Of the cells below and to the left of each node.
};

/// Makes errors infinite of nodes whose diamonds are partly in the domain, and 0 of those outside.
/// A diamond that reaches beyond the raster counts as its rectangle does.
void mark_outline(const CellCounts& counts, const Lattice& lattice, Threads threads, float* errors);

}  // namespace lode::bisection
