#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "lode/core/inline_list.h"
#include "lode/core/parallel.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/own_errors.h"
#include "lode/models/diamond/range_code.h"

namespace lode::diamond {

/// Joins every node's attributes with its children's, which are already joined: level by level,
/// tier by tier, row by row. All values are as stored; encoding keeps order, so the join of codes
/// is the code of the join.
template <int D>
class NestingPass {
 public:
  /// Fills model.levels from level 1 on; level 0 must be complete.
  NestingPass(Model<D>& model, const OwnErrors& own, Threads threads)
      : model_(model),
        own_(own),
        threads_(threads),
        reference_(model.range_reference()),
        mark_holes_(model.has_holes()) {}

  void run() {
    for (int level = 1; level < model_.shape.n_levels; ++level)
      for (int tier = D - 1; tier >= 0; --tier) run_tier(level, tier);
  }

 private:
  static constexpr std::size_t kMaxChildren = power(2, D) > 2 * D ? power(2, D) : 2 * D;

  /// A row of children: the child of the node at q[0] = x is at x·scale + shift of n.
  struct ChildRow {
    const ErrorCode* error = nullptr;
    const float* low = nullptr;
    const float* high = nullptr;
    std::int32_t scale = 1;
    std::int32_t shift = 0;
    std::int32_t n = 0;
  };
  using ChildRows = InlineList<ChildRow, kMaxChildren>;

  void run_tier(int level, int tier) {
    const Index<D> dims = model_.shape.grid_dims(level);
    const std::size_t n_rows = n_points<D>(dims) / as_size(dims[0]);
    parallel_for(n_rows, threads_, 16, [&](std::size_t row, int) {
      const Index<D> q = point_of<D>(dims, row * as_size(dims[0]));
      int n_odd = 0;
      for (std::size_t i = 1; i < as_size(D); ++i) n_odd += q[i] & 1;
      if (tier == D - 1 && n_odd == 0) clear_points(level, dims, q);
      if (n_odd == D - tier) run_row(level, dims, q, 0);
      if (n_odd + 1 == D - tier) run_row(level, dims, q, 1);
    });
  }

  /// The row's points that are samples of coarser levels: no nodes of this one.
  void clear_points(int level, const Index<D>& dims, const Index<D>& row) {
    NodeLevel& nodes = model_.levels[as_size(level)];
    const std::size_t first = linear_index<D>(dims, row);
    for (std::size_t x = 0; x < as_size(dims[0]); x += 2) {
      nodes.error[first + x] = 0;
      nodes.low[first + x] = std::numeric_limits<float>::infinity();
      nodes.high[first + x] = -std::numeric_limits<float>::infinity();
    }
  }

  /// The nodes of one row whose x is even (parity 0) or odd (1): one tier.
  void run_row(int level, const Index<D>& dims, const Index<D>& row, std::int32_t parity) {
    Index<D> q = row;
    q[0] = parity;
    int n_odd = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) n_odd += q[i] & 1;
    ChildRows children;
    if (n_odd == 1)
      add_cube_rows(level, q, children);
    else
      add_level_rows(level, dims, q, children);
    const std::size_t first = linear_index<D>(dims, row);
    NodeLevel& nodes = model_.levels[as_size(level)];
    const Row to{nodes.error.data() + first, nodes.low.data() + first, nodes.high.data() + first};
    const float* own = own_[as_size(level)].data() + first;
    for (std::int32_t x = parity; x < dims[0]; x += 2) {
      to.error[x] = encode_error(own[x]);
      to.low[x] = std::numeric_limits<float>::infinity();
      to.high[x] = -std::numeric_limits<float>::infinity();
    }
    for (const ChildRow& child : children) {
      if (child.scale == 1)
        join_row<1>(child, parity, dims[0], to);
      else
        join_row<2>(child, parity, dims[0], to);
    }
    q[0] = std::max(parity, first_beyond_data(level, row));
    q[0] += (q[0] ^ parity) & 1;
    for (; q[0] < dims[0]; q[0] += 2)
      join_vertices(diamond_at<D>(q * (std::int32_t{1} << level)), to.low[q[0]], to.high[q[0]]);
  }

