#include "lode/models/diamond/cube_meter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "lode/mappers/cube_cases.h"
#include "lode/mappers/tetrahedron_cases.h"

namespace lode::diamond {
namespace {

constexpr double kRounding = 0x1p-40;

double squared_distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d along = b - a;
  const double squared_length = dot(along, along);
  const double t =
      squared_length > 0 ? std::clamp(dot(p - a, along) / squared_length, 0.0, 1.0) : 0;
  const Vec3d rest = p - a - t * along;
  return dot(rest, rest);
}

/// Of CubeMeter's, in their order: by axes, that of the largest coordinate first.
std::size_t tetrahedron_of(const Piece& part) {
  Vec3d sum;
  for (std::size_t i = 0; i < part.size(); ++i) sum = sum + part[i];
  const std::size_t first =
      sum[0] >= sum[1] ? (sum[0] >= sum[2] ? 0 : 2) : (sum[1] >= sum[2] ? 1 : 2);
  const std::size_t low = first == 0 ? 1 : 0;
  const std::size_t high = first == 2 ? 1 : 2;
  return 2 * first + (sum[low] >= sum[high] ? 0 : 1);
}

}  // namespace

void CubeMeter::FlatPolygon::find_normal() {
  normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  if (n == 4) normal = normal + cross(corner[2] - corner[0], corner[3] - corner[0]);
  squared_normal = dot(normal, normal);
}

double CubeMeter::squared_distance(const Vec3d& p, const FlatPolygon& polygon) {
  const auto& c = polygon.corner;
  const auto next = [&](std::size_t i) { return c[i + 1 == polygon.n ? 0 : i + 1]; };
  bool is_above = polygon.squared_normal > 0;
  for (std::size_t i = 0; i < polygon.n && is_above; ++i)
    is_above = dot(cross(polygon.normal, next(i) - c[i]), p - c[i]) >= 0;
  if (is_above) {
    const double height = dot(p - c[0], polygon.normal);
    return height * height / polygon.squared_normal;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.n; ++i)
    nearest = std::min(nearest, squared_distance_to_segment(p, c[i], next(i)));
  return nearest;
}

void CubeMeter::open(const FieldSamples& samples, const Index3& cell) {
  field_ = CellField(samples, cell, isovalue_);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i)
      to_world_.rows[i][axis] = frame_.to_world.rows[i][axis] * field_.step()[axis];
  has_level_set_ = false;
  unsigned corners = 0;
  for (std::size_t k = 0; k < 8; ++k) corners |= (field_.at_corner(k) >= 0 ? 1U : 0U) << k;
  case_ = &cube_cases(0, false)[corners];
  for (std::size_t e = 0; e < case_->n_edges; ++e) {
    const auto [a, b] = edge_corners(case_->edges[e]);
    vertices_[e] = vertex_on(a, b);
  }
}

void CubeMeter::add(const FieldSamples& samples, const Index3& cell) {
  open(samples, cell);
  for (std::size_t t = 0; t < case_->n_triangles; ++t)
    add_triangle(vertices_[case_->triangles[t][0]], vertices_[case_->triangles[t][1]],
                 vertices_[case_->triangles[t][2]]);
}

double CubeMeter::error_of(const FieldSamples& samples, const Index3& cell) {
  open(samples, cell);
  double error = 0;
  for (std::size_t t = 0; t < case_->n_triangles; ++t)
    error = std::max(error,
                     error_of(vertices_[case_->triangles[t][0]], vertices_[case_->triangles[t][1]],
                              vertices_[case_->triangles[t][2]]));
  return error;
}

/// In local coordinates.
Vec3d CubeMeter::vertex_on(std::size_t a, std::size_t b) const {
  const double first = field_.at_corner(a);
  const double t =
      std::clamp(first / (first - field_.at_corner(b)), frame_.margin, 1 - frame_.margin);
  Vec3d p;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto from = static_cast<double>(a >> i & 1);
    p[i] = from + t * (static_cast<double>(b >> i & 1) - from);
  }
  return p;
}

