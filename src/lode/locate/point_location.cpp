#include "lode/locate/point_location.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "lode/delaunay/predicates.h"

namespace lode {
namespace {

constexpr double kUnit = 0x1p-52;

/// What weights change by, at most, along a way of length 1: the faces' areas by the volume.
std::array<double, 4> slopes_of(const std::array<Vec3d, 4>& c) {
  const auto area = [&](std::size_t i, std::size_t j, std::size_t k) {
    return length(cross(c[j] - c[i], c[k] - c[i]));
  };
  const double whole = std::abs(dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]));
  return {area(1, 2, 3) / whole, area(0, 2, 3) / whole, area(0, 1, 3) / whole,
          area(0, 1, 2) / whole};
}

}  // namespace

bool holds(const CellLocator& locator, std::uint32_t cell, const Vec3d& p) {
  const std::array<Vec3d, 4> c = locator.corners_of(cell);
  const int side = delaunay::orientation(c[0], c[1], c[2], c[3]);
  return side != 0 && delaunay::orientation(p, c[1], c[2], c[3]) != -side &&
         delaunay::orientation(c[0], p, c[2], c[3]) != -side &&
         delaunay::orientation(c[0], c[1], p, c[3]) != -side &&
         delaunay::orientation(c[0], c[1], c[2], p) != -side;
}

std::optional<std::uint32_t> find_cell(const CellLocator& locator, const Vec3d& p,
                                       std::span<const std::uint8_t> preferred) {
  using Rank = std::tuple<bool, double>;
  std::optional<std::uint32_t> best;
  Rank best_rank;
  locator.visit_near(p, 0, [&](std::uint32_t cell) {
    if (!holds(locator, cell, p)) return;
    const CellWeights found = locator.weights_in(cell, p);
    const double least = std::isfinite(found.rounding) ? found.least() : -1;
    const Rank rank{!preferred.empty() && preferred[cell] != 0, least};
    if (best && (rank < best_rank || (rank == best_rank && *best < cell))) return;
    best = cell;
    best_rank = rank;
  });
  return best;
}

/// Weights of the point are off by what CellWeights says, by the way to it, and by cutting them off
/// at 0, which at most doubles that for each of four.
RoundedValue value_in(const CellLocator& locator, std::uint32_t cell, const Vec3d& p,
                      const std::array<double, 4>& values, double distance) {
  const auto [lowest, highest] = std::ranges::minmax(values);
  const RoundedValue unknown{lowest / 2 + highest / 2, lowest, highest};
  const CellWeights found = locator.weights_in(cell, p);
  // Beyond half of it they may be anything; products of tiny lengths lose their digits.
  constexpr double kSmallest = 1e-280;
  const std::array<Vec3d, 4> c = locator.corners_of(cell);
  const double whole = std::abs(dot(cross(c[1] - c[0], c[2] - c[0]), c[3] - c[0]));
  if (!(found.rounding < 0.5) || !(whole > kSmallest)) return unknown;
  const std::array<double, 4> weights = found.clamped();
  const auto base = static_cast<std::size_t>(std::ranges::max_element(weights) - weights.begin());
  const std::array<double, 4> slopes = slopes_of(c);
  double sum = 0;
  double slack = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const double rise = values[k] - values[base];
    sum += weights[k] * rise;
    slack += std::abs(rise) * 8 * (found.rounding + 2 * distance * slopes[k]);
  }
  slack += 8 * kUnit * (std::abs(values[base]) + std::abs(lowest) + std::abs(highest));
  if (!std::isfinite(slack)) return unknown;
  const double value = std::clamp(values[base] + sum, lowest, highest);
  return {value, std::max(lowest, value - slack), std::min(highest, value + slack)};
}

}  // namespace lode
