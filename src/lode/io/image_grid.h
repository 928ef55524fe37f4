#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "lode/core/regular_grid.h"
#include "lode/core/result.h"

namespace lode::io {

/// Where the samples lie, as files say it: step[i] is the world vector from a sample to the next
/// one along axis i.
struct GridSteps {
  Index3 dims;
  std::array<Vec3d, 3> steps;
  Vec3d origin{{0, 0, 0}};
  Frame frame = Frame::unknown;
};

/// Splits steps into spacings > 0 and unit directions. An axis of one sample may have a zero step:
/// it gets a unit one at right angles to the others. Fails on values that are not finite, zero
/// steps and linearly dependent axes; shear is allowed.
[[nodiscard]] Result<RegularGrid> make_grid(const std::string& path, const GridSteps& steps);

/// Spacing and direction as most files have them; columns of `direction` are the axes. Columns
/// need not have length 1 (the length scales the spacing), and a negative spacing mirrors.
struct GridFrame {
  Index3 dims;
  Vec3d spacing{{1, 1, 1}};
  Vec3d origin{{0, 0, 0}};
  Mat3 direction = Mat3::identity();
  Frame frame = Frame::unknown;
};
[[nodiscard]] Result<RegularGrid> make_grid(const std::string& path, const GridFrame& frame);

/// An evenly spaced axis: position = first + step · i; step < 0 when the axis descends.
struct UniformAxis {
  double first = 0;
  double step = 1;
};

/// What the positions along one axis were rounded to.
enum class AxisPrecision { float32, float64 };

/// Fits an evenly spaced axis. Fails, naming the axis and the largest deviation, when a position
/// is off by more than 1e-5 of the step plus one unit in the last place of the file's type (at the
/// largest coordinate): longitudes in float32 pass, uneven levels do not.
[[nodiscard]] Result<UniformAxis> fit_uniform_axis(const std::string& path, char axis,
                                                   std::span<const double> positions,
                                                   AxisPrecision precision);

/// The positions along the three axes of a rectilinear grid, as its file has them.
struct RectilinearAxes {
  std::array<std::vector<double>, 3> positions;
  std::array<AxisPrecision, 3> precisions{};
};

/// A grid of evenly spaced axes (see fit_uniform_axis); descending ones are mirrored.
[[nodiscard]] Result<RegularGrid> make_grid(const std::string& path, const RectilinearAxes& axes);

}  // namespace lode::io
