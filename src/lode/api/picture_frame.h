#pragma once

#include <algorithm>
#include <optional>

#include "lode/core/height_frame.h"
#include "lode/core/horizontal_metric.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"
#include "lode/refine/model.h"

namespace lode {

/// Where pictures of a terrain have it, and their cameras stand: in metres from the middle of its
/// outline and of its range of heights, x east, y north, z up and exaggerated.
struct PictureFrame {
  Vec<double, 2> middle;  ///< In the world.
  double x_scale = 1;     ///< Metres of a unit of the world: where these are angles, in the middle.
  double y_scale = 1;
  double z_scale = 1;   ///< Metres of a unit of heights, exaggeration included.
  double z_middle = 0;  ///< Units of the heights.
  Vec<double, 2> half;  ///< Metres, of the outline.
  double exaggeration = 1;
  /// Else it is assumed (HorizontalMetric::assumed_height_unit()).
  bool is_vertical_unit_known = false;

  [[nodiscard]] Vec3d place(const Vec<double, 2>& at, double height) const {
    return {{(at[0] - middle[0]) * x_scale, (at[1] - middle[1]) * y_scale,
             (height - z_middle) * z_scale}};
  }
  /// Contain what is in bounds of x and y in the world and of heights.
  [[nodiscard]] Bounds place(const Bounds& world) const;
  [[nodiscard]] double longer_side() const { return 2 * std::max(half[0], half[1]); }
};

/// Longitudes and latitudes count as much as they do in the outline's middle, but not nearer to the
/// poles than 85 degrees; heights as metres_of_unit() says, else as the metric assumes. Without an
/// exaggeration it is 1, or the largest of 2, 5, 10, ... that makes the relief at most an eighth of
/// the longer side. Fails on exaggerations that are not from 1e-6 to 1e6, and as check_angles()
/// does.
[[nodiscard]] Result<PictureFrame> picture_frame(const HeightFrame& grid, const HeightRange& range,
                                                 const HorizontalMetric& metric,
                                                 const std::optional<double>& exaggeration);

}  // namespace lode
