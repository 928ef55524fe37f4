#include "lode/models/terrain/right_triangle_bisection/locate.h"

#include <algorithm>

#include "lode/models/terrain/right_triangle_bisection/walk.h"

namespace lode::bisection {
namespace {

using delaunay::LatticeCorners;

struct Point {
  double x = 0;
  double y = 0;
};

/// Twice the area of a, b, p, but for rounding.
double doubled_area(LatticePoint a, LatticePoint b, Point p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

bool holds(const LatticeCorners& t, Point p) {
  return doubled_area(t[0], t[1], p) >= 0 && doubled_area(t[1], t[2], p) >= 0 &&
         doubled_area(t[2], t[0], p) >= 0;
}

/// From triangles of the lattice to those of a mesh.
class Descent {
 public:
  Descent(const Bisection& bisection, double tolerance)
      : bisection_(bisection), lattice_(bisection.lattice()), tolerance_(tolerance) {}

  [[nodiscard]] LatticeCorners placed(const LatticeTriangle& t) const {
    return {lattice_.place(t.a), lattice_.place(t.b), lattice_.place(t.c)};
  }
  [[nodiscard]] static bool has_area(const LatticeCorners& t) {
    return delaunay::doubled_area(t[0], t[1], t[2]) > 0;
  }
  [[nodiscard]] bool is_refined(const LatticeTriangle& t, int depth) const {
    return depth > 0 && static_cast<double>(bisection_.error(t.middle())) > tolerance_;
  }
  /// Whether it is as large as in the lattice, so that its halves are halves of it.
  [[nodiscard]] bool is_whole(const LatticeTriangle& t) const {
    const LatticePoint last = lattice_.last();
    return std::max({t.a.x, t.b.x, t.c.x}) <= last.x && std::max({t.a.y, t.b.y, t.c.y}) <= last.y;
  }
  [[nodiscard]] MeshTriangle leaf(const LatticeTriangle& t, int depth) const {
    return {placed(t), depth > 0 ? bisection_.error(t.middle()) : 0.0F};
  }
  [[nodiscard]] int depth() const { return 2 * (lattice_.n_levels() - 1); }

  /// Down the halves that hold p in the lattice.
  [[nodiscard]] std::optional<MeshTriangle> straight(Point p) const {
    LatticeTriangle t = roots(lattice_)[p.y > p.x ? 1 : 0];
    int left = depth();
    for (; is_refined(t, left); --left) {
      const LatticePoint middle = t.middle();
      t = doubled_area(t.c, middle, p) <= 0 ? t.left() : t.right();
    }
    const MeshTriangle found = leaf(t, left);
    if (!is_whole(t) && !(has_area(found.corners) && holds(found.corners, p))) return {};
    return found;
  }
  /// Among all that may hold p where the lattice is stretched.
  [[nodiscard]] std::optional<MeshTriangle> searched(const LatticeTriangle& t, int left,
                                                     Point p) const {
    const LatticeCorners own = placed(t);
    const auto [x0, x1] = std::minmax({own[0].x, own[1].x, own[2].x});
    const auto [y0, y1] = std::minmax({own[0].y, own[1].y, own[2].y});
    if (!(p.x >= x0 && p.x <= x1 && p.y >= y0 && p.y <= y1) || !has_area(own)) return {};
    if (!is_refined(t, left)) {
      if (holds(own, p) && bisection_.has_triangle(own)) return leaf(t, left);
      return {};
    }
    if (const auto found = searched(t.left(), left - 1, p)) return found;
    return searched(t.right(), left - 1, p);
  }

  [[nodiscard]] std::uint64_t count(const LatticeTriangle& t, int left,
                                    const delaunay::Window& window) const {
    const LatticeCorners own = placed(t);
    if (!has_area(own)) return 0;
    if (!is_refined(t, left))
      return meets_window(own, window) && bisection_.has_triangle(own) ? 1 : 0;
    if (is_whole(t) ? !meets_window(own, window) : is_beside(own, window)) return 0;
    return count(t.left(), left - 1, window) + count(t.right(), left - 1, window);
  }

 private:
  static bool is_beside(const LatticeCorners& t, const delaunay::Window& window) {
    const auto [x0, x1] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [y0, y1] = std::minmax({t[0].y, t[1].y, t[2].y});
    return x1 < window.lower.x || x0 > window.upper.x || y1 < window.lower.y || y0 > window.upper.y;
  }

  const Bisection& bisection_;
  const Lattice& lattice_;
  double tolerance_;
};

}  // namespace

std::optional<MeshTriangle> find_triangle(const Bisection& bisection, double tolerance, double x,
                                          double y) {
  const LatticePoint last = bisection.lattice().last();
  if (!(x >= 0 && y >= 0 && x <= last.x && y <= last.y)) return {};
  const Descent descent(bisection, tolerance);
  std::optional<MeshTriangle> found = descent.straight({x, y});
  if (found && bisection.has_triangle(found->corners)) return found;
  // Beyond the straight way there are stretched triangles, and neighbours along the outline.
  found.reset();
  for (const LatticeTriangle& root : roots(bisection.lattice()))
    if (!found) found = descent.searched(root, descent.depth(), {x, y});
  return found;
}

double height_in(const MeshTriangle& triangle, const HeightGrid& grid, double x, double y) {
  const auto& [a, b, c] = triangle.corners;
  const double in_a = doubled_area(b, c, {x, y});
  const double in_b = doubled_area(c, a, {x, y});
  const double in_c = doubled_area(a, b, {x, y});
  return (in_a * grid.height(a.x, a.y) + in_b * grid.height(b.x, b.y) +
          in_c * grid.height(c.x, c.y)) /
         (in_a + in_b + in_c);
}

std::uint64_t count_in_window(const Bisection& bisection, double tolerance,
                              const delaunay::Window& window) {
  const Descent descent(bisection, tolerance);
  std::uint64_t n = 0;
  for (const LatticeTriangle& root : roots(bisection.lattice()))
    n += descent.count(root, descent.depth(), window);
  return n;
}

}  // namespace lode::bisection
