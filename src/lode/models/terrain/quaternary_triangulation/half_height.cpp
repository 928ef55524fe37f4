#include "lode/models/terrain/quaternary_triangulation/half_height.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace lode::quaternary_triangulation {

TinHeight height_in(const SquareDomain& domain, const HalfSquare& triangle,
                    const delaunay::Point& p) {
  const Square& square = triangle.square;
  const std::int32_t side = square.side();
  const auto corner = [&](std::int32_t u, std::int32_t v) {
    return domain.height(square.x() + u, square.y() + v);
  };
  const std::array<double, 3> z{corner(0, 0), triangle.is_upper ? corner(0, side) : corner(side, 0),
                                corner(side, side)};
  const double u = std::clamp((p[0] - square.x()) / side, 0.0, 1.0);
  const double v = std::clamp((p[1] - square.y()) / side, 0.0, 1.0);
  // The larger one: in the lower half that along columns.
  const double far = triangle.is_upper ? v : u;
  const double near = std::min(triangle.is_upper ? u : v, far);
  const std::array<double, 3> weight{1 - far, far - near, near};
  // From the heaviest corner, so that corners are exact.
  const auto base = static_cast<std::size_t>(std::ranges::max_element(weight) - weight.begin());
  double way = 0;
  for (const std::size_t i : {(base + 1) % 3, (base + 2) % 3}) way += weight[i] * (z[i] - z[base]);
  const auto [least, most] = std::ranges::minmax(z);
  // Weights are off by half a unit, products with differences by three of the range R, their sum by
  // two more, 8 in all, and the last sum by one of a height: half of what is said.
  return {z[base] + way,
          0x1p-53 * (16 * (most - least) + 2 * std::max(std::abs(least), std::abs(most)))};
}

}  // namespace lode::quaternary_triangulation
