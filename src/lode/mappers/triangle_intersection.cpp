// Exact tests on float coordinates: a floating-point filter with a proven bound settles nearly all
// of them, CGAL's exact predicates (its LGPL kernel) the rest.
#include "lode/mappers/triangle_intersection.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <cmath>

namespace lode {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point3 = Kernel::Point_3;
using Point2 = Kernel::Point_2;

Point3 to_point(const Vec3f& p) {
  return Point3(static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]));
}

Point2 to_flat_point(const Vec3f& p) {
  return Point2(static_cast<double>(p[0]), static_cast<double>(p[1]));
}

Kernel::Triangle_3 to_triangle(const TriangleCorners& t) {
  return Kernel::Triangle_3(to_point(t[0]), to_point(t[1]), to_point(t[2]));
}

Vec3d difference(const Vec3f& a, const Vec3f& b) {
  return {{static_cast<double>(a[0]) - static_cast<double>(b[0]),
           static_cast<double>(a[1]) - static_cast<double>(b[1]),
           static_cast<double>(a[2]) - static_cast<double>(b[2])}};
}

/// A triangle's plane: on which side points lie, where rounding leaves no doubt.
class FilteredPlane {
 public:
  explicit FilteredPlane(const TriangleCorners& t) : base_(t[0]) {
    const Vec3d u = difference(t[1], t[0]);
    const Vec3d v = difference(t[2], t[0]);
    normal_ = cross(u, v);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const std::size_t k = (i + 2) % 3;
      magnitude_[i] = std::abs(u[j] * v[k]) + std::abs(u[k] * v[j]);
    }
  }

  /// 1 or -1 where that is certain, else 0.
  [[nodiscard]] int side_of(const Vec3f& p) const {
    // Each of the six products has three rounded differences, two products and at most four sums
    // on its way: relative error below 10 units of 2^-53 = 1.2e-15. Nothing of float range
    // underflows in double.
    constexpr double kBound = 2e-15;
    const Vec3d d = difference(p, base_);
    const double value = dot(normal_, d);
    const double magnitude = magnitude_[0] * std::abs(d[0]) + magnitude_[1] * std::abs(d[1]) +
                             magnitude_[2] * std::abs(d[2]);
    if (std::abs(value) <= kBound * magnitude) return 0;
    return value > 0 ? 1 : -1;
  }

 private:
  Vec3f base_;
  Vec3d normal_;
  Vec3d magnitude_;
};

/// All corners of t from `first` on strictly on one side of the plane.
bool is_beside(const FilteredPlane& plane, const TriangleCorners& t, std::size_t first) {
  const int side = plane.side_of(t[first]);
  if (side == 0) return false;
  for (std::size_t i = first + 1; i < 3; ++i)
    if (plane.side_of(t[i]) != side) return false;
  return true;
}

bool edge_meets(const TriangleCorners& s, const TriangleCorners& t) {
  return CGAL::do_intersect(Kernel::Segment_3(to_point(s[1]), to_point(s[2])), to_triangle(t));
}

}  // namespace

bool has_zero_area(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3d u = difference(b, a);
  const Vec3d v = difference(c, a);
  for (std::size_t i = 0; i < 3; ++i) {
    const double p = u[i] * v[(i + 1) % 3];
    const double q = u[(i + 1) % 3] * v[i];
    // Two rounded differences, a product and a sum: below 5 units of 2^-53.
    if (std::abs(p - q) > 1e-15 * (std::abs(p) + std::abs(q))) return false;
  }
  return CGAL::collinear(to_point(a), to_point(b), to_point(c));
}

bool triangles_meet(const TriangleCorners& s, const TriangleCorners& t) {
  if (is_beside(FilteredPlane(s), t, 0) || is_beside(FilteredPlane(t), s, 0)) return false;
  return CGAL::do_intersect(to_triangle(s), to_triangle(t));
}

// The common part is convex and holds the corner. A ray from the corner through another common
// point leaves one of the triangles first, through the edge opposite, still inside the other: so
// one of the two opposite edges meets the other triangle.
bool triangles_meet_beyond_corner(const TriangleCorners& s, const TriangleCorners& t) {
  if (is_beside(FilteredPlane(s), t, 1) || is_beside(FilteredPlane(t), s, 1)) return false;
  return edge_meets(s, t) || edge_meets(t, s);
}

bool triangles_meet_beyond_edge(const TriangleCorners& s, const TriangleCorners& t) {
  if (FilteredPlane(s).side_of(t[2]) != 0) return false;
  const Point3 a = to_point(s[0]);
  const Point3 b = to_point(s[1]);
  const Point3 c = to_point(s[2]);
  const Point3 d = to_point(t[2]);
  return CGAL::orientation(a, b, c, d) == CGAL::COPLANAR &&
         CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
}

bool lines_meet(const LineEnds& s, const LineEnds& t) {
  return CGAL::do_intersect(Kernel::Segment_2(to_flat_point(s[0]), to_flat_point(s[1])),
                            Kernel::Segment_2(to_flat_point(t[0]), to_flat_point(t[1])));
}

bool lines_meet_beyond_end(const LineEnds& s, const LineEnds& t) {
  const Point2 a = to_flat_point(s[0]);
  const Point2 b = to_flat_point(s[1]);
  const Point2 c = to_flat_point(t[1]);
  return CGAL::collinear(a, b, c) && !CGAL::collinear_are_strictly_ordered_along_line(b, a, c);
}

}  // namespace lode
