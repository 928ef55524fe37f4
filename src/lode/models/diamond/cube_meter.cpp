#include "lode/models/diamond/cube_meter.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "lode/core/point_triangle.h"
#include "lode/mappers/cube_cases.h"
#include "lode/mappers/tetrahedron_cases.h"

namespace lode::diamond {
namespace {

/// Of each tetrahedron: the axes along which its corners follow each other from the even corner.
constexpr std::array<std::array<std::size_t, 3>, 6> kAxes{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

constexpr std::uint8_t kNoEdge = 0xFF;

/// Numbers of the 19 edges of the tetrahedra, by their corners in any order.
constexpr auto kEdgeOf = [] {
  std::array<std::array<std::uint8_t, 8>, 8> edges{};
  std::uint8_t n = 0;
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = a; b < 8; ++b)
      edges[a][b] = edges[b][a] = a != b && (a & b) == a ? n++ : kNoEdge;
  return edges;
}();

/// How far a point of a triangle is at most from the nearest of its corners: that of the centre of
/// its circumcircle, or, if that is outside, of the two points of the longest side that are as far
/// from one of its ends as from the third corner.
double farthest_from_corners(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  std::array<double, 3> squares{dot(c - b, c - b), dot(a - c, a - c), dot(b - a, b - a)};
  std::ranges::sort(squares);
  const double longest = squares[2];
  const double x = squares[0] / longest;
  const double y = squares[1] / longest;
  // Of the longest side. For needles too: of large numbers only 1 - y is small, at most x.
  const double share = x + y <= 1 ? std::max(x / (x + 1 - y), y / (y + 1 - x))
                                  : std::sqrt(y / (2 * (y + 1) - x - (1 - y) * (1 - y) / x));
  constexpr double kMost = 1 / std::numbers::sqrt3;  // of one with three equal sides
  return std::sqrt(longest) * (share <= kMost ? share : kMost);
}

/// By kAxes: that of the largest coordinate comes first.
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
  for (std::size_t i = 0; i < n; ++i)
    inward[i] = cross(normal, corner[i + 1 == n ? 0 : i + 1] - corner[i]);
}

double CubeMeter::squared_distance(const Vec3d& p, const FlatPolygon& polygon) {
  const auto& c = polygon.corner;
  const auto next = [&](std::size_t i) { return c[i + 1 == polygon.n ? 0 : i + 1]; };
  bool is_above = polygon.squared_normal > 0;
  for (std::size_t i = 0; i < polygon.n && is_above; ++i)
    is_above = dot(polygon.inward[i], p - c[i]) >= 0;
  if (is_above) {
    const double height = dot(p - c[0], polygon.normal);
    return height * height / polygon.squared_normal;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.n; ++i)
    nearest = std::min(nearest, squared_distance_to_segment(p, c[i], next(i) - c[i]));
  return nearest;
}

void CubeMeter::open(const FieldSamples& samples, const Index3& cell) {
  field_ = CellField(samples, cell, isovalue_);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t i = 0; i < 3; ++i)
      to_world_.rows[i][axis] = frame_.to_world.rows[i][axis] * field_.step()[axis];
  for (std::size_t axis = 0; axis < 3; ++axis)
    diagonals_[axis] = length(to_world_.column((axis + 1) % 3) + to_world_.column((axis + 2) % 3));
  has_level_set_ = false;
  farthest_vertex_ = -1;
  corners_ = 0;
  for (std::size_t k = 0; k < 8; ++k) corners_ |= (field_.at_corner(k) >= 0 ? 1U : 0U) << k;
  case_ = &cube_cases(0, false)[corners_];
}

void CubeMeter::place_vertices() {
  for (std::size_t e = 0; e < case_->n_edges; ++e) vertices_[e] = vertex(e);
}

Vec3d CubeMeter::vertex(std::size_t e) const {
  const auto [a, b] = edge_corners(case_->edges[e]);
  return vertex_on(a, b);
}

