// A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information
// Processing Letters 9 (5), 1979.
#include "lode/delaunay/convex_hull.h"

#include <cstddef>

#include "lode/delaunay/lattice.h"

namespace lode::delaunay {

std::vector<std::uint32_t> convex_hull(std::span<const LatticePoint> points) {
  const auto n = static_cast<std::uint32_t>(points.size());
  std::vector<std::uint32_t> hull;
  const auto add = [&](std::uint32_t p, std::size_t n_kept) {
    while (hull.size() > n_kept &&
           doubled_area(points[hull[hull.size() - 2]], points[hull.back()], points[p]) <= 0)
      hull.pop_back();
    hull.push_back(p);
  };
  // The right side going up, then the left side going down.
  for (std::uint32_t p = 0; p < n; ++p) add(p, 1);
  const std::size_t n_right = hull.size();
  for (std::uint32_t p = n; p-- > 0;)
    if (p + 1 < n) add(p, n_right);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

}  // namespace lode::delaunay
