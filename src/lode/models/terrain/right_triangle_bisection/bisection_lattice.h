#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "lode/core/lattice_point.h"

namespace lode::bisection {

/// The nodes of the smallest square of 2^k columns and rows that a raster fits in, as longest-edge
/// bisection makes them: each but the four corners is the middle of the hypotenuse that the two
/// triangles of its **diamond** share, and refining it splits both.
///
/// A raster of any size: nodes beyond its last column or row stand on that column or row, which
/// turns no triangle over. Those that become flat are none; the others cover the raster once.
class Lattice {
 public:
  Lattice(std::int32_t n_columns, std::int32_t n_rows)
      : last_{n_columns - 1, n_rows - 1},
        side_(static_cast<std::int32_t>(
            std::bit_ceil(static_cast<std::uint32_t>(std::max(last_.x, last_.y))))),
        stride_(n_columns + n_levels() + 1) {
    stride_ += stride_ % 64 == 0 ? 1 : 0;  // Rows of a power of two would share places in a cache.
  }

  /// Columns and rows of the square; 1 is the least.
  [[nodiscard]] std::int32_t side() const { return side_; }
  [[nodiscard]] int n_levels() const {
    return std::countr_zero(static_cast<std::uint32_t>(side_)) + 1;
  }
  /// The last column and row of the raster.
  [[nodiscard]] LatticePoint last() const { return last_; }
  /// The sample that a node stands on.
  [[nodiscard]] LatticePoint place(LatticePoint node) const {
    return {std::min(node.x, last_.x), std::min(node.y, last_.y)};
  }
  [[nodiscard]] bool has(LatticePoint node) const {
    return node.x >= 0 && node.y >= 0 && node.x <= side_ && node.y <= side_;
  }
  [[nodiscard]] bool is_corner(LatticePoint node) const {
    return (node.x == 0 || node.x == side_) && (node.y == 0 || node.y == side_);
  }
  /// Whether a sample is what a corner stands on: it is a vertex of every mesh.
  [[nodiscard]] bool is_under_corner(LatticePoint sample) const {
    return (sample.x == 0 || sample.x == last_.x) && (sample.y == 0 || sample.y == last_.y);
  }
  /// Of a node's diamond: whether it has any area, and whether it reaches beyond the raster.
  [[nodiscard]] bool has_area(LatticePoint node, std::int32_t reach) const {
    return node.x - reach < last_.x && node.y - reach < last_.y;
  }
  /// Whether there is something to refine.
  [[nodiscard]] bool has_node(LatticePoint node, std::int32_t reach) const {
    return has(node) && !is_corner(node) && has_area(node, reach);
  }
  [[nodiscard]] bool is_stretched(LatticePoint node, std::int32_t reach) const {
    return std::min(node.x + reach, side_) > last_.x || std::min(node.y + reach, side_) > last_.y;
  }

  /// Where a node's error is in an array of size(): y * stride() + x of samples. Beyond the raster
  /// there is room for the nodes whose diamonds reach into it, at most one column for each power of
  /// two.
  [[nodiscard]] std::size_t index(LatticePoint node) const {
    return static_cast<std::size_t>(std::int64_t{folded(node.y, last_.y)} * stride_ +
                                    folded(node.x, last_.x));
  }
  /// The node whose error index() puts there; none of the lattice if there is none.
  [[nodiscard]] LatticePoint node_at(std::int32_t column, std::int32_t row) const {
    return {unfolded(column, last_.x), unfolded(row, last_.y)};
  }
  [[nodiscard]] std::int64_t stride() const { return stride_; }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(stride_ * (std::int64_t{last_.y} + n_levels() + 2));
  }

 private:
  static std::int32_t folded(std::int32_t i, std::int32_t last) {
    return i <= last ? i : last + 1 + std::countr_zero(static_cast<std::uint32_t>(i));
  }
  /// Beyond the last one diamonds reach back from the first multiple of a power of two, unless that
  /// is one of twice that power.
  static std::int32_t unfolded(std::int32_t at, std::int32_t last) {
    if (at <= last) return at;
    constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();
    const int k = at - last - 1;
    if (k > 30 || ((last >> k) & 1) != 0) return kNone;
    const std::int64_t node = ((std::int64_t{last} >> k) + 1) << k;
    return node < kNone ? static_cast<std::int32_t>(node) : kNone;
  }

  LatticePoint last_;
  std::int32_t side_;
  std::int64_t stride_;
};

/// The diamond of a node.
struct Diamond {
  LatticePoint node;
  std::int32_t reach = 0;  ///< The largest power of two that divides column and row.
  /// Its sides run along columns and rows, 2 reach long; else the hypotenuse does.
  bool is_square = false;
  std::array<LatticePoint, 2> ends;    ///< Of the hypotenuse.
  std::array<LatticePoint, 2> apexes;  ///< To its left (x to the right, y up) and its right.

  /// Of no corner of the lattice's square. Apexes may lie beyond that.
  explicit Diamond(LatticePoint p)
      : node(p), reach(std::int32_t{1} << std::countr_zero(static_cast<std::uint32_t>(p.x | p.y))) {
    const std::int32_t r = reach;
    const bool has_odd_column = (p.x & r) != 0;
    is_square = has_odd_column && (p.y & r) != 0;
    if (!is_square) {
      // The apexes are middles of squares.
      if (has_odd_column) {
        ends = {{{p.x - r, p.y}, {p.x + r, p.y}}};
        apexes = {{{p.x, p.y + r}, {p.x, p.y - r}}};
      } else {
        ends = {{{p.x, p.y - r}, {p.x, p.y + r}}};
        apexes = {{{p.x - r, p.y}, {p.x + r, p.y}}};
      }
    } else if (runs_up(p, r)) {
      ends = {{{p.x - r, p.y - r}, {p.x + r, p.y + r}}};
      apexes = {{{p.x - r, p.y + r}, {p.x + r, p.y - r}}};
    } else {
      ends = {{{p.x + r, p.y - r}, {p.x - r, p.y + r}}};
      apexes = {{{p.x - r, p.y - r}, {p.x + r, p.y + r}}};
    }
  }

  /// Whether the hypotenuse of a square round p with the half side r goes from its lower left
  /// corner to the upper right one: it is where both columns and rows are even multiples of 2 r, or
  /// both odd, that the square of twice its side has a corner and its middle.
  static bool runs_up(LatticePoint p, std::int32_t r) {
    return (((p.x - r) / (2 * r) + (p.y - r) / (2 * r)) & 1) == 0;
  }
  /// Of the apexes' nodes, which are to be refined before this one where Lattice::has_node() them.
  [[nodiscard]] std::int32_t apex_reach() const { return is_square ? 2 * reach : reach; }
  /// Of the children, which have to wait for this one.
  [[nodiscard]] std::int32_t child_reach() const { return is_square ? reach : reach / 2; }
  [[nodiscard]] std::array<LatticePoint, 4> children() const {
    const std::int32_t r = reach;
    if (is_square)
      return {
          {{node.x - r, node.y}, {node.x + r, node.y}, {node.x, node.y - r}, {node.x, node.y + r}}};
    const std::int32_t h = r / 2;
    return {{{node.x - h, node.y - h},
             {node.x + h, node.y - h},
             {node.x - h, node.y + h},
             {node.x + h, node.y + h}}};
  }
  /// Whether it has any: the sides of squares of two columns and rows do not.
  [[nodiscard]] bool has_children() const { return is_square || reach > 1; }
};

}  // namespace lode::bisection