void CubeMeter::add_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double error = error_of(a, b, c);
  deviation_.error = std::max(deviation_.error, error);
  if (error <= kRounding * field_.magnitude()) return;
  // Its corners are on the level set, and no point of it is farther from all of them than this.
  double longest = 0;
  for (const Vec3d& side : {to_world_ * (b - a), to_world_ * (c - b), to_world_ * (a - c)})
    longest = std::max(longest, length(side));
  const double most = longest / std::numbers::sqrt3;
  if (most <= deviation_.distance) return;
  if (!has_level_set_) find_level_set();
  Piece triangle;
  for (const Vec3d& p : {a, b, c}) triangle.add(p);
  visit_kuhn_simplices(triangle, [&](const Piece& part) {
    deviation_.distance = std::max(deviation_.distance, std::min(most, distance_of(part)));
  });
}

/// At its corners, where its edges meet the planes between tetrahedra, and where it meets the
/// body diagonal, in which all of them meet: F is linear on what these planes cut it into.
double CubeMeter::error_of(const Vec3d& a, const Vec3d& b, const Vec3d& c) const {
  double error = 0;
  const auto look_at = [&](const Vec3d& p) {
    error = std::max(error, std::abs(field_.value_at(p)));
  };
  const std::array<Vec3d, 4> corner{a, b, c, a};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d& p = corner[k];
    const Vec3d& q = corner[k + 1];
    look_at(p);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const double at_p = p[i] - p[j];
      const double at_q = q[i] - q[j];
      if ((at_p < 0 && at_q > 0) || (at_p > 0 && at_q < 0))
        look_at(p + (at_p / (at_p - at_q)) * (q - p));
    }
  }
  // Seen along the diagonal, which is a point then: twice the areas of the triangles to it.
  const auto area = [](const Vec3d& p, const Vec3d& q) {
    return (p[0] - p[1]) * (q[1] - q[2]) - (p[1] - p[2]) * (q[0] - q[1]);
  };
  const double at_a = area(b, c);
  const double at_b = area(c, a);
  const double at_c = area(a, b);
  const bool is_met = (at_a > 0 && at_b > 0 && at_c > 0) || (at_a < 0 && at_b < 0 && at_c < 0);
  if (is_met) look_at((at_a * a + at_b * b + at_c * c) * (1 / (at_a + at_b + at_c)));
  return error;
}

/// What the level set is in each tetrahedron, in world coordinates from the even corner. The
/// orders of axes follow each other as they do in dictionaries.
void CubeMeter::find_level_set() {
  has_level_set_ = true;
  std::array<std::size_t, 3> axes{0, 1, 2};
  for (FlatPolygon& polygon : level_set_) {
    std::array<std::size_t, 4> corner{};
    for (std::size_t i = 0; i < 3; ++i) corner[i + 1] = corner[i] | std::size_t{1} << axes[i];
    std::size_t inside = 0;
    for (std::size_t i = 0; i < 4; ++i)
      inside |= (field_.at_corner(corner[i]) >= 0 ? std::size_t{1} : 0U) << i;
    const auto& o = kTetrahedronOrder[inside];
    polygon.n = 0;
    const auto put = [&](std::size_t i, std::size_t j) {
      polygon.corner[polygon.n++] = to_world_ * vertex_on(corner[o[i]], corner[o[j]]);
    };
    const int n_inside = std::popcount(inside);
    if (n_inside == 1 || n_inside == 3)
      for (std::size_t j = 1; j < 4; ++j) put(0, j);
    if (n_inside == 2)
      for (const auto& [i, j] : {std::array<std::size_t, 2>{0, 2}, {0, 3}, {1, 3}, {1, 2}})
        put(i, j);
    if (polygon.n > 0) polygon.find_normal();
    std::next_permutation(axes.begin(), axes.end());
  }
}

/// A bound for the points of a part of a triangle in one tetrahedron, as long as it matters. Most
/// often what that one has of the level set is near enough.
double CubeMeter::distance_of(const Piece& part) const {
  double best = std::numeric_limits<double>::infinity();
  const double enough = deviation_.distance * deviation_.distance;
  const std::size_t own = tetrahedron_of(part);
  for (std::size_t k = 0; k < level_set_.size() && best > enough; ++k) {
    const FlatPolygon& polygon = level_set_[(own + k) % level_set_.size()];
    if (polygon.n == 0) continue;
    double farthest = 0;
    for (std::size_t i = 0; i < part.size() && farthest < best; ++i)
      farthest = std::max(farthest, squared_distance(to_world_ * part[i], polygon));
    best = std::min(best, farthest);
  }
  return std::sqrt(best);
}

}  // namespace lode::diamond
