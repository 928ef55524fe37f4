#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Goes down from the root, round a point, to where descends(simplex) is false, and returns the
/// centre of the node that bisects that simplex; none where it is a finest one. The point is the
/// middle of a finest simplex in the data: `sum`, of its vertices, is four times that, and its
/// barycentric coordinates in all simplices round it are exact.
template <typename Descends>
[[nodiscard]] std::optional<Index<3>> leaf_node(const Shape<3>& shape, const Index<3>& sum,
                                                const Descends& descends) {
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return sum[a] > sum[b]; });
  Simplex<3> leaf{};
  for (std::size_t i = 0; i < 3; ++i) {
    leaf.v[i + 1] = leaf.v[i];
    leaf.v[i + 1][order[i]] = shape.root_side();
  }
  const std::int64_t whole = std::int64_t{4} * shape.root_side();
  std::array<std::int64_t, 4> weight{whole - sum[order[0]], sum[order[0]] - sum[order[1]],
                                     sum[order[1]] - sum[order[2]], sum[order[2]]};
  while (!is_finest(leaf)) {
    if (!descends(leaf)) return leaf.bisection_point();
    // The middle of the edge 0 - tag takes the place of the end that is farther.
    const std::size_t tag = as_size(leaf.tag);
    const bool is_first = weight[0] >= weight[tag];
    leaf = bisect(leaf)[is_first ? 0 : 1];
    const std::int64_t both = 2 * std::min(weight[0], weight[tag]);
    const std::int64_t rest = std::abs(weight[0] - weight[tag]);
    if (is_first) {
      weight[0] = rest;
    } else {
      for (std::size_t i = 0; i + 1 < tag; ++i) weight[i] = weight[i + 1];
      weight[tag - 1] = rest;
    }
    weight[tag] = both;
  }
  return {};
}

}  // namespace lode::diamond
