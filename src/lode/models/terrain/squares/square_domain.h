#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/lattice_point.h"
#include "lode/core/result.h"

namespace lode::squares {

/// A square of 2^level columns and rows, whose lower corner is at multiples of that.
struct Square {
  std::int32_t level = 0;
  std::int32_t column = 0;  ///< Of the squares of its level.
  std::int32_t row = 0;

  friend bool operator==(const Square&, const Square&) = default;
  [[nodiscard]] std::int32_t side() const { return std::int32_t{1} << level; }
  [[nodiscard]] std::int32_t x() const { return column << level; }
  [[nodiscard]] std::int32_t y() const { return row << level; }
  /// Of the four, in the order of columns, then rows.
  [[nodiscard]] Square child(int i) const {
    return {level - 1, 2 * column + (i & 1), 2 * row + (i >> 1)};
  }
};

/// The cells that have a node as a corner, whether or not the raster has them.
[[nodiscard]] constexpr std::array<Square, 4> cells_around(LatticePoint p) {
  return {Square{0, p.x, p.y}, Square{0, p.x - 1, p.y}, Square{0, p.x, p.y - 1},
          Square{0, p.x - 1, p.y - 1}};
}

/// How much of a square is in the domain.
enum class Share : std::uint8_t { none, some, all };

/// Of a square, cut from the lower left corner to the upper right one, with the cut.
enum class SquarePart : std::uint8_t { all, lower, upper };

/// How many samples that are to be vertices a square has, on its sides, too, that are none of its
/// corners; of its halves, cut from the lower left corner to the upper right one, none of theirs.
struct KeptCounts {
  std::uint32_t all = 0;
  std::uint32_t lower = 0;  ///< The lower right half.
  std::uint32_t upper = 0;
};

/// The heights of a raster as float64, and the squares over it: those of level 0 are its cells, the
/// last level has one that holds all of them. The raster is not padded: what a square has beyond
/// it, or without a height, is not in the domain, the union of the cells with four heights.
class SquareDomain {
 public:
  /// 8 bytes a sample, and 4/3 a cell. Fails where no cell has four heights, and on heights beyond
  /// 1e30.
  [[nodiscard]] static Result<SquareDomain> make(const HeightGrid& grid);

  [[nodiscard]] std::int32_t n_levels() const { return static_cast<std::int32_t>(shares_.size()); }
  [[nodiscard]] Square root() const { return {n_levels() - 1, 0, 0}; }
  [[nodiscard]] std::int32_t n_columns(std::int32_t level) const {
    return ((size_x_ - 2) >> level) + 1;
  }
  [[nodiscard]] std::int32_t n_rows(std::int32_t level) const {
    return ((size_y_ - 2) >> level) + 1;
  }
  [[nodiscard]] bool has(const Square& q) const {
    return q.level < n_levels() && q.column >= 0 && q.row >= 0 && q.column < n_columns(q.level) &&
           q.row < n_rows(q.level);
  }
  /// Where its attributes are in an array of its level.
  [[nodiscard]] std::size_t index(const Square& q) const {
    return static_cast<std::size_t>(std::int64_t{q.row} * n_columns(q.level) + q.column);
  }
  /// none also of squares beyond the raster.
  [[nodiscard]] Share share(const Square& q) const {
    return has(q) ? shares_[static_cast<std::size_t>(q.level)][index(q)] : Share::none;
  }
  [[nodiscard]] std::size_t n_squares(std::int32_t level) const {
    return static_cast<std::size_t>(std::int64_t{n_columns(level)} * n_rows(level));
  }
  [[nodiscard]] double height(std::int32_t x, std::int32_t y) const { return row(y)[x]; }
  [[nodiscard]] const double* row(std::int32_t y) const {
    return heights_.data() + std::int64_t{y} * size_x_;
  }
  /// What is to be added to the largest |z - z'| of a part of a square that is wholly in the domain
  /// to make it a bound: z' a plane or bilinear between its corners, both less one of its heights,
  /// in float64. 0 where that is exact, as of samples of up to 16 bits and of level parts.
  [[nodiscard]] double rounding_in(const Square& q, SquarePart part) const;
  /// Makes samples vertices of all trees: different nodes of the domain, in rows.
  void keep(std::vector<LatticePoint> nodes);
  [[nodiscard]] const std::vector<LatticePoint>& kept() const { return kept_; }
  [[nodiscard]] bool is_kept(LatticePoint p) const;
  /// Of a square in the raster.
  [[nodiscard]] KeptCounts kept_in(const Square& q) const {
    return kept_.empty() ? KeptCounts{} : kept_in_[static_cast<std::size_t>(q.level)][index(q)];
  }
  /// Whether a sample is a corner of a cell with four heights.
  [[nodiscard]] bool has_node(LatticePoint p) const;
  [[nodiscard]] std::int32_t size_x() const { return size_x_; }
  [[nodiscard]] std::int32_t size_y() const { return size_y_; }

 private:
  std::int32_t size_x_ = 0;  ///< Samples in a row.
  std::int32_t size_y_ = 0;
  std::vector<double> heights_;
  double unit_ = 1;  ///< A power of two that all heights are multiples of.
  HeightRange range_;
  std::vector<std::vector<Share>> shares_;  ///< By level.
  std::vector<LatticePoint> kept_;
  std::vector<std::vector<KeptCounts>> kept_in_;  ///< By level; empty where nothing is kept.
};

}  // namespace lode::squares
