#include "lode/api/tetra_space_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/value_distance.h"

namespace lode {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// Where something lies, and which values it has.
struct ValueBox {
  std::array<double, 4> low{kNowhere, kNowhere, kNowhere, kNowhere};  ///< x, y, z, value.
  std::array<double, 4> high{-kNowhere, -kNowhere, -kNowhere, -kNowhere};

  void widen(const Vec3d& p, double value) {
    const std::array<double, 4> at{p[0], p[1], p[2], value};
    for (std::size_t i = 0; i < 4; ++i) {
      low[i] = std::min(low[i], at[i]);
      high[i] = std::max(high[i], at[i]);
    }
  }
  void widen(const ValueBox& other) {
    for (std::size_t i = 0; i < 4; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  /// Infinite without the values, else the square of how far its box is.
  [[nodiscard]] double squared_distance(const Vec3d& p, const Range& values) const {
    if (values.high < low[3] || values.low > high[3]) return kNowhere;
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double out = std::max({low[i] - p[i], p[i] - high[i], 0.0});
      sum += out * out;
    }
    return sum;
  }
};

/// Finds the nearest point of cells that has a value: a tree of halves, along the axis in which
/// they are longest.
class NearestValue {
 public:
  NearestValue(const TetraVertices& vertices, const TetraCells& cells)
      : vertices_(vertices), cells_(cells), order_(cells.corners.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    if (!order_.empty()) split(0, static_cast<std::uint32_t>(order_.size()));
  }

  /// Infinite where no cell has it.
  [[nodiscard]] double distance(const Vec3d& p, const Range& values) const {
    double least = kNowhere;  // squared
    if (!nodes_.empty()) search(0, p, values, least);
    return std::sqrt(least);
  }

 private:
  static constexpr std::uint32_t kLeaf = 8;
  struct Node {
    ValueBox extent;
    std::uint32_t begin = 0;
    std::uint32_t end = 0;
    std::uint32_t second = 0;  ///< The first child is the next node; 0: a leaf.
  };

  [[nodiscard]] ValueBox extent_of(std::uint32_t cell) const {
    ValueBox extent;
    for (const std::uint32_t v : cells_.corners[cell])
      extent.widen(vertices_.positions[v], vertices_.values[v]);
    return extent;
  }
  [[nodiscard]] double centre_of(std::uint32_t cell, std::size_t axis) const {
    double sum = 0;
    for (const std::uint32_t v : cells_.corners[cell]) sum += vertices_.positions[v][axis];
    return sum;
  }

  std::uint32_t split(std::uint32_t begin, std::uint32_t end) {
    const auto at = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({.extent = {}, .begin = begin, .end = end});
    ValueBox extent;
    for (std::uint32_t i = begin; i < end; ++i) extent.widen(extent_of(order_[i]));
    nodes_[at].extent = extent;
    if (end - begin <= kLeaf) return at;
    std::size_t axis = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (extent.high[i] - extent.low[i] > extent.high[axis] - extent.low[axis]) axis = i;
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](std::uint32_t a, std::uint32_t b) { return centre_of(a, axis) < centre_of(b, axis); });
    split(begin, middle);
    const std::uint32_t second = split(middle, end);
    nodes_[at].second = second;
    return at;
  }

  void search(std::uint32_t at, const Vec3d& p, const Range& values, double& least) const {
    const Node& node = nodes_[at];
    if (node.second == 0) {
      for (const std::uint32_t cell :
           std::span(order_).subspan(node.begin, node.end - node.begin)) {
        const double d = distance_in(cell, p, values);
        least = std::min(least, d * d);
      }
      return;
    }
    std::array<std::uint32_t, 2> children{at + 1, node.second};
    std::array<double, 2> far{nodes_[children[0]].extent.squared_distance(p, values),
                              nodes_[children[1]].extent.squared_distance(p, values)};
    if (far[1] < far[0]) {
      std::swap(children[0], children[1]);
      std::swap(far[0], far[1]);
    }
    for (std::size_t i = 0; i < 2; ++i)
      if (far[i] < least) search(children[i], p, values, least);
  }

  [[nodiscard]] double distance_in(std::uint32_t cell, const Vec3d& p, const Range& values) const {
    std::array<Vec3d, 4> corners;
    std::array<double, 4> at{};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::uint32_t v = cells_.corners[cell][k];
      corners[k] = vertices_.positions[v];
      at[k] = vertices_.values[v];
    }
    return tetra_mt::distance_to_values(corners, at, values, p);
  }

  const TetraVertices& vertices_;
  const TetraCells& cells_;
  std::vector<std::uint32_t> order_;  ///< Cells, as leaves have them.
  std::vector<Node> nodes_;
};

}  // namespace

TetraSpaceErrors measure_space_errors(const TetraVertices& vertices, const TetraCells& cells,
                                      double stated, Threads threads) {
  constexpr std::size_t kAtOnce = 1024;
  const NearestValue nearest(vertices, cells);
  std::vector<double> distances(vertices.samples.size());
  double low = kNowhere;
  double high = -kNowhere;
  for (const std::uint32_t v : vertices.samples) {
    low = std::min(low, vertices.values[v]);
    high = std::max(high, vertices.values[v]);
  }
  const double slack = distances.empty() ? 0 : tetra_mt::kSameValue * (high - low);
  parallel_for(distances.size(), threads, kAtOnce, [&](std::size_t i, int) {
    const std::uint32_t v = vertices.samples[i];
    const double value = vertices.values[v];
    distances[i] = nearest.distance(vertices.positions[v], {value - slack, value + slack});
  });
  TetraSpaceErrors found;
  double squares = 0;
  for (const double d : distances) {
    if (!std::isfinite(d)) {
      ++found.n_lost;
      continue;
    }
    ++found.n_vertices;
    if (d > stated) ++found.n_above;
    found.largest = std::max(found.largest, d);
    squares += d * d;
  }
  if (found.n_vertices > 0)
    found.root_mean_square = std::sqrt(squares / static_cast<double>(found.n_vertices));
  return found;
}

}  // namespace lode
