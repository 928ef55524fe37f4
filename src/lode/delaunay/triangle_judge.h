#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// Rounded up.
[[nodiscard]] inline float to_float_above(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value
             ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
             : nearest;
}

/// Finds out whether triangles are within a tolerance, and the samples to insert where they are
/// not.
template <typename T>
class TriangleJudge {
 public:
  TriangleJudge(const SampleRows<T>& rows, double lower, double upper, double max_error)
      : rows_(rows),
        lane_slack_(lane_slack<T>(lower, upper)),
        double_slack_(double_slack(lower, upper)),
        max_error_(max_error),
        find_(find_worst_sample<T>()) {}

  /// Sets the triangle's candidate (kNone: all within the tolerance) and error, a bound of all.
  void judge(LatticeTriangle& triangle) const {
    WorstSample worst = find_(rows_, lane_slack_, triangle.corner);
    // Not within the tolerance, and not surely beyond: rounding must not decide.
    if (worst.error > max_error_ && worst.error - 2 * worst.slack <= max_error_)
      worst = find_worst_exactly(rows_, double_slack_, triangle.corner);
    triangle.candidate = worst.error > max_error_ ? worst.node : WorstSample::kNone;
    triangle.error = to_float_above(worst.error);
  }

 private:
  SampleRows<T> rows_;
  RoundingSlack lane_slack_;
  RoundingSlack double_slack_;
  double max_error_;
  FindWorst<T> find_;
};

/// Largest error first, then first position.
[[nodiscard]] inline std::uint64_t priority_of(const LatticeTriangle& triangle) {
  return (std::uint64_t{std::bit_cast<std::uint32_t>(triangle.error)} << 32) | ~triangle.candidate;
}

}  // namespace lode::delaunay
