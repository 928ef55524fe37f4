#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/node_columns.h"

namespace lode::insertions {

/// Nodes in squares of the domain, of about as many each; the outermost squares reach on without
/// end.
class NodeSquares {
 public:
  struct Placed {
    std::uint32_t square = 0;
    std::uint32_t time = 0;
    std::uint32_t node = 0;
    friend auto operator<=>(const Placed&, const Placed&) = default;
  };

  /// is_shifted: by half a square, along both axes.
  NodeSquares(const NodeColumns& columns, std::span<const std::uint32_t> nodes,
              std::size_t n_in_square, bool is_shifted) {
    LatticeBox box;
    for (std::uint32_t v = 0; v < columns.n_base; ++v) box.add(columns.points[v]);
    const std::int64_t width = std::int64_t{box.upper.x} - box.lower.x + 1;
    const std::int64_t height = std::int64_t{box.upper.y} - box.lower.y + 1;
    const double n_squares =
        std::max(1.0, static_cast<double>(nodes.size()) / static_cast<double>(n_in_square));
    const double area = static_cast<double>(width) * static_cast<double>(height);
    side_ = std::max<std::int64_t>(1, std::llround(std::sqrt(area / n_squares)));
    const std::int64_t shift = is_shifted ? side_ / 2 : 0;
    lower_x_ = box.lower.x - shift;
    lower_y_ = box.lower.y - shift;
    n_columns_ = static_cast<std::uint32_t>((width - 1 + shift) / side_ + 1);
    n_rows_ = static_cast<std::uint32_t>((height - 1 + shift) / side_ + 1);
    nodes_.reserve(nodes.size());
    for (const std::uint32_t node : nodes) {
      const delaunay::LatticePoint p = columns.point_of(node);
      const auto column = static_cast<std::uint32_t>((p.x - lower_x_) / side_);
      const auto row = static_cast<std::uint32_t>((p.y - lower_y_) / side_);
      nodes_.push_back({row * n_columns_ + column, columns.times[node], node});
    }
    std::ranges::sort(nodes_);
  }

  /// Square by square, and in one by time.
  [[nodiscard]] std::span<const Placed> nodes() const { return nodes_; }
  /// All places of the domain in it are the square's.
  [[nodiscard]] LatticeBox box_of(std::uint32_t square) const {
    const auto [left, right] = along(square % n_columns_, n_columns_, lower_x_);
    const auto [bottom, top] = along(square / n_columns_, n_rows_, lower_y_);
    return {{left, bottom}, {right, top}};
  }

 private:
  [[nodiscard]] std::pair<std::int32_t, std::int32_t> along(std::uint32_t i, std::uint32_t n,
                                                            std::int64_t lower) const {
    using Limits = std::numeric_limits<std::int32_t>;
    const std::int64_t begin = lower + i * side_;
    return {i == 0 ? Limits::min() : static_cast<std::int32_t>(begin),
            i + 1 == n ? Limits::max() : static_cast<std::int32_t>(begin + side_ - 1)};
  }

  std::int64_t side_ = 1;
  std::int64_t lower_x_ = 0;
  std::int64_t lower_y_ = 0;
  std::uint32_t n_columns_ = 1;
  std::uint32_t n_rows_ = 1;
  std::vector<Placed> nodes_;
};

}  // namespace lode::insertions
