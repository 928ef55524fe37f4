#include "lode/models/tetra_mt/value_distance.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "lode/core/point_triangle.h"

namespace lode::tetra_mt {
namespace {

/// Up to four points of a plane, in order round what they span.
struct Section {
  std::array<Vec3d, 4> points{};
  std::size_t n = 0;

  void add(const Vec3d& p) { points[n++] = p; }
};

double squared_distance(const Section& section, const Vec3d& p) {
  const auto& at = section.points;
  switch (section.n) {
    case 1: {
      const Vec3d way = p - at[0];
      return dot(way, way);
    }
    case 2: return squared_distance_to_segment(p, at[0], at[1] - at[0]);
    case 3: return squared_distance_to_triangle(p, {at[0], at[1], at[2]});
    default:
      return std::min(squared_distance_to_triangle(p, {at[0], at[1], at[2]}),
                      squared_distance_to_triangle(p, {at[0], at[2], at[3]}));
  }
}

double squared_distance_to_tetrahedron(const std::array<Vec3d, 4>& corners, const Vec3d& p) {
  const Vec3d a = corners[1] - corners[0];
  const Vec3d b = corners[2] - corners[0];
  const Vec3d c = corners[3] - corners[0];
  const Vec3d d = p - corners[0];
  const double volume = dot(cross(a, b), c);
  const std::array<double, 3> shares{dot(cross(d, b), c), dot(cross(a, d), c), dot(cross(a, b), d)};
  const double rest = volume - (shares[0] + shares[1] + shares[2]);
  const auto is_inner = [&](double share) { return volume > 0 ? share >= 0 : share <= 0; };
  if (volume != 0 && std::ranges::all_of(shares, is_inner) && is_inner(rest)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k)
    least =
        std::min(least, squared_distance_to_triangle(
                            p, {corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]}));
  return least;
}

/// Corners by whether their value is below, at or above the one that is looked for.
struct Sides {
  std::array<std::array<std::size_t, 4>, 3> corners{};
  std::array<std::size_t, 3> n{};

  void add(std::size_t side, std::size_t corner) { corners[side][n[side]++] = corner; }
};

}  // namespace

double distance_to_value(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                         double value, const Vec3d& p) {
  Sides sides;
  for (std::size_t k = 0; k < 4; ++k)
    sides.add(values[k] < value ? 0 : values[k] > value ? 2 : 1, k);
  const auto [n_below, n_at, n_above] = sides.n;
  if (n_at == 0 && (n_below == 0 || n_above == 0)) return std::numeric_limits<double>::infinity();
  if (n_at == 4) return std::sqrt(squared_distance_to_tetrahedron(corners, p));
  Section section;
  for (std::size_t k = 0; k < n_at; ++k) section.add(corners[sides.corners[1][k]]);
  for (std::size_t i = 0; i < n_below; ++i)
    for (std::size_t k = 0; k < n_above; ++k) {
      const std::size_t below = sides.corners[0][i];
      // There and back, so that four points come in order.
      const std::size_t above = sides.corners[2][i % 2 == 0 ? k : n_above - 1 - k];
      const double share = (value - values[below]) / (values[above] - values[below]);
      section.add(corners[below] + (corners[above] - corners[below]) * share);
    }
  return std::sqrt(squared_distance(section, p));
}

}  // namespace lode::tetra_mt
