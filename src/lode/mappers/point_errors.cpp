#include "lode/mappers/point_errors.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>

#include "lode/delaunay/lattice.h"
#include "lode/mappers/point_squares.h"

namespace lode {
namespace {

using delaunay::doubled_area;

/// The largest error of a point in a triangle.
long double worst_error_in(const delaunay::Tin& tin, std::size_t t, const HeightPoints& points,
                           const PointSquares& squares) {
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
  long double worst = 0;
  squares.for_each_near({left, low}, {right, high}, [&](std::uint32_t i) {
    const LatticePoint p = points.nodes[i];
    const std::array<std::int64_t, 3> weight{doubled_area(at[1], at[2], p),
                                             doubled_area(at[2], at[0], p),
                                             doubled_area(at[0], at[1], p)};
    if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) return;
    const long double way = (static_cast<long double>(weight[1]) * (z[1] - z[0]) +
                             static_cast<long double>(weight[2]) * (z[2] - z[0])) /
                            area;
    worst = std::max(worst, std::abs((points.heights[i] - z[0]) - way));
  });
  return worst;
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

}  // namespace lode
