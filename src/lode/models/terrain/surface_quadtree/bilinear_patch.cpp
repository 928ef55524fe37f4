#include "lode/models/terrain/surface_quadtree/bilinear_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lode::surface_quadtree {
namespace {

using squares::Square;
using squares::SquareDomain;

/// Lower left, lower right, upper left, upper right.
std::array<double, 4> corner_heights(const SquareDomain& domain, const Square& square) {
  std::array<double, 4> z{};
  for (std::int32_t i = 0; i < 4; ++i)
    z[static_cast<std::size_t>(i)] =
        domain.height(square.x() + i % 2 * square.side(), square.y() + i / 2 * square.side());
  return z;
}

/// Differences of heights are off by half a unit of their range R, products and sums by some more,
/// 7 half units of R in all, and the last sum by one of a height: less than half of what is said.
double rounding_of(const std::array<double, 4>& z) {
  const auto [least, most] = std::ranges::minmax(z);
  return 0x1p-53 * (16 * (most - least) + 2 * std::max(std::abs(least), std::abs(most)));
}

}  // namespace

TinHeight height_in(const SquareDomain& domain, const Square& square, const delaunay::Point& p) {
  const std::array<double, 4> z = corner_heights(domain, square);
  double u = std::clamp((p[0] - square.x()) / square.side(), 0.0, 1.0);
  double v = std::clamp((p[1] - square.y()) / square.side(), 0.0, 1.0);
  // From the nearest corner, so that corners are exact.
  const std::size_t right = u > 0.5 ? 1 : 0;
  const std::size_t upper = v > 0.5 ? 2 : 0;
  if (right != 0) u = 1 - u;
  if (upper != 0) v = 1 - v;
  const std::size_t near = right + upper;
  const double base = z[near];
  const double along = z[near ^ 1U] - base;
  const double across = z[near ^ 2U] - base;
  const double twist = (z[near ^ 3U] - z[near ^ 2U]) - along;
  return {base + (u * along + v * across + u * v * twist), rounding_of(z)};
}

double twist_of(const SquareDomain& domain, const Square& square) {
  const auto [a, b, d, c] = corner_heights(domain, square);
  const double side = square.side();
  return ((c - d) - (b - a)) / (side * side);
}

double error_everywhere(const SquareDomain& domain, const Square& square, double error) {
  // The twist has three differences, which are no larger than twice the range of the corners.
  const auto corners = corner_heights(domain, square);
  const auto [least, most] = std::ranges::minmax(corners);
  const double more = std::abs(twist_of(domain, square)) / 4 + 0x1p-50 * (most - least);
  return more > 0 ? std::nextafter(error + more, HUGE_VAL) : error;
}

}  // namespace lode::surface_quadtree
