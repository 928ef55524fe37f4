#include "lode/models/diamond/cap_points.h"

#include <algorithm>
#include <cmath>

namespace lode::diamond {
namespace {

/// Makes equal the distances of coordinate i from the nearest whole numbers where they differ by
/// rounding only: those of vertices at equal parameters of lattice edges.
void align_fractions(double rounding, std::size_t i, std::vector<delaunay::Point>& points) {
  constexpr double kUnit = 0x1p-30;  // whole numbers of units add exactly
  struct Fraction {
    double distance;
    std::size_t point;
  };
  std::vector<Fraction> fractions;
  for (std::size_t n = 0; n < points.size(); ++n)
    fractions.push_back({std::abs(points[n][i] - std::round(points[n][i])), n});
  std::sort(fractions.begin(), fractions.end(), [](const Fraction& a, const Fraction& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.point < b.point;
  });
  double first = -1;
  for (const Fraction& fraction : fractions) {
    if (fraction.distance > first + rounding) first = fraction.distance;
    double& x = points[fraction.point][i];
    double distance = std::round(first / kUnit) * kUnit;
    if (first <= rounding) distance = 0;
    if (first >= 0.5 - rounding) distance = 0.5;  // from either side
    x = std::round(x) + std::copysign(distance, x - std::round(x));
  }
}

/// Coordinates in the lattice, aligned.
std::vector<delaunay::Point> lattice_points(const Vec3d& rounding, std::size_t x, std::size_t y,
                                            std::span<const CapVertex> vertices) {
  std::vector<delaunay::Point> points;
  points.reserve(vertices.size());
  for (const CapVertex& v : vertices) points.push_back({{v.lattice[x], v.lattice[y]}});
  align_fractions(2 * rounding[x], 0, points);
  align_fractions(2 * rounding[y], 1, points);
  return points;
}

/// The written coordinate along a lattice axis that is one of the world's.
double written_along(const Mat3& to_world, std::size_t axis, const Vec3f& world) {
  const Vec3d column = to_world.column(axis);
  for (std::size_t i = 0; i < 3; ++i)
    if (column[i] != 0) return std::copysign(1.0, column[i]) * static_cast<double>(world[i]);
  return 0;
}

}  // namespace

bool is_oblique(const Mat3& to_world) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    int n = 0;
    for (std::size_t i = 0; i < 3; ++i) n += to_world.column(axis)[i] != 0 ? 1 : 0;
    if (n > 1) return true;
  }
  return false;
}

std::vector<delaunay::Point> cap_points(const LatticeFrame& frame, const Vec3d& rounding,
                                        const BorderPlane& plane,
                                        std::span<const CapVertex> vertices) {
  std::size_t x = (plane.axis + 1) % 3;
  std::size_t y = (plane.axis + 2) % 3;
  if (plane.is_upper == frame.is_mirrored) std::swap(x, y);
  if (is_oblique(frame.to_world)) return lattice_points(rounding, x, y, vertices);
  std::vector<delaunay::Point> points;
  points.reserve(vertices.size());
  for (const CapVertex& v : vertices)
    points.push_back(
        {{written_along(frame.to_world, x, v.world), written_along(frame.to_world, y, v.world)}});
  return points;
}

}  // namespace lode::diamond
