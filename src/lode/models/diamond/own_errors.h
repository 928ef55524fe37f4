#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "lode/core/atomic_extremes.h"
#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/row_codes.h"

namespace lode::diamond {

/// Where own errors, rounded up, go: per level from 1 on its grid, 0 before any is known; [0] is
/// empty, level 0 is found nested. Nodes that no simplex with samples belongs to keep 0.
using OwnErrors = std::vector<std::span<ErrorCode>>;

/// Level of the tier-0 node that is a whole cube of side kPlanEdge.
template <int D>
inline constexpr int kPlanLevel = D == 3 ? 3 : 4;

/// Where a model's lattice lies in a larger one that it is a part of; the boxes are of its own
/// cells, lower <= cell < upper.
template <int D>
struct Part {
  Index<D> origin;        ///< In the larger one: multiples of kBrickEdge.
  LatticeBox<D> samples;  ///< What is known, from multiples of kPlanEdge on.
  LatticeBox<D> core;     ///< What no other part has; the rest are border layers.
  LatticeBox<D> shares;   ///< Cells whose errors of coarse nodes it finds: at least the core.

  [[nodiscard]] static Part whole(const Shape<D>& shape) {
    return {{}, {{}, shape.dims}, {{}, shape.dims}, {{}, shape.dims}};
  }
};

/// The errors of the nodes of levels 1 .. kPlanLevel in one brick and on its border, while they
/// are found: each is raised several times, in memory that stays near.
template <int D, typename C>
class BrickErrors {
 public:
  /// Where the node at `local`, relative to the brick's lowest corner, is.
  [[nodiscard]] static std::uint16_t place(int level, const Index<D>& local) {
    Index<D> dims;
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      dims[i] = edge(level);
      q[i] = local[i] >> level;
    }
    return static_cast<std::uint16_t>(first_of(level) + linear_index<D>(dims, q));
  }

  void clear() { errors_.assign(first_of(kPlanLevel<D> + 1), kUnseen); }

  /// As after errors of 0 of all nodes.
  void clear_to_zero() {
    static const std::vector<C> kZeros = zeros();
    errors_ = kZeros;
  }

  void raise(std::uint16_t place, C error) {
    C& own = errors_[place];
    own = error > own ? error : own;
  }

  /// Raises the model's errors, each by `slack` more. Nodes on the brick's border are shared with
  /// other bricks and so with other threads.
  void merge(const Shape<D>& shape, const Index<D>& brick, double slack,
             const OwnErrors& own) const {
    for (int level = 1; level <= kPlanLevel<D> && as_size(level) < own.size(); ++level)
      merge_level(level, shape.grid_dims(level), brick, slack, own[as_size(level)]);
  }

 private:
  static constexpr C kUnseen = -1;

  static constexpr std::int32_t edge(int level) { return (kBrickEdge<D> >> level) + 1; }
  static constexpr std::size_t first_of(int level) {
    std::size_t first = 0;
    for (int l = 1; l < level; ++l) first += power(as_size(edge(l)), D);
    return first;
  }

  static std::vector<C> zeros() {
    std::vector<C> result(first_of(kPlanLevel<D> + 1), kUnseen);
    for (int level = 1; level <= kPlanLevel<D>; ++level) {
      const Index<D> dims = all_equal<D>(edge(level));
      for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
        std::int32_t odd = 0;
        for (const std::int32_t x : point_of<D>(dims, i).v) odd |= x & 1;
        if (odd != 0) result[first_of(level) + i] = 0;
      }
    }
    return result;
  }

  void merge_level(int level, const Index<D>& dims, const Index<D>& brick, double slack,
                   std::span<ErrorCode> own) const {
    const std::int32_t n = edge(level);
    Index<D> rows;  // of the brick's nodes, at x = 0
    for (std::size_t i = 0; i < as_size(D); ++i) rows[i] = i == 0 ? 1 : n;
    const C* local = errors_.data() + first_of(level);
    for (std::size_t r = 0; r < n_points<D>(rows); ++r, local += n) {
      const Index<D> p = point_of<D>(rows, r);
      const Index<D> q = p + brick * (n - 1);
      bool is_shared = false;
      bool exists = true;
      for (std::size_t i = 1; i < as_size(D); ++i) {
        is_shared = is_shared || p[i] == 0 || p[i] == n - 1;
        exists = exists && q[i] < dims[i];
      }
      if (!exists) continue;
      ErrorCode* to = own.data() + linear_index<D>(dims, q);
      const std::size_t n_real = as_size(std::min(n, dims[0] - q[0]));
      std::array<ErrorCode, as_size(kBrickSamples<D>)> codes;
      encode_row({local, n_real}, slack, codes.data());
      if (!is_shared && n_real > 2) raise_errors(codes.data() + 1, n_real - 2, to + 1);
      const std::size_t step = is_shared ? 1 : std::max<std::size_t>(n_real - 1, 1);
      for (std::size_t x = 0; x < n_real; x += step)
        if (codes[x] > 0) raise_to(to[x], codes[x]);
    }
  }

  static void encode_row(std::span<const C> errors, double slack, ErrorCode* codes) {
    if constexpr (std::is_same_v<C, float>)
      if (slack == 0) return encode_errors(errors, codes);
    for (std::size_t i = 0; i < errors.size(); ++i)
      codes[i] = errors[i] >= C(0) ? encode_error(float_up(static_cast<double>(errors[i]) + slack))
                                   : ErrorCode{0};
  }

  std::vector<C> errors_;
};

}  // namespace lode::diamond
