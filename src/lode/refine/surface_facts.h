#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "lode/refine/model.h"

namespace lode {

/// What demands see of a patch of a surface z(x, y): its corners are added one by one.
class SurfacePatch {
 public:
  /// In the world, z the height.
  void add(const Vec3d& corner) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower_[axis] = std::min(lower_[axis], corner[axis]);
      upper_[axis] = std::max(upper_[axis], corner[axis]);
    }
  }
  /// The box of what is no farther from the patch than `error`, vertically, and within a range of
  /// heights; a little more, for rounding, so that what touches the patch touches its bounds.
  [[nodiscard]] Bounds bounds(double error, const Range& heights = kAll) const {
    Vec3d lower = lower_;
    Vec3d upper = upper_;
    lower[2] = std::max(lower[2] - error, heights.low);
    upper[2] = std::min(upper[2] + error, heights.high);
    Bounds bounds{.centre = (lower + upper) * 0.5, .half = (upper - lower) * 0.5};
    for (std::size_t axis = 0; axis < 3; ++axis)
      bounds.radius = std::max(
          {bounds.radius, std::abs(lower[axis]) * 0x1p-50, std::abs(upper[axis]) * 0x1p-50});
    return bounds;
  }
  /// With the same bounds.
  [[nodiscard]] NodeFacts facts(double error, const Range& heights = kAll) const {
    NodeFacts facts;
    facts.error = error;
    facts.range = {std::max(lower_[2] - error, heights.low),
                   std::min(upper_[2] + error, heights.high)};
    facts.bounds = bounds(error, heights);
    return facts;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr Range kAll{-kInfinity, kInfinity};

  Vec3d lower_{{kInfinity, kInfinity, kInfinity}};
  Vec3d upper_{{-kInfinity, -kInfinity, -kInfinity}};
};

}  // namespace lode
