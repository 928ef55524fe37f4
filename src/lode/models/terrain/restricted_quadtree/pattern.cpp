#include "lode/models/terrain/restricted_quadtree/pattern.h"

#include <algorithm>
#include <cmath>

#include "lode/models/terrain/squares/tin_builder.h"

namespace lode::restricted_quadtree {
namespace {

/// Of the samples in a triangle, which turns left. All heights are less one of them, as differences
/// of near numbers are exact.
double triangle_error(const SquareDomain& domain, LatticePoint a, LatticePoint b, LatticePoint c) {
  const auto area = static_cast<double>(delaunay::doubled_area(a, b, c));
  const double za = domain.height(a.x, a.y);
  const double zb = domain.height(b.x, b.y) - za;
  const double zc = domain.height(c.x, c.y) - za;
  const double x_step = (zb * (c.y - a.y) - zc * (b.y - a.y)) / area;
  const double y_step = (zc * (b.x - a.x) - zb * (c.x - a.x)) / area;
  const auto [x_low, x_high] = std::minmax({a.x, b.x, c.x});
  const auto [y_low, y_high] = std::minmax({a.y, b.y, c.y});
  double worst = 0;
  for (std::int32_t y = y_low; y <= y_high; ++y) {
    const double* const row = domain.row(y);
    for (std::int32_t x = x_low; x <= x_high; ++x) {
      const LatticePoint p{x, y};
      if (delaunay::doubled_area(a, b, p) < 0 || delaunay::doubled_area(b, c, p) < 0 ||
          delaunay::doubled_area(c, a, p) < 0)
        continue;
      worst = std::max(worst, std::abs((row[x] - za) - (x_step * (x - a.x) + y_step * (y - a.y))));
    }
  }
  return worst;
}

}  // namespace

double pattern_error(const SquareDomain& domain, const Square& square, SideMask midpoints) {
  if (square.level == 1 && midpoints == kAllSides) return 0;  // Its samples are corners.
  double worst = 0;
  visit_pattern(square, midpoints, [&](LatticePoint a, LatticePoint b, LatticePoint centre) {
    worst = std::max(worst, triangle_error(domain, a, b, centre));
  });
  return worst + domain.rounding_in(square, squares::SquarePart::all);
}

delaunay::Tin to_tin(const SquareDomain& domain, const std::vector<Leaf>& leaves) {
  squares::TinBuilder builder(domain);
  for (const Leaf& leaf : leaves) {
    if (leaf.square.level > 0) {
      visit_pattern(leaf.square, leaf.midpoints,
                    [&](LatticePoint a, LatticePoint b, LatticePoint centre) {
                      builder.add(a, b, centre, leaf.error);
                    });
      continue;
    }
    const LatticePoint a{leaf.square.x(), leaf.square.y()};
    builder.add(a, {a.x + 1, a.y}, {a.x + 1, a.y + 1}, 0);
    builder.add(a, {a.x + 1, a.y + 1}, {a.x, a.y + 1}, 0);
  }
  return builder.finish();
}

}  // namespace lode::restricted_quadtree
