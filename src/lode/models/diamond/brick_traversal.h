#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "lode/models/diamond/leaf_attributes.h"
#include "lode/models/diamond/selection.h"

namespace lode::diamond {

/// What a traversal counts.
struct TraversalStats {
  ErrorCode achieved = 0;
  std::uint64_t nodes_visited = 0;

  void join(const TraversalStats& other) {
    achieved = std::max(achieved, other.achieved);
    nodes_visited += other.nodes_visited;
  }
};

/// Calls emit(simplex) for each leaf simplex, inside one brick, of the cut of a selection that
/// the isosurface crosses. Level-0 nodes of tiers above 0 have no stored attributes: their error
/// comes from the samples, and their range is not asked (it could only stop the refinement of
/// simplices without surface).
template <int D>
class BrickTraversal {
 public:
  using Vertices = std::array<Index<D>, as_size(D) + 1>;

  explicit BrickTraversal(const Selection<D>& selection) : selection_(selection) {}

  void open(const Index<D>& brick) {
    const Model<D>& model = selection_.model();
    base_ = brick * kBrickEdge<D>;
    values_.resize(kBrickSize<D>);
    gather_values<D>(model, brick, 0, values_.data());
    is_near_hole_ = false;
    if (!model.has_holes()) return;
    for (int code = 0, n = D == 3 ? 27 : 9; code < n; ++code) {
      Index<D> b = brick;
      bool exists = true;
      for (int i = 0, rest = code; i < D; ++i, rest /= 3) {
        b[as_size(i)] += rest % 3 - 1;
        exists = exists && b[as_size(i)] >= 0 && b[as_size(i)] < model.brick_dims[as_size(i)];
      }
      if (exists && model.brick_holes[linear_index<D>(model.brick_dims, b)] != 0)
        is_near_hole_ = true;
    }
  }

  /// `simplex` in global coordinates, inside the open brick.
  template <typename Emit>
  void visit(const Simplex<D>& simplex, TraversalStats& stats, const Emit& emit) {
    const Model<D>& model = selection_.model();
    if (!model.shape.overlaps_data(bounds_of(simplex))) return;
    if (is_finest(simplex)) {
      emit_leaf(simplex, emit);
      return;
    }
    ++stats.nodes_visited;
    const Diamond<D> d = diamond_at<D>(simplex.bisection_point());
    ErrorCode error = 0;
    if (d.level > 0 || d.tier == 0) {
      const std::size_t at = selection_.index_of(d);
      if (!selection_.is_active(d.level, at)) return;
      error = selection_.error(d.level, at);
    } else {
      error = fine_error(d);
    }
    if (!selection_.exceeds_tolerance(error)) {
      if (emit_leaf(simplex, emit)) stats.achieved = std::max(stats.achieved, error);
      return;
    }
    for (const Simplex<D>& half : bisect(simplex)) visit(half, stats, emit);
  }

 private:
  double value(const Index<D>& p) const { return values_[Model<D>::brick_offset(p - base_)]; }

  double midpoint_error(const Diamond<D>& d) const {
    if (!selection_.model().shape.is_sample(d.centre)) return 0;
    const auto ends = axis_ends<D>(d);
    const double e = std::abs(value(d.centre) - 0.5 * (value(ends[0]) + value(ends[1])));
    return std::isnan(e) ? 0 : e;
  }

  /// The nested error of a node of level 0 and tier >= 1: the largest midpoint error of itself
  /// and the finest nodes below it.
  ErrorCode fine_error(const Diamond<D>& d) const {
    if (is_near_hole_ && selection_.model().is_mixed(d.centre)) return kInfiniteError;
    double e = midpoint_error(d);
    if (d.tier < D - 1)
      for (const Index<D>& child : children<D>(d)) {
        if (is_near_hole_ && selection_.model().is_mixed(child)) return kInfiniteError;
        e = std::max(e, midpoint_error(diamond_at<D>(child)));
      }
    return encode_error(float_up(e));
  }

  template <typename Emit>
  bool emit_leaf(const Simplex<D>& simplex, const Emit& emit) {
    std::array<double, as_size(D) + 1> values;
    int n_inside = 0;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      values[i] = value(simplex.v[i]);
      if (std::isnan(values[i])) return false;
      n_inside += values[i] >= selection_.isovalue() ? 1 : 0;
    }
    if (n_inside == 0 || n_inside == D + 1) return false;
    if (is_near_hole_ && selection_.model().is_removed(simplex)) return false;
    emit(simplex.v, values);
    return true;
  }

  const Selection<D>& selection_;
  Index<D> base_;
  std::vector<double> values_;
  bool is_near_hole_ = false;
};

}  // namespace lode::diamond
