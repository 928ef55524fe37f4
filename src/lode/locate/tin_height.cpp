#include "lode/locate/tin_height.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/delaunay/lattice_side.h"

namespace lode {

TinHeight height_in(const delaunay::Tin& tin, std::uint32_t triangle, const delaunay::Point& p) {
  using delaunay::Point;
  std::array<Point, 3> at;
  std::array<double, 3> z{};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t vertex = tin.triangles[triangle][i];
    at[i] = delaunay::to_point(tin.vertices[vertex]);
    z[i] = tin.heights[vertex];
  }
  const auto cross_from_p = [&](std::size_t i, std::size_t j) {
    return (at[i][0] - p[0]) * (at[j][1] - p[1]) - (at[i][1] - p[1]) * (at[j][0] - p[0]);
  };
  const std::array<double, 3> weight{cross_from_p(1, 2), cross_from_p(2, 0), cross_from_p(0, 1)};
  const auto base =
      static_cast<std::size_t>(std::max_element(weight.begin(), weight.end()) - weight.begin());
  const std::size_t i = (base + 1) % 3;
  const std::size_t j = (base + 2) % 3;
  const auto& corner = tin.triangles[triangle];
  const auto area = static_cast<double>(delaunay::doubled_area(
      tin.vertices[corner[0]], tin.vertices[corner[1]], tin.vertices[corner[2]]));
  const double way =
      (std::max(weight[i], 0.0) * (z[i] - z[base]) + std::max(weight[j], 0.0) * (z[j] - z[base])) /
      area;
  // A weight is off by 4 half units of two products below the box's w h each, 8 u w h; two of them,
  // differences of heights and five more roundings, of which the area's is one, make less than 24 u
  // w h / A of the range, and the last sum one of the height.
  const auto [left, right] = std::minmax({at[0][0], at[1][0], at[2][0]});
  const auto [low, high] = std::minmax({at[0][1], at[1][1], at[2][1]});
  const auto [least, most] = std::minmax({z[0], z[1], z[2]});
  const double stretch = (right - left) * (high - low) / area;
  return {z[base] + way, 0x1p-53 * (24 * stretch * (most - least) +
                                    2 * std::max(std::abs(least), std::abs(most)))};
}

}  // namespace lode
