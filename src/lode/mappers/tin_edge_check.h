#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/lattice_point.h"
#include "lode/core/surface.h"
#include "lode/mappers/tin_check.h"

namespace lode {

/// The triangles of a surface as they turn left in the columns and rows of a frame.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> turning_left(const Surface& surface,
                                                                     const HeightFrame& frame);

/// Counts triangles that do not turn left, and adds up the area; `nodes`: by vertex.
void check_turns(std::span<const std::array<std::uint32_t, 3>> triangles,
                 std::span<const LatticePoint> nodes, TinFacts& facts);

/// Whether all of the way between two nodes is outline, the domain on its left.
using IsOutline = std::function<bool(LatticePoint, LatticePoint)>;
/// Whether the edge between two vertices is part of a line, and need not be Delaunay.
using IsFixed = std::function<bool(std::uint32_t, std::uint32_t)>;

/// Columns and rows that no triangle crosses: along them a TIN may have been put together.
class UncrossedLines {
 public:
  /// Nodes are >= 0 and `last` at most.
  UncrossedLines(std::span<const std::array<std::uint32_t, 3>> triangles,
                 std::span<const LatticePoint> nodes, LatticePoint last);

  /// Whether the edge lies on one.
  [[nodiscard]] bool has(LatticePoint a, LatticePoint b) const {
    return (a.x == b.x && n_over_column_[static_cast<std::size_t>(a.x)] == 0) ||
           (a.y == b.y && n_over_row_[static_cast<std::size_t>(a.y)] == 0);
  }

 private:
  std::vector<std::int64_t> n_over_column_;
  std::vector<std::int64_t> n_over_row_;
};

/// Looks at all edges of triangles that turn left: what is beside them, whether those on the border
/// are on the outline and all others Delaunay, which CGAL's exact predicates decide, or fixed.
void check_edges(std::span<const std::array<std::uint32_t, 3>> triangles,
                 std::span<const LatticePoint> nodes, const IsOutline& is_outline, TinFacts& facts,
                 const IsFixed& is_fixed = {});

}  // namespace lode
