#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/lattice_point.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// Heights at scattered nodes of a lattice, whose columns and rows are equally far apart.
struct HeightPoints : HeightFrame {
  std::vector<LatticePoint> nodes;  ///< Different, in rows: by y, then x.
  std::vector<double> heights;      ///< By node; finite.
  std::uint64_t n_repeated = 0;     ///< Points at the node of an earlier one.
  double largest_spread = 0;        ///< Of heights at one node.
  double largest_move = 0;          ///< From where a point was to its node, units of the world.

  [[nodiscard]] double step() const { return to_world[1]; }
};

/// What height a node has that several points are at. refused: there are none such.
enum class RepeatedHeights : std::uint8_t { mean, lowest, highest, refused };

/// Where x and y of points are origin + k step, but for rounding, with whole numbers k.
struct PointLattice {
  std::array<double, 2> origin{0, 0};
  double step = 0;  ///< 0: not known.
};

/// Points, x, y and height, finite, on a lattice of at most 2^30 columns and rows. That is the
/// given one where it has no more between the outermost points, so that nothing is moved but for
/// rounding; else one whose step is a power of two, or 1e-150 where that would be less. Fails on no
/// points, on 2^29 and more, on x and y beyond 1e150, and where points are repeated that are
/// refused. O(n log n).
[[nodiscard]] Result<HeightPoints> to_height_points(std::span<const Vec3d> points,
                                                    const PointLattice& lattice,
                                                    RepeatedHeights repeated);

[[nodiscard]] HeightRange height_range(const HeightPoints& points);

}  // namespace lode
