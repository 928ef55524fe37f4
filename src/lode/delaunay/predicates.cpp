#include "lode/delaunay/predicates.h"

// CGAL's LGPL kernel: floating point where that is certain, exact numbers elsewhere.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace lode::delaunay {
namespace {

CGAL::Epick::Point_2 to_cgal(const Point& p) { return {p[0], p[1]}; }
CGAL::Epick::Point_3 to_cgal(const Vec3d& p) { return {p[0], p[1], p[2]}; }

}  // namespace

int orientation(const Point& a, const Point& b, const Point& c) {
  return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c)));
}

int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
  return static_cast<int>(CGAL::orientation(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d)));
}

int side_of_circle(const Point& a, const Point& b, const Point& c, const Point& d) {
  return static_cast<int>(
      CGAL::side_of_oriented_circle(to_cgal(a), to_cgal(b), to_cgal(c), to_cgal(d)));
}

}  // namespace lode::delaunay
