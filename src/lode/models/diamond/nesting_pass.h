#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/raw_level.h"

namespace lode::diamond {

/// Joins every node's attributes with its children's, which are already joined.
template <int D, typename C>
class NestingPass {
 public:
  NestingPass(const Model<D>& model, std::vector<RawLevel<C>>& levels, Threads threads)
      : model_(model), levels_(levels), threads_(threads) {}

  void run() {
    for (int level = 1; level < model_.shape.n_levels; ++level)
      for (int tier = D - 1; tier >= 0; --tier) run_tier(level, tier);
  }

 private:
  void run_tier(int level, int tier) {
    const Index<D> dims = model_.shape.grid_dims(level);
    const std::size_t n_rows = n_points<D>(dims) / as_size(dims[0]);
    parallel_for(n_rows, threads_, 16, [&](std::size_t row, int) {
      const std::size_t first = row * as_size(dims[0]);
      Index<D> q = point_of<D>(dims, first);
      for (; q[0] < dims[0]; ++q[0]) {
        int n_odd = 0;
        for (std::size_t i = 0; i < as_size(D); ++i) n_odd += q[i] & 1;
        if (n_odd == D - tier) join_children(level, dims, q);
      }
    });
  }

  void join_children(int level, const Index<D>& dims, const Index<D>& q) {
    RawLevel<C>& own = levels_[as_size(level)];
    const std::size_t at = linear_index<D>(dims, q);
    const std::int32_t h = std::int32_t{1} << level;
    const Diamond<D> d = diamond_at<D>(q * h);
    float error = own.error[at];
    C low = std::numeric_limits<C>::infinity();
    C high = -low;
    const auto join = [&](const RawLevel<C>& from, std::size_t i) {
      error = std::max(error, from.error[i]);
      low = std::min(low, from.low[i]);
      high = std::max(high, from.high[i]);
    };
    if (d.tier < D - 1)
      for (std::size_t i = 0; i < as_size(D); ++i) {
        if (!d.is_odd(static_cast<int>(i))) continue;
        Index<D> child = q;
        child[i] = q[i] - 1;
        join(own, linear_index<D>(dims, child));
        child[i] = q[i] + 1;
        join(own, linear_index<D>(dims, child));
      }
    else
      join_cubes(level, q, join);
    if (reaches_beyond_data(d)) {
      for (const Index<D>& v : domain_vertices<D>(d)) join_value(v, low, high);
      join_value(d.centre, low, high);
    }
    own.error[at] = error;
    own.low[at] = low;
    own.high[at] = high;
  }

  template <typename Join>
  void join_cubes(int level, const Index<D>& q, const Join& join) {
    const Index<D> child_dims = level_dims<D>(model_.shape, level - 1);
    for (int corner = 0; corner < (1 << D); ++corner) {
      Index<D> child;
      bool exists = true;
      for (int i = 0; i < D; ++i) {
        const auto a = as_size(i);
        child[a] = 2 * q[a] + (((corner >> i) & 1) != 0 ? 1 : -1);
        if (level == 1) child[a] = child[a] >> 1;
        exists = exists && child[a] >= 0 && child[a] < child_dims[a];
      }
      if (exists) join(levels_[as_size(level - 1)], linear_index<D>(child_dims, child));
    }
  }

  bool reaches_beyond_data(const Diamond<D>& d) const {
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (d.centre[i] + d.h() > model_.shape.dims[i] - 1) return true;
    return false;
  }

  void join_value(const Index<D>& p, C& low, C& high) const {
    const double v = model_.value_or_nan(p);
    if (std::isnan(v)) return;
    low = std::min(low, static_cast<C>(v));
    high = std::max(high, static_cast<C>(v));
  }

  const Model<D>& model_;
  std::vector<RawLevel<C>>& levels_;
  Threads threads_;
};

}  // namespace lode::diamond