  struct Row {
    ErrorCode* error;
    float* low;
    float* high;
  };

  /// Joins one child of each node parity, parity + 2, .. < n of a row.
  template <std::int32_t kScale>
  static void join_row(const ChildRow& child, std::int32_t parity, std::int32_t n, const Row& to) {
    std::int32_t x = parity;
    while (x * kScale + child.shift < 0) x += 2;
    for (; x < n && x * kScale + child.shift < child.n; x += 2) {
      const std::int32_t at = x * kScale + child.shift;
      to.error[x] = child.error[at] > to.error[x] ? child.error[at] : to.error[x];
      to.low[x] = child.low[at] < to.low[x] ? child.low[at] : to.low[x];
      to.high[x] = child.high[at] > to.high[x] ? child.high[at] : to.high[x];
    }
  }

  void add_row(int level, const Index<D>& dims, const Index<D>& first, std::int32_t scale,
               std::int32_t shift, ChildRows& out) const {
    Index<D> p = first;
    p[0] = 0;
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (p[i] < 0 || p[i] >= dims[i]) return;
    const NodeLevel& nodes = model_.levels[as_size(level)];
    const std::size_t at = linear_index<D>(dims, p);
    out.push_back({nodes.error.data() + at, nodes.low.data() + at, nodes.high.data() + at, scale,
                   shift, dims[0]});
  }

  /// Children in the same level: one step along each odd axis.
  void add_level_rows(int level, const Index<D>& dims, const Index<D>& q, ChildRows& out) const {
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if ((q[i] & 1) == 0) continue;
      for (const std::int32_t step : {-1, 1}) {
        Index<D> child = q;
        child[i] += step;
        add_row(level, dims, child, 1, i == 0 ? step : 0, out);
      }
    }
  }

  /// Children that are cubes of the next finer level: half a step along all axes.
  void add_cube_rows(int level, const Index<D>& q, ChildRows& out) const {
    const Index<D> dims = model_.shape.attribute_dims(level - 1);
    const bool is_finest = level == 1;  // one entry per cube instead of a grid
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> child;
      Index<D> step;
      for (int i = 0; i < D; ++i) {
        const auto a = as_size(i);
        const bool is_upper = ((corner >> i) & 1) != 0;
        step[a] = is_finest ? (is_upper ? 0 : -1) : (is_upper ? 1 : -1);
        child[a] = q[a] * (is_finest ? 1 : 2) + step[a];
      }
      add_row(level - 1, dims, child, is_finest ? 1 : 2, step[0], out);
    }
  }

  /// The first x of a row from which domains reach beyond the data.
  [[nodiscard]] std::int32_t first_beyond_data(int level, const Index<D>& row) const {
    for (std::size_t i = 1; i < as_size(D); ++i)
      if (((row[i] + 1) << level) > model_.shape.dims[i] - 1) return 0;
    return (model_.shape.dims[0] - 1) >> level;
  }

  /// Values beyond the data are no samples of any child, but the surface meets them.
  void join_vertices(const Diamond<D>& d, float& low, float& high) const {
    join_value(d.centre, low, high);
    for (const Index<D>& v : domain_vertices<D>(d)) join_value(v, low, high);
  }

  void join_value(const Index<D>& p, float& low, float& high) const {
    const double v = model_.value(p);
    if (mark_holes_ && model_.is_hole(v)) return;
    low = std::min(low, range_down(v, reference_));
    high = std::max(high, range_up(v, reference_));
  }

  Model<D>& model_;
  const OwnErrors& own_;
  Threads threads_;
  double reference_;
  bool mark_holes_;
};

}  // namespace lode::diamond
