#include "lode/io/image_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::io {
namespace {

constexpr std::string_view kAxisNames = "xyz";

bool is_finite(const Vec3d& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

double largest_component(const Vec3d& v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

/// Length that cannot under- or overflow half-way and is exact for vectors along an axis.
double safe_length(const Vec3d& v) {
  const double scale = largest_component(v);
  if (scale <= 0) return 0;
  return scale * length(Vec3d{{v[0] / scale, v[1] / scale, v[2] / scale}});
}

/// A unit vector at right angles to the non-zero ones of `others`.
Vec3d perpendicular(const Vec3d& a, const Vec3d& b, std::size_t axis) {
  const Vec3d normal = cross(a, b);
  if (length(normal) > 0) return normalized(normal);
  const Vec3d& along = length(a) > 0 ? a : b;
  Vec3d best{};
  best[axis] = 1;
  if (length(along) <= 0) return best;
  // Gram-Schmidt of the coordinate axis least aligned with `along`, trying `axis` first.
  if (std::abs(along[axis]) > 0.9) {
    best = {};
    best[(axis + 1) % 3] = std::abs(along[(axis + 1) % 3]) <= 0.9 ? 1 : 0;
    best[(axis + 2) % 3] = best[(axis + 1) % 3] > 0 ? 0 : 1;
  }
  return normalized(best - along * dot(along, best));
}

void fill_thin_axes(RegularGrid& grid, std::array<Vec3d, 3>& columns) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (grid.spacing[i] > 0 || grid.dims[i] != 1) continue;
    grid.spacing[i] = 1;
    columns[i] = perpendicular(columns[(i + 1) % 3], columns[(i + 2) % 3], i);
  }
}

Result<RegularGrid> finish_grid(const std::string& path, RegularGrid grid,
                                std::array<Vec3d, 3> columns) {
  if (!is_finite(grid.origin)) return fail("{}: expected a finite origin", path);
  fill_thin_axes(grid, columns);
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(grid.spacing[i] > 0) || !std::isfinite(grid.spacing[i]))
      return fail("{}: expected a finite, non-zero spacing along axis {}, got {}", path,
                  kAxisNames[i], grid.spacing[i]);
    for (std::size_t row = 0; row < 3; ++row) grid.direction.rows[row][i] = columns[i][row];
  }
  // Unit columns: the determinant is the volume of their parallelepiped.
  constexpr double kMinVolume = 1e-6;
  const double volume = determinant(grid.direction);
  if (!(std::abs(volume) >= kMinVolume))
    return fail("{}: expected three independent axis directions, got a determinant of {}", path,
                volume);
  const Box3d bounds = grid.world_bounds();
  if (!is_finite(bounds.lower) || !is_finite(bounds.upper))
    return fail("{}: expected samples at finite places, got steps that lead beyond them", path);
  return grid;
}

}  // namespace

Result<RegularGrid> make_grid(const std::string& path, const GridSteps& steps) {
  RegularGrid grid{.dims = steps.dims, .origin = steps.origin, .frame = steps.frame};
  std::array<Vec3d, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& step = steps.steps[i];
    if (!is_finite(step))
      return fail("{}: expected a finite step along axis {}", path, kAxisNames[i]);
    grid.spacing[i] = safe_length(step);
    if (grid.spacing[i] > 0)
      for (std::size_t j = 0; j < 3; ++j) columns[i][j] = step[j] / grid.spacing[i];
  }
  return finish_grid(path, grid, columns);
}

Result<RegularGrid> make_grid(const std::string& path, const GridFrame& frame) {
  RegularGrid grid{.dims = frame.dims, .origin = frame.origin, .frame = frame.frame};
  std::array<Vec3d, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    Vec3d column = frame.direction.column(i);
    if (!is_finite(column) || !std::isfinite(frame.spacing[i]))
      return fail("{}: expected a finite spacing and direction along axis {}", path, kAxisNames[i]);
    const double n = safe_length(column);
    // Below this a column is a unit one but for rounding, and the file's spacing stays as written.
    constexpr double kUnitTolerance = 1e-12;
    const bool is_unit = std::abs(n - 1) <= kUnitTolerance;
    grid.spacing[i] = std::abs(frame.spacing[i]) * (is_unit ? 1 : n);
    if (!(grid.spacing[i] > 0)) continue;
    for (double& c : column.v) {
      if (!is_unit) c /= n;
      if (frame.spacing[i] < 0) c = 0 - c;
    }
    columns[i] = column;
  }
  return finish_grid(path, grid, columns);
}

Result<UniformAxis> fit_uniform_axis(const std::string& path, char axis,
                                     std::span<const double> positions, AxisPrecision precision) {
  LODE_EXPECTS(!positions.empty());
  double largest = 0;
  for (const double p : positions) {
    if (!std::isfinite(p)) return fail("{}: expected finite positions along axis {}", path, axis);
    largest = std::max(largest, std::abs(p));
  }
  UniformAxis fit{positions.front(), 1};
  if (positions.size() == 1) return fit;
  const auto n_steps = static_cast<double>(positions.size() - 1);
  fit.step = (positions.back() - positions.front()) / n_steps;
  const double ulp = precision == AxisPrecision::float32
                         ? double{std::numeric_limits<float>::epsilon()}
                         : std::numeric_limits<double>::epsilon();
  const double tolerance = 1e-5 * std::abs(fit.step) + ulp * largest;
  double worst = 0;
  std::size_t worst_at = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double off = std::abs(positions[i] - (fit.first + fit.step * static_cast<double>(i)));
    if (off > worst) {
      worst = off;
      worst_at = i;
    }
  }
  if (worst > tolerance || !std::isfinite(fit.step))
    return fail(
        "{}: axis {} is not evenly spaced: position {} is {} off an even spacing of {} (at most {} "
        "is allowed); resample it first",
        path, axis, worst_at, worst, fit.step, tolerance);
  return fit;
}

Result<RegularGrid> make_grid(const std::string& path, const RectilinearAxes& axes) {
  GridFrame frame;
  for (std::size_t i = 0; i < 3; ++i) {
    LODE_TRY(const UniformAxis axis,
             fit_uniform_axis(path, kAxisNames[i], axes.positions[i], axes.precisions[i]));
    frame.dims[i] = static_cast<std::int32_t>(axes.positions[i].size());
    frame.origin[i] = axis.first;
    frame.spacing[i] = axis.step;
  }
  return make_grid(path, frame);
}

}  // namespace lode::io
