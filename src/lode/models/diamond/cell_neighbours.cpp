#include "lode/models/diamond/cell_neighbours.h"

namespace lode::diamond {
namespace {

bool holds(const Index3& cell, const Piece& piece, const Index3& dims, const Vec3d& rounding) {
  for (std::size_t k = 0; k < piece.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i) {
      const double lower = static_cast<double>(cell[i]);
      const double upper = dims[i] == 1 ? lower : lower + 1;
      const double x = piece[k][i];
      if (x < lower - rounding[i] || x > upper + rounding[i]) return false;
    }
  return true;
}

}  // namespace

std::optional<Index3> find_near_cell(const FieldSamples& samples, const Index3& cell,
                                     const Piece& piece, const Vec3d& rounding, CellState state) {
  const Index3& dims = samples.grid().dims;
  for (std::int32_t dz = -1; dz <= 1; ++dz)
    for (std::int32_t dy = -1; dy <= 1; ++dy)
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        const Index3 near = cell + Index3{{dx, dy, dz}};
        if (!is_cell(dims, near) || !holds(near, piece, dims, rounding)) continue;
        if (is_removed_cell(samples, near) == (state == CellState::removed)) return near;
      }
  return std::nullopt;
}

}  // namespace lode::diamond
