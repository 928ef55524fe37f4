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

/// The nearest point of a triangle.
Vec3d nearest_in_triangle(const std::array<Vec3d, 3>& t, const Vec3d& p) {
  const Vec3d u = t[1] - t[0];
  const Vec3d v = t[2] - t[0];
  const Vec3d q = p - t[0];
  const double uu = dot(u, u);
  const double uv = dot(u, v);
  const double vv = dot(v, v);
  const double area = uu * vv - uv * uv;
  const double s = vv * dot(q, u) - uv * dot(q, v);
  const double r = uu * dot(q, v) - uv * dot(q, u);
  if (area > 0 && s >= 0 && r >= 0 && s + r <= area) return t[0] + u * (s / area) + v * (r / area);
  Vec3d best = t[0];
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d e = t[(k + 1) % 3] - t[k];
    const double along = dot(e, e);
    const double share = along > 0 ? std::clamp(dot(p - t[k], e) / along, 0.0, 1.0) : 0;
    const Vec3d at = t[k] + e * share;
    if (const double d = dot(p - at, p - at); d < least) {
      least = d;
      best = at;
    }
  }
  return best;
}

/// The nearest point of a tetrahedron: p itself, where that is inside.
Vec3d nearest_in_tetrahedron(const std::array<Vec3d, 4>& corners, const Vec3d& p) {
  if (squared_distance_to_tetrahedron(corners, p) == 0) return p;
  Vec3d best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3d at =
        nearest_in_triangle({corners[(k + 1) % 4], corners[(k + 2) % 4], corners[(k + 3) % 4]}, p);
    if (const double d = dot(p - at, p - at); d < least) {
      least = d;
      best = at;
    }
  }
  return best;
}

/// Of the linear function; as far as a flat tetrahedron has one.
double value_at(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                const Vec3d& p) {
  const Vec3d a = corners[1] - corners[0];
  const Vec3d b = corners[2] - corners[0];
  const Vec3d c = corners[3] - corners[0];
  const Vec3d d = p - corners[0];
  const double volume = dot(cross(a, b), c);
  if (volume == 0) return values[0];
  return values[0] + (dot(cross(d, b), c) * (values[1] - values[0]) +
                      dot(cross(a, d), c) * (values[2] - values[0]) +
                      dot(cross(a, b), d) * (values[3] - values[0])) /
                         volume;
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

/// The part of the tetrahedron with these values is convex. Where its nearest point has a value
/// between the ends of the range, no other one of the tetrahedron is nearer.
double distance_to_values(const std::array<Vec3d, 4>& corners, const std::array<double, 4>& values,
                          const Range& range, const Vec3d& p) {
  const auto [low, high] = std::ranges::minmax(values);
  if (low > range.high || high < range.low) return std::numeric_limits<double>::infinity();
  const Vec3d nearest = nearest_in_tetrahedron(corners, p);
  const double value = std::clamp(value_at(corners, values, nearest), low, high);
  if (value >= range.low && value <= range.high) return length(p - nearest);
  return std::min(distance_to_value(corners, values, range.low, p),
                  distance_to_value(corners, values, range.high, p));
}

}  // namespace lode::tetra_mt
