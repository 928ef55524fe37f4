#include "lode/core/height_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lode {

Vec<double, 2> HeightFrame::world(double x, double y) const {
  return {{to_world[0] + to_world[1] * x + to_world[2] * y,
           to_world[3] + to_world[4] * x + to_world[5] * y}};
}

Vec<double, 2> HeightFrame::lattice(double x, double y) const {
  const double determinant = to_world[1] * to_world[5] - to_world[2] * to_world[4];
  const double u = x - to_world[0];
  const double v = y - to_world[3];
  return {{(u * to_world[5] - v * to_world[2]) / determinant,
           (v * to_world[1] - u * to_world[4]) / determinant}};
}

Vec<double, 2> HeightFrame::snapped_lattice(double x, double y) const {
  // Of x and y half a unit of what they are sums of each; of a column or row twice five roundings,
  // of the differences, products and quotient here. 2^-50 is eight half units.
  constexpr double kRounding = 0x1p-50;
  constexpr double kMost = 0x1p-10;
  const auto& g = to_world;
  const double determinant = std::abs(g[1] * g[5] - g[2] * g[4]);
  Vec<double, 2> at = lattice(x, y);
  const auto size = [&](std::size_t i, double place) {
    return std::abs(place) + 2 * std::abs(g[i]) + std::abs(g[i + 1] * at[0]) +
           std::abs(g[i + 2] * at[1]);
  };
  const double in_x = size(0, x);
  const double in_y = size(3, y);
  const std::array<double, 2> slack{
      kRounding * ((in_x * std::abs(g[5]) + in_y * std::abs(g[2])) / determinant),
      kRounding * ((in_y * std::abs(g[1]) + in_x * std::abs(g[4])) / determinant)};
  for (std::size_t i = 0; i < 2; ++i) {
    const double whole = std::round(at[i]);
    if (std::abs(at[i] - whole) <= std::min(slack[i], kMost)) at[i] = whole;
  }
  return at;
}

HeightFrame fine_frame(const HeightFrame& frame, int bits) {
  HeightFrame fine = frame;
  fine.n_columns = ((frame.n_columns - 1) << bits) + 1;
  fine.n_rows = ((frame.n_rows - 1) << bits) + 1;
  for (const std::size_t i : {1U, 2U, 4U, 5U})
    fine.to_world[i] = std::ldexp(frame.to_world[i], -bits);
  return fine;
}

}  // namespace lode
