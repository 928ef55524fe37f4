#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

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

/// Calls emit(vertices, values) for each leaf simplex, inside one brick, of the cut of a selection
/// that the isosurface crosses. Level-0 nodes of tiers above 0 have no stored attributes: their
/// error comes from the samples, and their range is not asked (it could only stop the refinement of
/// simplices without surface).
/// Inside a brick a vertex is an offset into the brick's samples and three packed coordinates; both
/// are linear in the coordinates, so the middle of an edge is half the sum of its ends, and a
/// bisection costs one addition each.
template <int D>
class BrickTraversal {
 public:
  explicit BrickTraversal(const Selection<D>& selection) : selection_(selection) {
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
    const Model<D>& model = selection_.model();
    brick_ = brick;
    base_ = brick * kBrickEdge<D>;
    is_gathered_ = false;
    is_partial_ = false;
    for (std::size_t i = 0; i < as_size(D); ++i)
      is_partial_ = is_partial_ || base_[i] + kBrickEdge<D> > model.shape.dims[i] - 1;
    is_near_hole_ = model.has_holes() && has_hole_round(brick);
    for (int level = 0; level <= kBrickLevel<D>; ++level) {
      level_base_[as_size(level)] = 0;
      for (std::size_t i = 0; i < as_size(D); ++i)
        level_base_[as_size(level)] +=
            as_size(base_[i] >> shift_of(level)) * level_strides_[as_size(level)][i];
    }
  }

  /// `simplex` in global coordinates: one of the open brick's Kuhn simplices, or inside one.
  template <typename Emit>
  void visit(const Simplex<D>& simplex, TraversalStats& stats, const Emit& emit) {
    Local local;
    const Index<D> edge = simplex.v[0] - simplex.v[as_size(simplex.tag)];
    const int level = common_exponent<D>(edge) - 1;
    if (level >= 0 && (level > 0 || simplex.tag == D)) {
      // Most bricks end here: the samples are not touched before the node is known to be active.
      const Diamond<D> top = diamond_at<D>(simplex.bisection_point());
      if (!selection_.is_active(top.level, selection_.index_of(top))) {
        ++stats.nodes_visited;
        return;
      }
    }
    gather();
    for (std::size_t i = 0; i <= as_size(D); ++i) local[i] = corner_at(simplex.v[i] - base_);
    descend(local, simplex.tag, level, stats, emit);
  }

 private:
  static constexpr int kBits = 10;  ///< Of a packed coordinate: the sum of two is below 2^kBits.
  static constexpr std::uint32_t kMask = (1U << kBits) - 1;

  struct Corner {
    std::uint32_t packed = 0;
    std::uint32_t offset = 0;
    double value = 0;
  };
  using Local = std::array<Corner, as_size(D) + 1>;

  static constexpr std::array<std::uint32_t, 3> kStride{
      1, static_cast<std::uint32_t>(kBrickSamples<D>),
      static_cast<std::uint32_t>(kBrickSamples<D>* kBrickSamples<D>)};

  static constexpr int shift_of(int level) { return std::max(level, 1); }
  static constexpr std::uint32_t coordinate(std::uint32_t packed, int axis) {
    return (packed >> (kBits * axis)) & kMask;
  }

  [[nodiscard]] bool has_hole_round(const Index<D>& brick) const {
    const Model<D>& model = selection_.model();
    for (int code = 0, n = D == 3 ? 27 : 9; code < n; ++code) {
      Index<D> b = brick;
      bool exists = true;
      for (int i = 0, rest = code; i < D; ++i, rest /= 3) {
        b[as_size(i)] += rest % 3 - 1;
        exists = exists && b[as_size(i)] >= 0 && b[as_size(i)] < model.brick_dims[as_size(i)];
      }
      if (exists && model.brick_holes[linear_index<D>(model.brick_dims, b)] != 0) return true;
    }
    return false;
  }

  void gather() {
    if (is_gathered_) return;
    is_gathered_ = true;
    values_.resize(kBrickSize<D>);
    gather_values<D>(selection_.model(), brick_, 0, values_.data());
  }

  [[nodiscard]] Corner corner_at(const Index<D>& local) const {
    Corner corner;
    for (int i = 0; i < D; ++i) {
      const auto x = static_cast<std::uint32_t>(local[as_size(i)]);
      corner.packed |= x << (kBits * i);
      corner.offset += x * kStride[as_size(i)];
    }
    corner.value = values_[corner.offset];
    return corner;
  }

  [[nodiscard]] Corner middle(const Corner& a, const Corner& b) const {
    Corner m{(a.packed + b.packed) >> 1U, (a.offset + b.offset) >> 1U, 0};
    m.value = values_[m.offset];
    return m;
  }

  [[nodiscard]] Index<D> global(std::uint32_t packed) const {
    Index<D> p = base_;
    for (int i = 0; i < D; ++i) p[as_size(i)] += static_cast<std::int32_t>(coordinate(packed, i));
    return p;
  }

  [[nodiscard]] bool overlaps_data(const Local& s) const {
    const Shape<D>& shape = selection_.model().shape;
    for (int i = 0; i < D; ++i) {
      std::uint32_t lower = kMask;
      for (const Corner& corner : s) lower = std::min(lower, coordinate(corner.packed, i));
      if (base_[as_size(i)] + static_cast<std::int32_t>(lower) >= shape.dims[as_size(i)] - 1)
        return false;
    }
    return true;
  }

