#pragma once

#include <array>
#include <optional>

#include "lode/core/box.h"

namespace lode {

/// The part of a tetrahedron that is in a box, with a function that is linear on the tetrahedron.
struct CellPart {
  double volume = 0;  ///< Whatever the order of the corners.
  double integral = 0;
  /// Proven bounds of what rounding may put these off by.
  double volume_rounding = 0;
  double integral_rounding = 0;
  /// Of the function at the part's corners; lowest > highest where it has none.
  double lowest = 0;
  double highest = -1;
  bool is_whole = false;  ///< All of the tetrahedron is in the box.

  [[nodiscard]] bool is_empty() const { return lowest > highest; }
};

/// Cuts the tetrahedron at the box's six planes into tetrahedra, over which a linear function's
/// integral is the mean of its values at the corners times the volume. `box`: none is all of space.
[[nodiscard]] CellPart part_in_box(const std::array<Vec3d, 4>& corners,
                                   const std::array<double, 4>& values,
                                   const std::optional<Box3d>& box);

}  // namespace lode
