#pragma once

// Distances by the regions of a triangle (Eberly), in doubles, from points on all
// triangles to all triangles. It shares no code with the library.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/core/surface.h"

namespace lode::test {

inline Vec3d widen(const Vec3f& p) { return {{double{p[0]}, double{p[1]}, double{p[2]}}}; }

inline double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double t = dot(e, e) > 0 ? std::clamp(dot(p - a, e) / dot(e, e), 0.0, 1.0) : 0;
  return length(p - (a + e * t));
}

inline double triangle_distance(const Vec3d& p, const std::array<Vec3d, 3>& t) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  bool is_above = dot(n, n) > 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& a = t[i];
    const Vec3d& b = t[(i + 1) % 3];
    is_above = is_above && dot(cross(n, b - a), p - a) >= 0;
  }
  if (is_above) return std::abs(dot(n, p - t[0])) / length(n);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i)
    least = std::min(least, segment_distance(p, t[i], t[(i + 1) % 3]));
  return least;
}

inline std::array<Vec3d, 3> corners_of(const Surface& surface, std::size_t t) {
  const auto& v = surface.triangles[t];
  return {widen(surface.positions[v[0]]), widen(surface.positions[v[1]]),
          widen(surface.positions[v[2]])};
}

/// A surface to find distances to. Neighbouring points have near triangles that are near.
class DistanceTarget {
 public:
  explicit DistanceTarget(const Surface& surface) {
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const auto c = corners_of(surface, t);
      Ball ball{c, (c[0] + c[1] + c[2]) * (1.0 / 3), 0};
      for (const Vec3d& corner : c)
        ball.radius = std::max(ball.radius, length(corner - ball.middle));
      largest_radius_ = std::max(largest_radius_, ball.radius);
      balls_.push_back(ball);
    }
    std::ranges::sort(balls_, {}, x_of);
  }
  double distance(const Vec3d& p) {
    double least = triangle_distance(p, balls_[last_].triangle);
    // Both ways along x, to where no triangle can be nearer.
    const auto first =
        static_cast<std::size_t>(std::ranges::lower_bound(balls_, p[0], {}, x_of) - balls_.begin());
    for (std::size_t t = first; t < balls_.size() && look_at(t, p, least);) ++t;
    for (std::size_t t = first; t > 0 && look_at(t - 1, p, least);) --t;
    return least;
  }

 private:
  struct Ball {
    std::array<Vec3d, 3> triangle;
    Vec3d middle;
    double radius;
  };
  static double x_of(const Ball& ball) { return ball.middle[0]; }
  /// False where this one, and so all farther along x, cannot be nearer.
  bool look_at(std::size_t t, const Vec3d& p, double& least) {
    const Ball& ball = balls_[t];
    const Vec3d d = p - ball.middle;
    if (std::abs(d[0]) >= least + largest_radius_) return false;
    const double reach = least + ball.radius;
    if (dot(d, d) >= reach * reach) return true;
    const double here = triangle_distance(p, ball.triangle);
    if (here >= least) return true;
    least = here;
    last_ = t;
    return true;
  }

  std::vector<Ball> balls_;
  double largest_radius_ = 0;
  std::size_t last_ = 0;
};

/// The largest distance from points on all triangles of `from`, (n + 1)(n + 2) / 2 on each.
inline double one_sided_distance(const Surface& from, const Surface& to, int n) {
  DistanceTarget target(to);
  double largest = 0;
  for (std::size_t t = 0; t < from.triangles.size(); ++t) {
    const auto c = corners_of(from, t);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        largest = std::max(largest, target.distance(c[0] + (c[1] - c[0]) * (double(i) / n) +
                                                    (c[2] - c[0]) * (double(j) / n)));
  }
  return largest;
}

}  // namespace lode::test