void CubeMeter::add(const FieldSamples& samples, const Index3& cell) {
  open(samples, cell);
  if (!may_add()) return;
  place_vertices();
  for (std::size_t t = 0; t < case_->n_triangles; ++t)
    add_triangle(vertices_[case_->triangles[t][0]], vertices_[case_->triangles[t][1]],
                 vertices_[case_->triangles[t][2]]);
}

bool CubeMeter::exceeds(const FieldSamples& samples, const Index3& cell, const CubeLimit& limit) {
  open(samples, cell);
  return errs(limit.error) || (!std::isinf(limit.distance) && strays(limit.distance));
}

/// Whether the open cell may raise what was found, by bounds for all of it.
bool CubeMeter::may_add() {
  if (error_bound() > deviation_.error) return true;
  farthest_vertex_ = farthest_vertex() * (1 + kRounding);
  return farthest_vertex_ > deviation_.distance;
}

/// Of |F - isovalue| on all of the cube's triangles. F is linear but for folds at the planes
/// between tetrahedra, where two coordinates are equal: on the side where the first is larger it
/// gains their difference times how much the sums of a face's diagonals differ. That part of F is 0
/// or more at the corners, which have the isovalue, and at other points off the corners' mean by at
/// most what corners on either side weigh, so by half of a fold, as coordinates differ by no more
/// than 1. Where a fold changes along its plane, by half of the larger one: go from a corner to a
/// point of the side opposite, which adds up to the same.
double CubeMeter::error_bound() const {
  double folds = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t first = std::size_t{1} << (axis + 1) % 3;
    const std::size_t second = std::size_t{1} << (axis + 2) % 3;
    double fold = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t even = side << axis;
      fold = std::max(fold,
                      std::abs(field_.at_corner(even) + field_.at_corner(even | first | second) -
                               field_.at_corner(even | first) - field_.at_corner(even | second)));
    }
    folds += fold;
  }
  // Vertices stay away from corners by a margin.
  return 0.5 * folds + (2 * frame_.margin + kRounding) * field_.magnitude();
}

bool CubeMeter::errs(double limit) {
  if (std::min(field_.magnitude() * (1 + kRounding), error_bound()) <= limit) return false;
  place_vertices();
  for (std::size_t t = 0; t < case_->n_triangles; ++t)
    if (error_of(vertices_[case_->triangles[t][0]], vertices_[case_->triangles[t][1]],
                 vertices_[case_->triangles[t][2]]) > limit)
      return true;
  return false;
}

/// In local coordinates.
Vec3d CubeMeter::vertex_on(std::size_t a, std::size_t b) const {
  const double t = share_of(a, b);
  Vec3d p;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto from = static_cast<double>(a >> i & 1);
    p[i] = from + t * (static_cast<double>(b >> i & 1) - from);
  }
  return p;
}

/// What can be no more than was found is not looked at: first what is known of the cell's corners,
/// then of the triangle's, which are on the level set.
void CubeMeter::add_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const double most =
      farthest_from_corners(to_world_ * a, to_world_ * b, to_world_ * c) * (1 + kRounding);
  const bool may_be_largest = field_.magnitude() * (1 + kRounding) > deviation_.error;
  if (!may_be_largest && most <= deviation_.distance) return;
  const double error = error_of(a, b, c);
  deviation_.error = std::max(deviation_.error, error);
  if (error <= kRounding * field_.magnitude() || most <= deviation_.distance) return;
  if (farthest_vertex_ < 0) farthest_vertex_ = farthest_vertex() * (1 + kRounding);
  if (farthest_vertex_ <= deviation_.distance) return;
  Piece triangle;
  for (const Vec3d& p : {a, b, c}) triangle.add(p);
  // The least of all bounds, so that what is skipped changes nothing.
  visit_kuhn_simplices(triangle, [&](const Piece& part) {
    const double bound = std::min({most, farthest_vertex_, distance_to_values(part)});
    if (bound <= deviation_.distance) return;
    deviation_.distance =
        std::max(deviation_.distance, std::min(bound, distance_of(part, deviation_.distance)));
  });
}

