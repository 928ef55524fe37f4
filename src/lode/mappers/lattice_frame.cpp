#include "lode/mappers/lattice_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode {
namespace {

double ulp(double magnitude) {
  const float f = static_cast<float>(magnitude);
  return static_cast<double>(std::nextafter(f, std::numeric_limits<float>::infinity())) -
         static_cast<double>(f);
}

double largest_coordinate(const Box3d& box, const Vec3d& origin) {
  double largest = 0;
  for (std::size_t i = 0; i < 3; ++i)
    largest =
        std::max({largest, std::abs(box.lower[i] - origin[i]), std::abs(box.upper[i] - origin[i])});
  return largest;
}

}  // namespace

double least_step(const RegularGrid& grid) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i)
    if (grid.dims[i] > 1) least = std::min(least, grid.spacing[i]);
  return std::isfinite(least) ? least : std::ranges::min(grid.spacing.v);
}

LatticeFrame LatticeFrame::of(const RegularGrid& grid) {
  constexpr double kLargestMargin = 1.0 / 256;
  constexpr double kUlps = 16;
  LatticeFrame frame;
  frame.to_world = grid.index_to_world_matrix();
  frame.is_mirrored = determinant(frame.to_world) < 0;
  const Box3d bounds = grid.world_bounds();
  const double step = least_step(grid);
  double unit = ulp(largest_coordinate(bounds, frame.surface_origin));
  if (kUlps * unit / step > kLargestMargin) {
    frame.surface_origin = bounds.lower;
    unit = ulp(largest_coordinate(bounds, frame.surface_origin));
  }
  frame.origin = grid.origin - frame.surface_origin;
  // An oblique direction spreads a step over several world axes; 2 covers the loss.
  frame.margin = std::min(0.25, 2 * kUlps * unit / step);
  frame.rounding = unit / step;
  return frame;
}

}  // namespace lode
