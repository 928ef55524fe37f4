#include "lode/models/diamond/surface_coordinates.h"

#include <algorithm>
#include <cmath>

#include "lode/mappers/surface_edits.h"

namespace lode::diamond {
namespace {

/// Two units in the last place of float32; 32 of double cover the dozen operations of to_index.
constexpr double kFloatRounding = 0x1p-22;
constexpr double kDoubleRounding = 0x1p-48;

/// Which of the two planes `lower` and `upper` the coordinate is in, as bits; then what is outside.
struct PlaneSides {
  unsigned planes = 0;
  bool is_outside = false;
};

PlaneSides sides_of(double coordinate, double lower, double upper, double rounding) {
  PlaneSides sides;
  if (std::abs(coordinate - lower) <= rounding) sides.planes |= 1U;
  if (std::abs(coordinate - upper) <= rounding) sides.planes |= 2U;
  sides.is_outside = coordinate < lower - rounding || coordinate > upper + rounding;
  return sides;
}

}  // namespace

SurfaceCoordinates::SurfaceCoordinates(const RegularGrid& grid, const Surface& surface,
                                       const std::optional<Box3d>& clip, Threads threads)
    : index_(surface.positions.size()), planes_(surface.positions.size()) {
  find_rounding(grid, surface);
  if (clip) clip_rounding_ = crop_rounding(*clip, grid.world_bounds(), surface.origin);
  parallel_for(index_.size(), threads, 4096, [&](std::size_t v, int) {
    const auto vertex = static_cast<std::uint32_t>(v);
    place(grid, surface.world_position(vertex), clip, vertex);
  });
}

void SurfaceCoordinates::find_rounding(const RegularGrid& grid, const Surface& surface) {
  Vec3d largest;
  for (const Vec3f& p : surface.positions)
    for (std::size_t i = 0; i < 3; ++i)
      largest[i] = std::max(largest[i], std::abs(static_cast<double>(p[i])));
  const Mat3 matrix = grid.index_to_world_matrix();
  const Mat3 cofactor = cofactors(matrix);
  const double scale = 1.0 / std::abs(determinant(matrix));
  for (std::size_t j = 0; j < 3; ++j) {
    const double double_part =
        kDoubleRounding * (largest[j] + std::abs(surface.origin[j]) + std::abs(grid.origin[j]));
    world_rounding_[j] = kFloatRounding * largest[j] + double_part;
    Vec3d unit;
    unit[j] = 1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double slope = std::abs(dot(cofactor.column(i), unit)) * scale;
      rounding_[i] += slope * world_rounding_[j];
      check_rounding_ = std::max(check_rounding_, 3 * slope * double_part);
    }
  }
}

void SurfaceCoordinates::place(const RegularGrid& grid, const Vec3d& world,
                               const std::optional<Box3d>& clip, std::uint32_t vertex) {
  const Vec3d index = grid.to_index(world);
  unsigned planes = 0;
  bool is_outside = false;
  for (unsigned i = 0; i < 3; ++i) {
    const double last = static_cast<double>(grid.dims[i] - 1);
    const PlaneSides border = sides_of(index[i], 0.0, last, rounding_[i]);
    is_outside |= border.is_outside;
    // Across an axis of one sample everything lies in its plane: that is no border.
    if (grid.dims[i] > 1) planes |= border.planes << (2 * i);
    index_[vertex][i] = std::clamp(index[i], 0.0, last);
    if (!clip) continue;
    const PlaneSides cut =
        sides_of(world[i], clip->lower[i], clip->upper[i], clip_rounding_ + world_rounding_[i]);
    is_outside |= cut.is_outside;
    planes |= cut.planes << (6 + 2 * i);
  }
  planes_[vertex] = static_cast<std::uint16_t>(planes | (is_outside ? kOutside : 0U));
}

}  // namespace lode::diamond