  [[nodiscard]] std::size_t node_index(int level, std::uint32_t packed) const {
    std::size_t at = level_base_[as_size(level)];
    for (int i = 0; i < D; ++i)
      at += std::size_t{coordinate(packed, i) >> shift_of(level)} *
            level_strides_[as_size(level)][as_size(i)];
    return at;
  }

  template <typename Emit>
  void descend(const Local& s, int tag, int level, TraversalStats& stats, const Emit& emit) {
    if (is_partial_ && !overlaps_data(s)) return;
    if (level < 0) {
      emit_leaf(s, tag, emit);
      return;
    }
    ++stats.nodes_visited;
    const Corner m = middle(s[0], s[as_size(tag)]);
    ErrorCode error = 0;
    if (level > 0 || tag == D) {
      const std::size_t at = node_index(level, m.packed);
      if (!selection_.is_active(level, at)) return;
      error = selection_.error(level, at);
    } else {
      if (is_on_one_side(s, tag, m)) return;
      if (!selection_.is_full()) error = fine_error(s, tag, m);
    }
    if (!selection_.exceeds_tolerance(error)) {
      if (emit_leaf(s, tag, emit)) stats.achieved = std::max(stats.achieved, error);
      return;
    }
    const int next_tag = tag > 1 ? tag - 1 : D;
    const int next_level = tag > 1 ? level : level - 1;
    Local half = s;
    half[as_size(tag)] = m;
    descend(half, next_tag, next_level, stats, emit);
    for (std::size_t i = 0; i < as_size(tag); ++i) half[i] = s[i + 1];
    descend(half, next_tag, next_level, stats, emit);
  }

  /// Whether all samples of a simplex that is bisected at a node of level 0 and tier >= 1 (its
  /// vertices, m, and the middles of the edges that its halves are bisected at) have one sign.
  [[nodiscard]] bool is_on_one_side(const Local& s, int tag, const Corner& m) const {
    const double isovalue = selection_.isovalue();
    const bool side = m.value >= isovalue;
    for (const Corner& corner : s)
      if ((corner.value >= isovalue) != side) return false;
    for (std::size_t i = 0; tag > 1 && i < as_size(tag); ++i)
      if ((middle(s[i], s[i + 1]).value >= isovalue) != side) return false;
    return true;
  }

  [[nodiscard]] bool is_sample(std::uint32_t packed) const {
    return !is_partial_ || selection_.model().shape.is_sample(global(packed));
  }

  [[nodiscard]] static double or_zero(double error) { return std::isnan(error) ? 0 : error; }

  /// The nested error of a node of level 0 and tier >= 1, centre m, whose axis is the edge that s
  /// is bisected at: the largest midpoint error of itself and the finest nodes below it.
  [[nodiscard]] ErrorCode fine_error(const Local& s, int tag, const Corner& m) const {
    const Corner& a = s[0];
    const Corner& b = s[as_size(tag)];
    if (is_near_hole_ && selection_.model().is_mixed(global(m.packed))) return kInfiniteError;
    double e = is_sample(m.packed) ? or_zero(std::abs(m.value - 0.5 * (a.value + b.value))) : 0;
    if (tag == 1) return encode_error(float_up(e));
    for (int k = 0; k < D; ++k) {
      if (coordinate(a.packed, k) == coordinate(b.packed, k)) continue;
      int along = 0;  // the other axis of the face
      while (along == k || coordinate(a.packed, along) == coordinate(b.packed, along)) ++along;
      for (const bool is_up : {false, true}) {
        const std::uint32_t packed_step = 1U << (kBits * k);
        const std::uint32_t packed = is_up ? m.packed + packed_step : m.packed - packed_step;
        if (is_near_hole_ && selection_.model().is_mixed(global(packed))) return kInfiniteError;
        if (!is_sample(packed)) continue;
        const std::uint32_t step = kStride[as_size(k)];
        const double* v = values_.data() + (is_up ? m.offset + step : m.offset - step);
        const std::uint32_t side = kStride[as_size(along)];
        e = std::max(e, or_zero(std::abs(*v - 0.5 * (*(v - side) + *(v + side)))));
      }
    }
    return encode_error(float_up(e));
  }

  template <typename Emit>
  bool emit_leaf(const Local& s, int tag, const Emit& emit) {
    int n_inside = 0;
    for (const Corner& corner : s) {
      if (std::isnan(corner.value)) return false;
      n_inside += corner.value >= selection_.isovalue() ? 1 : 0;
    }
    if (n_inside == 0 || n_inside == D + 1) return false;
    Simplex<D> simplex;
    simplex.tag = tag;
    std::array<double, as_size(D) + 1> values;
    for (std::size_t i = 0; i <= as_size(D); ++i) {
      simplex.v[i] = global(s[i].packed);
      values[i] = s[i].value;
    }
    if (is_near_hole_ && selection_.model().is_removed(simplex)) return false;
    emit(simplex.v, values);
    return true;
  }

  const Selection<D>& selection_;
  Index<D> brick_, base_;
  std::array<std::array<std::size_t, as_size(D)>, as_size(kBrickLevel<D>) + 1> level_strides_{};
  std::array<std::size_t, as_size(kBrickLevel<D>) + 1> level_base_{};
  std::vector<double> values_;
  bool is_gathered_ = false;
  bool is_partial_ = false;
  bool is_near_hole_ = false;
};

}  // namespace lode::diamond
