#pragma once

#include <cstdint>
#include <optional>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/models/terrain/right_triangle_bisection/own_errors.h"

namespace lode::bisection {

/// Heights in floating point that are whole numbers of steps of a metre or foot, as those of
/// terrain-RGB are of its tenths: errors of such numbers are found in integers.
struct WholeHeights {
  HeightGrid::Samples<std::uint16_t> samples;  ///< Steps above the lowest; rows as HeightGrid's.
  std::int64_t stride = 0;
  double per_unit = 1;  ///< Steps.
  double largest = 0;   ///< Of the numbers.
  /// Every height is its number of steps exactly; else it is within 2^-49 of the largest |z|.
  bool is_exact = true;
};

/// Of a raster of finite heights without gaps, all within `range`; none where they are no such
/// numbers, or more than 16 bits apart.
template <typename T>
[[nodiscard]] std::optional<WholeHeights> find_whole_heights(const RasterRows<T>& rows,
                                                             LatticePoint last,
                                                             const HeightRange& range,
                                                             Threads threads);

}  // namespace lode::bisection
