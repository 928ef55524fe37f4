#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/models/diamond/brick_samples.h"
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

/// Calls emit(BrickSimplex) for each leaf simplex, inside one brick, of the cut of a selection that
/// the isosurface, or one of many, crosses. Level-0 nodes of tiers above 0 have no stored
/// attributes: their error comes from the samples, and their range is not asked (it could only stop
/// the refinement of simplices without surface).
template <int D, typename Selected = Selection<D>>
class BrickTraversal {
 public:
  explicit BrickTraversal(const Selected& selection)
      : selection_(selection),
        samples_(selection.model()),
        rounding_(0x1p-46 * std::max(std::abs(selection.model().stats.min),
                                     std::abs(selection.model().stats.max))) {
    const Shape<D>& shape = selection.model().shape;
    for (int level = 0; level <= kBrickLevel<D> && level < shape.n_levels; ++level) {
      std::size_t stride = 1;
      for (int i = 0; i < D; ++i) {
        level_strides_[as_size(level)][as_size(i)] = stride;
        stride *= as_size(level == 0 ? shape.n_cubes(0, i) : shape.grid_dims(level)[as_size(i)]);
      }
    }
  }

  void open(const Index<D>& brick) {
    samples_.open(brick);
    n_fine_nodes_ = 0;
    for (int level = 0; level <= kBrickLevel<D>; ++level) {
      level_base_[as_size(level)] = 0;
      for (std::size_t i = 0; i < as_size(D); ++i)
        level_base_[as_size(level)] +=
            as_size(samples_.base()[i] >> shift_of(level)) * level_strides_[as_size(level)][i];
    }
  }

  /// `simplex` in global coordinates: one of the open brick's Kuhn simplices, or inside one.
  template <typename Emit>
  void visit(const Simplex<D>& simplex, TraversalStats& stats, const Emit& emit) {
    BrickSimplex<D> s;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      s.corner[i] = samples_.point(simplex.v[i] - samples_.base());
      s.corner[i].value = samples_.value(s.corner[i].offset);
    }
    s.is_positive = is_positive(simplex);
    const Index<D> edge = simplex.v[0] - simplex.v[as_size(simplex.tag)];
    descend(s, simplex.tag, common_exponent<D>(edge) - 1, stats, emit);
  }

  /// Frees the memory of samples; none is open any more.
  void forget_samples() { samples_.forget(); }
  /// The open brick's.
  [[nodiscard]] const BrickSamples<D>& samples() const { return samples_; }

 private:
  static constexpr int kManyFineNodes = 2000;

  static constexpr int shift_of(int level) { return std::max(level, 1); }
  static constexpr bool is_stored(int level, int tag) { return level > 0 || tag == D; }

  /// Whether the edges from corner 0 to the others, in order, have a positive determinant.
  [[nodiscard]] static bool is_positive(const Simplex<D>& s) {
    std::array<Vec<std::int64_t, as_size(D)>, as_size(D)> edge;
    for (std::size_t j = 0; j < as_size(D); ++j)
      for (std::size_t i = 0; i < as_size(D); ++i) edge[j][i] = s.v[j + 1][i] - s.v[0][i];
    if constexpr (D == 3)
      return dot(cross(edge[0], edge[1]), edge[2]) > 0;
    else
      return edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0] > 0;
  }

  [[nodiscard]] std::size_t node_index(int level, std::uint32_t packed) const {
    std::size_t at = level_base_[as_size(level)];
    for (int i = 0; i < D; ++i)
      at += as_size(BrickPoint::coordinate(packed, i) >> shift_of(level)) *
            level_strides_[as_size(level)][as_size(i)];
    return at;
  }

  template <typename Emit>
  void descend(const BrickSimplex<D>& s, int tag, int level, TraversalStats& stats,
               const Emit& emit) {
    if (!samples_.overlaps_data(s)) return;
    if (level < 0) {
      emit_leaf(s, emit);
      return;
    }
    ++stats.nodes_visited;
    BrickPoint m = samples_.between(s.corner[0], s.corner[as_size(tag)]);
    const bool is_forced =
        samples_.reaches_across(m, level) ||
        (selection_.has_wanted() && selection_.is_wanted(samples_.global(m.packed)));
    ErrorCode error = 0;
    if (is_stored(level, tag)) {
      const std::size_t at = node_index(level, m.packed);
      error = selection_.error(level, at);
      if (is_clear(s, error)) return;
      if ((is_forced || selection_.exceeds_tolerance(error)) && !selection_.is_active(level, at))
        return;
      m.value = samples_.value(m.offset);
    } else {
      m.value = samples_.value(m.offset);
      if (++n_fine_nodes_ == kManyFineNodes) samples_.gather();
      if (samples_.is_on_one_side(s, tag, m, selection_)) return;
      if (!is_forced && !selection_.is_full()) error = samples_.fine_error(s, tag, m);
    }
    if (is_forced || selection_.exceeds_tolerance(error))
      bisect(s, m, tag, level, stats, emit);
    else if (emit_leaf(s, emit))
      stats.achieved = std::max(stats.achieved, error);
  }

  template <typename Emit>
  void bisect(const BrickSimplex<D>& s, const BrickPoint& m, int tag, int level,
              TraversalStats& stats, const Emit& emit) {
    const int next_tag = tag > 1 ? tag - 1 : D;
    const int next_level = tag > 1 ? level : level - 1;
    BrickSimplex<D> half = s;
    half.corner[as_size(tag)] = m;
    descend(half, next_tag, next_level, stats, emit);
    // The middle takes the place of corner 0, then moves behind `tag` others.
    for (std::size_t i = 0; i < as_size(tag); ++i) half.corner[i] = s.corner[i + 1];
    half.is_positive = s.is_positive != ((tag & 1) != 0);
    descend(half, next_tag, next_level, stats, emit);
  }

  /// Whether a simplex lies in the data and all its samples on one side of the isovalue: its
  /// corners do, farther from it than any sample is from what is interpolated between them.
  [[nodiscard]] bool is_clear(const BrickSimplex<D>& s, ErrorCode error) const {
    double low = s.corner[0].value;
    double high = low;
    for (std::size_t i = 1; i <= as_size(D); ++i) {
      low = std::min(low, s.corner[i].value);
      high = std::max(high, s.corner[i].value);
    }
    const double bound = static_cast<double>(decode_error(error)) + rounding_;
    return selection_.is_clear(low - bound, high + bound) && samples_.is_in_data(s);
  }

  template <typename Emit>
  bool emit_leaf(const BrickSimplex<D>& s, const Emit& emit) const {
    const auto side = selection_.side(s.corner[0].value);
    bool is_crossed = false;
    for (const BrickPoint& corner : s.corner) {
      if (std::isnan(corner.value)) return false;
      is_crossed = is_crossed || selection_.side(corner.value) != side;
    }
    if (!is_crossed || samples_.is_removed(s)) return false;
    emit(s);
    return true;
  }

  const Selected& selection_;
  BrickSamples<D> samples_;
  double rounding_;  ///< Of interpolated values.
  int n_fine_nodes_ = 0;
  std::array<std::array<std::size_t, as_size(D)>, as_size(kBrickLevel<D>) + 1> level_strides_{};
  std::array<std::size_t, as_size(kBrickLevel<D>) + 1> level_base_{};
};

}  // namespace lode::diamond
