#include "lode/io/polyhedron_centre.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "lode/io/inner_point.h"
#include "lode/io/polyhedron_faces.h"
#include "lode/io/tetra_orientation.h"

namespace lode::io {
namespace {

using FaceTriangles = std::span<const std::array<std::uint32_t, 3>>;

constexpr double kSliver = 1e-6;  // of what float32 leaves of three points in a line

/// A triangle's height over its longest side, divided by that.
double height_ratio(const CellMesh& mesh, const std::array<std::uint32_t, 3>& t) {
  const Vec3d& a = mesh.points[t[0]];
  const Vec3d& b = mesh.points[t[1]];
  const Vec3d& c = mesh.points[t[2]];
  const double longest = std::max({dot(b - a, b - a), dot(c - b, c - b), dot(a - c, a - c)});
  return longest > 0 ? length(cross(b - a, c - a)) / longest : 0;
}

/// The sign of the volume that a point makes with a triangle: 1 if it is inside.
int side_of(const CellMesh& mesh, const Vec3d& p, const std::array<std::uint32_t, 3>& t) {
  return orientation(p, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]);
}

std::vector<std::array<std::uint32_t, 3>> higher_than(const CellMesh& mesh, FaceTriangles triangles,
                                                      double ratio) {
  std::vector<std::array<std::uint32_t, 3>> higher;
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(higher),
               [&](const auto& t) { return height_ratio(mesh, t) > ratio; });
  return higher;
}

bool sees(const CellMesh& mesh, const Vec3d& p, FaceTriangles triangles) {
  return !triangles.empty() && std::all_of(triangles.begin(), triangles.end(),
                                           [&](const auto& t) { return side_of(mesh, p, t) > 0; });
}

/// Their innermost point, found round the mean in units of the largest distance from it.
Vec3d innermost(const CellMesh& mesh, const Vec3d& mean, FaceTriangles triangles) {
  double size = 0;
  for (const auto& t : triangles)
    for (const std::uint32_t corner : t) size = std::max(size, length(mesh.points[corner] - mean));
  if (!(size > 0)) return mean;
  const auto local = [&](std::uint32_t point) { return (mesh.points[point] - mean) * (1 / size); };
  std::vector<HalfSpace> inside;
  for (const auto& [a, b, c] : triangles) {
    const Vec3d normal = normalized(cross(local(b) - local(a), local(c) - local(a)));
    inside.push_back({.normal = normal, .offset = dot(normal, local(a))});
  }
  return mean + innermost_point(inside) * size;
}

/// Solves m x = b for a symmetric m; zero where it has no inverse.
Vec3d solved(const Mat3& m, const Vec3d& b) {
  const double d = determinant(m);
  if (!(std::abs(d) > 0)) return {};
  return (cofactors(m) * b) * (1 / d);
}

}  // namespace

std::optional<Vec3d> find_centre(const CellMesh& mesh, const Vec3d& middle, FaceTriangles faces) {
  for (const double ratio : {0.0, kSliver}) {
    const auto triangles = higher_than(mesh, faces, ratio);
    if (sees(mesh, middle, triangles)) return middle;
    const Vec3d inner = innermost(mesh, middle, triangles);
    if (sees(mesh, inner, triangles)) return inner;
  }
  if (std::any_of(faces.begin(), faces.end(),
                  [&](const auto& t) { return side_of(mesh, middle, t) < 0; }))
    return std::nullopt;
  return middle;
}

double value_at_centre(const CellMesh& mesh, std::span<const std::uint32_t> corners,
                       const Vec3d& centre, const std::vector<double>& values) {
  const Vec3d middle = mean_position(mesh, corners);
  double sum = 0;
  for (const std::uint32_t corner : corners) sum += values[corner];
  const double mean = sum / static_cast<double>(corners.size());
  if (centre == middle || !std::isfinite(mean)) return mean;
  Mat3 spread;
  Vec3d slope;
  double low = mean;
  double high = mean;
  for (const std::uint32_t corner : corners) {
    const Vec3d arm = mesh.points[corner] - middle;
    for (std::size_t i = 0; i < 3; ++i) spread.rows[i] = spread.rows[i] + arm * arm[i];
    slope = slope + arm * (values[corner] - mean);
    low = std::min(low, values[corner]);
    high = std::max(high, values[corner]);
  }
  return std::clamp(mean + dot(solved(spread, slope), centre - middle), low, high);
}

}  // namespace lode::io
