// Whether a cell's cube and its tetrahedra are near each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "lode/core/point_triangle.h"
#include "lode/mappers/cube_cases.h"
#include "lode/mappers/cube_following.h"
#include "lode/models/diamond/cube_meter.h"

namespace lode::diamond {
bool CubeMeter::FlatPolygon::is_near(const Vec3d& p, double limit2) const {
  const double height = dot(p - corner[0], normal);
  if (height * height > limit2 * squared_normal) return false;
  const bool has_plane = squared_normal > 0;
  unsigned beyond = 0;  // edges, and one of these is nearest
  for (std::size_t i = 0; i < n; ++i) {
    const double inside = dot(inward[i], p - corner[i]);
    if (inside >= 0) continue;
    if (inside * inside > limit2 * dot(inward[i], inward[i])) return false;
    beyond |= 1U << i;
  }
  if (beyond == 0 && has_plane) return true;
  for (std::size_t i = 0; i < n; ++i)
    if ((!has_plane || (beyond >> i & 1) != 0) &&
        squared_distance_to_segment(p, corner[i], corner[i + 1 == n ? 0 : i + 1] - corner[i]) <=
            limit2)
      return true;
  return false;
}

/// All that follows is about vertices where F has the isovalue. Those that stay a margin away from
/// corners may be that much of an edge beside it, of either surface, and polygons of such vertices
/// are not flat by as much.
bool CubeMeter::strays(double limit) {
  limit -= 2 * frame_.margin * length(to_world_ * Vec3d{{1, 1, 1}});
  limit *= 1 - kRounding;
  if (!(limit > 0)) return true;
  const double move = farthest_move();
  if (move > limit) return true;
  if (std::max(move, farthest_inside()) <= limit) return false;
  find_level_set();
  place_vertices();
  for (std::size_t t = 0; t < case_->n_triangles; ++t) {
    cube_[t].n = 3;
    for (std::size_t k = 0; k < 3; ++k)
      cube_[t].corner[k] = to_world_ * vertices_[case_->triangles[t][k]];
    cube_[t].find_normal();
  }
  return !is_level_set_near(limit) || !is_cube_near(limit);
}

double CubeMeter::farthest_vertex() const {
  const double inside = farthest_inside();
  return std::isinf(inside) ? inside : std::max(farthest_move(), inside);
}

/// How far at most points inside the cell go if those on its faces' diagonals move as they do there
/// and the level set's triangles follow; infinite where that may not end on the cube's triangles.
double CubeMeter::farthest_inside() const {
  const CubeFollowing& following = cube_following(corners_);
  if (following.body == CubeFollowing::Body::unknown)
    return std::numeric_limits<double>::infinity();
  if (following.body == CubeFollowing::Body::none) return 0;
  std::array<Vec3d, 3> p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = to_world_ * vertex(following.vertices[i]);
  const Vec3d body = to_world_ * vertex_on(0, 7);
  return std::sqrt(following.body == CubeFollowing::Body::on_edge
                       ? squared_distance_to_segment(body, p[0], p[1] - p[0])
                       : squared_distance_to_triangle(body, p));
}

/// All points of the triangles to the level set.
bool CubeMeter::is_cube_near(double limit) {
  bool is_far = false;
  for (std::size_t t = 0; t < case_->n_triangles && !is_far; ++t) {
    Piece triangle;
    for (const std::size_t k : case_->triangles[t]) triangle.add(vertices_[k]);
    visit_kuhn_simplices(triangle, [&](const Piece& part) {
      is_far = is_far || (distance_to_values(part) > limit && distance_of(part, limit) > limit);
    });
  }
  return !is_far;
}

/// All points of the level set to the triangles.
bool CubeMeter::is_level_set_near(double limit) const {
  const double limit2 = limit * limit;
  std::array<unsigned, kLatticeEdges> near{};  // bits: triangles
  for (std::size_t e = 0; e < kLatticeEdges; ++e) {
    if ((crossed_ >> e & 1) == 0) continue;
    near[e] = triangles_near(crossings_[e], limit2);
    if (near[e] == 0) return false;
  }
  for (const FlatPolygon& polygon : level_set_) {
    if (polygon.n == 0) continue;
    unsigned near_all = ~0U;
    for (std::size_t i = 0; i < polygon.n; ++i) near_all &= near[polygon.edge[i]];
    constexpr int kCuts = 2;
    if (near_all == 0 && !are_parts_near(std::span(polygon.corner).first(polygon.n), limit2, kCuts))
      return false;
  }
  return true;
}

/// Bits: the cube's triangles that are near a point.
unsigned CubeMeter::triangles_near(const Vec3d& p, double limit2) const {
  unsigned near = 0;
  for (std::size_t t = 0; t < case_->n_triangles; ++t)
    if (cube_[t].is_near(p, limit2)) near |= 1U << t;
  return near;
}

/// Whether parts of a convex polygon are each near one triangle of the cube, as far as it is cut.
bool CubeMeter::are_parts_near(std::span<const Vec3d> polygon, double limit2, int depth) const {
  const auto is_near = [&](const std::array<Vec3d, 3>& part) {
    unsigned near_all = ~0U;
    for (const Vec3d& p : part) near_all &= triangles_near(p, limit2);
    return near_all != 0;
  };
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k) {
    const std::array<Vec3d, 3> p{polygon[0], polygon[k], polygon[k + 1]};
    const Vec3d a = 0.5 * (p[1] + p[2]);
    const Vec3d b = 0.5 * (p[2] + p[0]);
    const Vec3d c = 0.5 * (p[0] + p[1]);
    for (const auto& part : {std::array{p[0], c, b}, {c, p[1], a}, {b, a, p[2]}, {a, b, c}})
      if (!is_near(part) && (depth == 1 || !are_parts_near(part, limit2, depth - 1))) return false;
  }
  return true;
}

/// How far at most a vertex on a face's diagonal goes, onto the segment between the face's two
/// crossed edges.
double CubeMeter::farthest_move() const {
  double farthest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t even = side << axis;
      const std::size_t first = even | std::size_t{1} << (axis + 1) % 3;
      const std::size_t second = even | std::size_t{1} << (axis + 2) % 3;
      const std::size_t odd = first | second;
      if (!is_crossed(even, odd)) continue;
      // The face's crossed edges are one on either side of the diagonal; coordinates are along the
      // first and the second axis, and what they differ by tells how far beside it.
      const std::array<double, 2> p = is_crossed(even, first)
                                          ? std::array{share_of(even, first), 0.0}
                                          : std::array{1.0, share_of(first, odd)};
      const std::array<double, 2> q = is_crossed(even, second)
                                          ? std::array{0.0, share_of(even, second)}
                                          : std::array{share_of(second, odd), 1.0};
      const double from = p[0] - p[1];
      const double to = q[0] - q[1];
      const double moved = p[0] + from / (from - to) * (q[0] - p[0]);
      farthest = std::max(farthest, std::abs(moved - share_of(even, odd)) * diagonals_[axis]);
    }
  return farthest;
}

}  // namespace lode::diamond
