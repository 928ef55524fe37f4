#include "lode/mappers/point_errors.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/mappers/point_squares.h"

namespace lode {
namespace {

using delaunay::doubled_area;

/// visit(number, error) for the points in a triangle, which are at multiples of the scale.
template <typename Visit>
void visit_points(const delaunay::Tin& tin, std::size_t t, std::int32_t scale,
                  const HeightPoints& points, const PointSquares& squares, const Visit& visit) {
  const auto& corner = tin.triangles[t];
  std::array<LatticePoint, 3> at;
  std::array<long double, 3> z{};
  for (std::size_t i = 0; i < 3; ++i) {
    at[i] = tin.vertices[corner[i]];
    z[i] = tin.heights[corner[i]];
  }
  const auto area = static_cast<long double>(doubled_area(at[0], at[1], at[2]));
  const auto [left, right] = std::minmax({at[0].x, at[1].x, at[2].x});
  const auto [low, high] = std::minmax({at[0].y, at[1].y, at[2].y});
  squares.for_each_near(
      {left / scale, low / scale}, {right / scale, high / scale}, [&](std::uint32_t i) {
        const LatticePoint p{points.nodes[i].x * scale, points.nodes[i].y * scale};
        const std::array<std::int64_t, 3> weight{doubled_area(at[1], at[2], p),
                                                 doubled_area(at[2], at[0], p),
                                                 doubled_area(at[0], at[1], p)};
        if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) return;
        const long double way = (static_cast<long double>(weight[1]) * (z[1] - z[0]) +
                                 static_cast<long double>(weight[2]) * (z[2] - z[0])) /
                                area;
        visit(i, std::abs((points.heights[i] - z[0]) - way));
      });
}

/// The largest error of a point in a triangle.
long double worst_error_in(const delaunay::Tin& tin, std::size_t t, const HeightPoints& points,
                           const PointSquares& squares) {
  long double worst = 0;
  visit_points(tin, t, 1, points, squares,
               [&](std::uint32_t, long double error) { worst = std::max(worst, error); });
  return worst;
}

void raise_to(double& to, double error) {
  std::atomic_ref<double> shared(to);
  double there = shared.load(std::memory_order_relaxed);
  while (there < error && !shared.compare_exchange_weak(there, error, std::memory_order_relaxed)) {
  }
}

}  // namespace

Result<std::uint64_t> count_understated_points(const delaunay::Tin& tin, const HeightPoints& points,
                                               Threads threads, Progress& progress) {
  const PointSquares squares(points);
  const HeightRange range = height_range(points);
  const long double slack = 0x1p-60L * (static_cast<long double>(range.upper) - range.lower);
  std::atomic<std::uint64_t> n_understated = 0;
  constexpr std::size_t kAtOnce = 256;
  parallel_for(tin.triangles.size(), threads, kAtOnce, [&](std::size_t t, int) {
    if (progress.is_cancelled()) return;
    const auto stated = static_cast<long double>(tin.errors[t]);
    if (worst_error_in(tin, t, points, squares) > stated + slack) ++n_understated;
  });
  if (progress.is_cancelled()) return cancelled_error();
  return n_understated.load();
}

TinQuality measure_point_quality(const delaunay::Tin& tin, std::int32_t scale,
                                 const HeightPoints& points, Threads threads) {
  constexpr double kUncovered = -1;
  constexpr std::size_t kAtOnce = 256;
  const PointSquares squares(points);
  std::vector<double> errors(points.nodes.size(), kUncovered);
  parallel_for(tin.triangles.size(), threads, kAtOnce, [&](std::size_t t, int) {
    visit_points(tin, t, scale, points, squares, [&](std::uint32_t i, long double error) {
      raise_to(errors[i], static_cast<double>(error));
    });
  });
  TinQuality quality;
  double squares_sum = 0;
  for (const double error : errors) {
    if (error == kUncovered) {
      ++quality.n_uncovered;
      continue;
    }
    ++quality.n_samples;
    quality.worst_error = std::max(quality.worst_error, error);
    squares_sum += error * error;
  }
  if (quality.n_samples > 0)
    quality.rms_error = std::sqrt(squares_sum / static_cast<double>(quality.n_samples));
  quality.angles = measure_angles(tin, points, threads);
  return quality;
}

}  // namespace lode
