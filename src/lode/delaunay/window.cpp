#include "lode/delaunay/window.h"

#include <algorithm>

namespace lode::delaunay {

bool meets_window(const LatticeCorners& triangle, const Window& window) {
  const auto [x0, x1] = std::minmax({triangle[0].x, triangle[1].x, triangle[2].x});
  const auto [y0, y1] = std::minmax({triangle[0].y, triangle[1].y, triangle[2].y});
  if (x1 < window.lower.x || x0 > window.upper.x || y1 < window.lower.y || y0 > window.upper.y)
    return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = triangle[i];
    const LatticePoint b = triangle[(i + 1) % 3];
    // The corner of the window farthest to the left of the edge.
    const LatticePoint p{b.y > a.y ? window.lower.x : window.upper.x,
                         b.x > a.x ? window.upper.y : window.lower.y};
    if (doubled_area(a, b, p) < 0) return false;
  }
  return true;
}

}  // namespace lode::delaunay
