#pragma once

#include <algorithm>
#include <cstdint>

#include "lode/core/lattice_point.h"
#include "lode/delaunay/lattice.h"

namespace lode::test {

/// visit(p, wa, wb, wc) of all nodes in a closed triangle that turns left, with weights of the
/// corners that add up to its doubled area: by trying all of its box.
template <typename Visit>
void for_each_node_in(LatticePoint a, LatticePoint b, LatticePoint c, const Visit& visit) {
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [low, high] = std::minmax({a.y, b.y, c.y});
  for (LatticePoint p{left, low}; p.y <= high; ++p.y)
    for (p.x = left; p.x <= right; ++p.x) {
      const std::int64_t wa = delaunay::doubled_area(b, c, p);
      const std::int64_t wb = delaunay::doubled_area(c, a, p);
      const std::int64_t wc = delaunay::doubled_area(a, b, p);
      if (wa >= 0 && wb >= 0 && wc >= 0) visit(p, wa, wb, wc);
    }
}

}  // namespace lode::test
