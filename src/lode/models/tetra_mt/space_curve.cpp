#include "lode/models/tetra_mt/space_curve.h"

#include <algorithm>
#include <cmath>

namespace lode::tetra_mt {
namespace {

constexpr double kCurveSteps = 1 << 21;  ///< Of each coordinate.

/// 21 bits, two zeros before each.
std::uint64_t spaced(std::uint64_t bits) {
  bits = (bits | bits << 32) & 0x001F00000000FFFFU;
  bits = (bits | bits << 16) & 0x001F0000FF0000FFU;
  bits = (bits | bits << 8) & 0x100F00F00F00F00FU;
  bits = (bits | bits << 4) & 0x10C30C30C30C30C3U;
  return (bits | bits << 2) & 0x1249249249249249U;
}

}  // namespace

SpaceCurve::SpaceCurve(std::span<const Vec3d> positions) {
  double width = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto by_axis = [i](const Vec3d& p) { return p[i]; };
    if (positions.empty()) break;
    lower_[i] = std::ranges::min(positions, {}, by_axis)[i];
    width = std::max(width, std::ranges::max(positions, {}, by_axis)[i] - lower_[i]);
  }
  scale_ = width > 0 ? kCurveSteps / width : 0;
  if (!std::isfinite(scale_)) scale_ = 0;
}

std::uint64_t SpaceCurve::operator()(const Vec3d& p) const {
  std::uint64_t key = 0;
  if (!(scale_ > 0)) return key;
  for (std::size_t i = 0; i < 3; ++i) {
    const double step = std::clamp((p[i] - lower_[i]) * scale_, 0.0, kCurveSteps - 1);
    key |= spaced(static_cast<std::uint64_t>(step)) << i;
  }
  return key;
}

}  // namespace lode::tetra_mt
