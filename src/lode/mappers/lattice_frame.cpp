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

/// Of all of the box, along each axis.
Vec3d largest_coordinates(const Box3d& box, const Vec3d& origin) {
  Vec3d largest;
  for (std::size_t i = 0; i < 3; ++i)
    largest[i] = std::max(std::abs(box.lower[i] - origin[i]), std::abs(box.upper[i] - origin[i]));
  return largest;
}

}  // namespace

double in_steps(const RegularGrid& grid, const Vec3d& distances) {
  // The inverse of the axes' directions is their transposed cofactors over the determinant.
  Mat3 axes = grid.index_to_world_matrix();
  for (Vec3d& row : axes.rows)
    for (std::size_t axis = 0; axis < 3; ++axis) row[axis] /= grid.spacing[axis];
  const Mat3 transposed = cofactors(axes);
  const double det = std::abs(determinant(axes));
  double most = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (grid.dims[axis] < 2) continue;
    double off = 0;
    for (std::size_t i = 0; i < 3; ++i) off += std::abs(transposed.rows[i][axis]) * distances[i];
    most = std::max(most, off / det / grid.spacing[axis]);
  }
  return most;
}

LatticeFrame LatticeFrame::of(const RegularGrid& grid) {
  constexpr double kLargestMargin = 1.0 / 128;
  constexpr double kUlps = 32;
  LatticeFrame frame;
  frame.to_world = grid.index_to_world_matrix();
  frame.is_mirrored = determinant(frame.to_world) < 0;
  const Box3d bounds = grid.world_bounds();
  const auto rounding = [&] {
    Vec3d units = largest_coordinates(bounds, frame.surface_origin);
    for (double& unit : units.v) unit = ulp(unit);
    return in_steps(grid, units);
  };
  frame.rounding = rounding();
  if (kUlps * frame.rounding > kLargestMargin) {
    frame.surface_origin = bounds.lower;
    frame.rounding = rounding();
  }
  frame.origin = grid.origin - frame.surface_origin;
  frame.margin = std::min(0.25, kUlps * frame.rounding);
  return frame;
}

}  // namespace lode
