#include "lode/mappers/tin_quality.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <vector>

#include "lode/delaunay/triangle_error.h"

namespace lode {
namespace {

constexpr double kUncovered = -1;
constexpr std::size_t kTrianglesAtOnce = 1024;

/// z' on a triangle: the height of a corner, and how far those of the others are from it.
class Plane {
 public:
  Plane(const delaunay::Tin& tin, const std::array<std::uint32_t, 3>& triangle) {
    for (std::size_t i = 0; i < 3; ++i) corners_[i] = tin.vertices[triangle[i]];
    base_ = tin.heights[triangle[0]];
    for (std::size_t i = 0; i < 2; ++i) ways_[i] = tin.heights[triangle[i + 1]] - base_;
    doubled_area_ = side(0, corners_[2].x, corners_[2].y);
  }

  /// Of an edge, positive on its left.
  [[nodiscard]] std::int64_t side(std::size_t edge, std::int64_t x, std::int64_t y) const {
    const delaunay::LatticePoint& a = corners_[edge];
    const delaunay::LatticePoint& b = corners_[(edge + 1) % 3];
    return (std::int64_t{b.x} - a.x) * (y - a.y) - (std::int64_t{b.y} - a.y) * (x - a.x);
  }
  [[nodiscard]] bool holds(std::int64_t x, std::int64_t y) const {
    return side(0, x, y) >= 0 && side(1, x, y) >= 0 && side(2, x, y) >= 0;
  }
  /// |z - z'|, rounded up. All heights are less one of them, as differences of near numbers are
  /// exact.
  [[nodiscard]] double error(std::int64_t x, std::int64_t y, double z) const {
    const auto area = static_cast<long double>(doubled_area_);
    const long double way = static_cast<long double>(side(2, x, y)) * ways_[0] +
                            static_cast<long double>(side(0, x, y)) * ways_[1];
    return delaunay::to_double_above(std::abs((z - base_) * area - way) / area);
  }
  [[nodiscard]] const std::array<delaunay::LatticePoint, 3>& corners() const { return corners_; }
  [[nodiscard]] bool has_area() const { return doubled_area_ > 0; }

 private:
  std::array<delaunay::LatticePoint, 3> corners_;
  long double base_ = 0;
  std::array<long double, 2> ways_{};
  std::int64_t doubled_area_ = 0;
};

void raise(double& to, double error) {
  std::atomic_ref<double> shared(to);
  double there = shared.load(std::memory_order_relaxed);
  while (there < error && !shared.compare_exchange_weak(there, error, std::memory_order_relaxed)) {
  }
}

/// visit(x, y, |z - z'|) for each sample in a triangle; samples are at multiples of the scale.
template <typename Visit>
void visit_samples(const Plane& plane, std::int32_t scale, const HeightGrid& grid,
                   const Visit& visit) {
  if (!plane.has_area()) return;
  const auto above = [scale](std::int32_t at) { return (at + scale - 1) / scale; };
  const auto& [a, b, c] = plane.corners();
  const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
  const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
  for (std::int32_t y = above(y_low); y <= y_high / scale; ++y)
    for (std::int32_t x = above(x_low); x <= x_high / scale; ++x) {
      const std::int64_t column = std::int64_t{x} * scale;
      const std::int64_t row = std::int64_t{y} * scale;
      if (!plane.holds(column, row) || !grid.has_height(x, y)) continue;
      visit(x, y, plane.error(column, row, grid.height(x, y)));
    }
}

double smallest_angle_of(const Plane& plane, const HeightFrame& frame) {
  std::array<Vec<double, 2>, 3> p;
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = frame.world(plane.corners()[i].x, plane.corners()[i].y);
  double least = 180;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto u = p[(i + 1) % 3] - p[i];
    const auto v = p[(i + 2) % 3] - p[i];
    const double turn = std::abs(u[0] * v[1] - u[1] * v[0]);
    least = std::min(least, std::atan2(turn, u[0] * v[0] + u[1] * v[1]) * 180 / std::numbers::pi);
  }
  return least;
}

}  // namespace

TinAngles measure_angles(const delaunay::Tin& tin, const HeightFrame& frame, Threads threads) {
  TinAngles made;
  if (tin.triangles.empty()) return made;
  std::vector<double> angles(tin.triangles.size());
  parallel_for(tin.triangles.size(), threads, kTrianglesAtOnce, [&](std::size_t t, int) {
    angles[t] = smallest_angle_of(Plane(tin, tin.triangles[t]), frame);
  });
  constexpr double kStep = 5;
  for (const double angle : angles) {
    const auto step = static_cast<std::size_t>(std::max(0.0, angle / kStep));
    ++made.counts[std::min(step, made.counts.size() - 1)];
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  made.median = *middle;
  made.smallest = *std::min_element(angles.begin(), angles.end());
  return made;
}

double worst_error_in(const delaunay::Tin& tin, std::size_t triangle, std::int32_t scale,
                      const HeightGrid& grid) {
  double worst = 0;
  visit_samples(Plane(tin, tin.triangles[triangle]), scale, grid,
                [&](std::int32_t, std::int32_t, double error) { worst = std::max(worst, error); });
  return worst;
}

void visit_errors_in(const delaunay::Tin& tin, std::size_t triangle, std::int32_t scale,
                     const HeightGrid& grid,
                     const std::function<void(LatticePoint, double)>& visit) {
  visit_samples(Plane(tin, tin.triangles[triangle]), scale, grid,
                [&](std::int32_t x, std::int32_t y, double error) {
                  visit(LatticePoint{x, y}, error);
                });
}

TinQuality measure_quality(const delaunay::Tin& tin, std::int32_t scale, const HeightGrid& grid,
                           Threads threads) {
  std::vector<double> errors(static_cast<std::size_t>(grid.n_samples()), kUncovered);
  parallel_for(tin.triangles.size(), threads, kTrianglesAtOnce, [&](std::size_t t, int) {
    visit_samples(Plane(tin, tin.triangles[t]), scale, grid,
                  [&](std::int32_t x, std::int32_t y, double error) {
                    const std::int64_t at = std::int64_t{y} * grid.n_columns + x;
                    raise(errors[static_cast<std::size_t>(at)], error);
                  });
  });
  TinQuality quality;
  double squares = 0;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      if (!grid.has_height(x, y)) continue;
      const double error = errors[static_cast<std::size_t>(std::int64_t{y} * grid.n_columns + x)];
      if (error == kUncovered) {
        ++quality.n_uncovered;
        continue;
      }
      ++quality.n_samples;
      quality.worst_error = std::max(quality.worst_error, error);
      squares += error * error;
    }
  if (quality.n_samples > 0)
    quality.rms_error = std::sqrt(squares / static_cast<double>(quality.n_samples));
  quality.angles = measure_angles(tin, grid, threads);
  return quality;
}

}  // namespace lode