/// A bound for the points of a part of a triangle in one tetrahedron that is cheap: on the way from
/// a point to a corner with the other sign F, which is linear, reaches the isovalue. Infinite where
/// all corners have one sign.
double CubeMeter::distance_to_values(const Piece& part) const {
  const auto& axes = kAxes[tetrahedron_of(part)];
  std::size_t highest = 0;
  std::size_t lowest = 0;
  std::size_t corner = 0;
  for (const std::size_t axis : axes) {
    corner |= std::size_t{1} << axis;
    if (field_.at_corner(corner) > field_.at_corner(highest)) highest = corner;
    if (field_.at_corner(corner) < field_.at_corner(lowest)) lowest = corner;
  }
  if (field_.at_corner(lowest) >= 0 || field_.at_corner(highest) < 0)
    return std::numeric_limits<double>::infinity();
  double farthest = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const double value = field_.value_at(part[i]);
    const std::size_t other = value >= 0 ? lowest : highest;
    const double way = std::abs(value) + std::abs(field_.at_corner(other));
    if (!(way > 0)) continue;
    Vec3d to_other;
    for (std::size_t axis = 0; axis < 3; ++axis)
      to_other[axis] = static_cast<double>(other >> axis & 1) - part[i][axis];
    farthest = std::max(farthest, std::abs(value) / way * length(to_world_ * to_other));
  }
  return farthest * (1 + kRounding);
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

/// What the level set is in each tetrahedron, in world coordinates from the even corner.
void CubeMeter::find_level_set() {
  if (has_level_set_) return;
  has_level_set_ = true;
  crossed_ = 0;
  for (std::size_t a = 0; a < 8; ++a)
    for (std::size_t b = a + 1; b < 8; ++b) {
      const std::uint8_t edge = kEdgeOf[a][b];
      if (edge == kNoEdge || (field_.at_corner(a) >= 0) == (field_.at_corner(b) >= 0)) continue;
      crossed_ |= 1U << edge;
      crossings_[edge] = to_world_ * vertex_on(a, b);
    }
  for (std::size_t t = 0; t < level_set_.size(); ++t) {
    FlatPolygon& polygon = level_set_[t];
    std::array<std::size_t, 4> corner{};
    for (std::size_t i = 0; i < 3; ++i) corner[i + 1] = corner[i] | std::size_t{1} << kAxes[t][i];
    std::size_t inside = 0;
    for (std::size_t i = 0; i < 4; ++i)
      inside |= (field_.at_corner(corner[i]) >= 0 ? std::size_t{1} : 0U) << i;
    const auto& o = kTetrahedronOrder[inside];
    polygon.n = 0;
    const auto put = [&](std::size_t i, std::size_t j) {
      const std::uint8_t edge = kEdgeOf[corner[o[i]]][corner[o[j]]];
      polygon.edge[polygon.n] = edge;
      polygon.corner[polygon.n++] = crossings_[edge];
    };
    const int n_inside = std::popcount(inside);
    if (n_inside == 1 || n_inside == 3)
      for (std::size_t j = 1; j < 4; ++j) put(0, j);
    if (n_inside == 2)
      for (const auto& [i, j] : {std::array<std::size_t, 2>{0, 2}, {0, 3}, {1, 3}, {1, 2}})
        put(i, j);
    if (polygon.n > 0) polygon.find_normal();
  }
}

/// A bound for the points of a part of a triangle in one tetrahedron, as long as it matters. Most
/// often what that one has of the level set is near enough.
double CubeMeter::distance_of(const Piece& part, double enough) {
  find_level_set();
  double best = std::numeric_limits<double>::infinity();
  const double enough2 = enough * enough;
  const std::size_t own = tetrahedron_of(part);
  for (std::size_t k = 0; k < level_set_.size() && best > enough2; ++k) {
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
