#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/height_points.h"
#include "lode/core/lattice_point.h"

namespace lode {

/// Points by squares, of some four each.
class PointSquares {
 public:
  explicit PointSquares(const HeightPoints& points) : points_(points) {
    constexpr double kPerSquare = 4;
    const double area = static_cast<double>(points.n_columns) * points.n_rows;
    const double wanted = area * kPerSquare / static_cast<double>(points.nodes.size());
    while (std::ldexp(1, 2 * bits_) < wanted) ++bits_;
    n_across_ = ((points.n_columns - 1) >> bits_) + 1;
    const std::int32_t n_up = ((points.n_rows - 1) >> bits_) + 1;
    first_.assign(static_cast<std::size_t>(n_across_) * static_cast<std::size_t>(n_up) + 1, 0);
    for (const LatticePoint& p : points.nodes) ++first_[square_of(p) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    entries_.resize(points.nodes.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::uint32_t i = 0; i < points.nodes.size(); ++i)
      entries_[next[square_of(points.nodes[i])]++] = i;
  }

  /// Calls visit(number) for all points in a rectangle of nodes, and others near it.
  template <typename Visit>
  void for_each_near(LatticePoint low, LatticePoint high, const Visit& visit) const {
    const auto inside = [&](std::int32_t x, std::int32_t n) { return std::clamp(x, 0, n - 1); };
    const std::int32_t left = inside(low.x, points_.n_columns) >> bits_;
    const std::int32_t right = inside(high.x, points_.n_columns) >> bits_;
    const std::int32_t bottom = inside(low.y, points_.n_rows) >> bits_;
    const std::int32_t top = inside(high.y, points_.n_rows) >> bits_;
    for (std::int32_t y = bottom; y <= top; ++y)
      for (std::int32_t x = left; x <= right; ++x) {
        const std::size_t square = at(x, y);
        for (std::uint32_t i = first_[square]; i < first_[square + 1]; ++i) visit(entries_[i]);
      }
  }

 private:
  [[nodiscard]] std::size_t at(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(n_across_) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::size_t square_of(LatticePoint p) const {
    return at(p.x >> bits_, p.y >> bits_);
  }

  const HeightPoints& points_;
  int bits_ = 0;
  std::int32_t n_across_ = 1;
  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> entries_;
};

}  // namespace lode
