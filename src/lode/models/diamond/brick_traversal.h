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

/// A lattice point of a brick: its coordinates, packed, and its offset among the brick's samples.
/// Both are linear in the coordinates, so the middle of an edge is half the sum of its ends, and a
/// bisection costs one addition each.
struct BrickPoint {
  static constexpr int kBits = 10;  ///< Of a packed coordinate: the sum of two is below 2^kBits.
  static constexpr std::uint32_t kMask = (1U << kBits) - 1;

  std::uint32_t packed = 0;
  std::uint32_t offset = 0;
  double value = 0;  ///< Of the field; NaN for a hole.

  [[nodiscard]] static constexpr std::int32_t coordinate(std::uint32_t packed, int axis) {
    return static_cast<std::int32_t>((packed >> (kBits * axis)) & kMask);
  }
};

/// A simplex inside a brick.
template <int D>
struct BrickSimplex {
  std::array<BrickPoint, as_size(D) + 1> corner;
  bool is_positive = true;  ///< Orientation of the corners in lattice coordinates.
};

/// Calls emit(BrickSimplex) for each leaf simplex, inside one brick, of the cut of a selection that
/// the isosurface crosses. Level-0 nodes of tiers above 0 have no stored attributes: their error
/// comes from the samples, and their range is not asked (it could only stop the refinement of
/// simplices without surface).
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
    n_fine_nodes_ = 0;
    samples_ = model.brick(linear_index<D>(model.brick_dims, brick));
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
    const Index<D> edge = simplex.v[0] - simplex.v[as_size(simplex.tag)];
    const int level = common_exponent<D>(edge) - 1;
    Local local;
    for (std::size_t i = 0; i <= as_size(D); ++i) local.corner[i] = corner_at(simplex.v[i] - base_);
    local.is_positive = is_positive(simplex);
    if (is_partial_ && !overlaps_data(local)) return;
    const Corner& a = local.corner[0];
    const Corner& b = local.corner[as_size(simplex.tag)];
    std::size_t at = 0;
    if (!enters(level, simplex.tag, a, b, at, stats)) return;
    for (Corner& corner : local.corner) corner.value = sample_at(corner.offset);
    descend(local, simplex.tag, level, at, stats, emit);
  }

  /// A corner's lattice coordinates.
  [[nodiscard]] Index<D> global(std::uint32_t packed) const {
    Index<D> p = base_;
    for (int i = 0; i < D; ++i) p[as_size(i)] += coordinate(packed, i);
    return p;
  }

 private:
  static constexpr int kBits = BrickPoint::kBits;
  using Corner = BrickPoint;
  using Local = BrickSimplex<D>;

  static constexpr std::array<std::uint32_t, 3> kStride{
      1, static_cast<std::uint32_t>(kBrickSamples<D>),
      static_cast<std::uint32_t>(kBrickSamples<D>* kBrickSamples<D>)};

  static constexpr int kManyFineNodes = 2000;

  static constexpr int shift_of(int level) { return std::max(level, 1); }
  static constexpr std::int32_t coordinate(std::uint32_t packed, int axis) {
    return BrickPoint::coordinate(packed, axis);
  }

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

  /// The brick's sample there; NaN for a hole. Converted one by one, until it pays to convert all.
  [[nodiscard]] double sample_at(std::uint32_t offset) const {
    if (is_gathered_) return values_[offset];
    const double sample = visit_storage_type(selection_.model().storage, [&]<typename T>() {
      return static_cast<double>(reinterpret_cast<const T*>(samples_)[offset]);
    });
    return is_near_hole_ && selection_.model().is_hole(sample)
               ? std::numeric_limits<double>::quiet_NaN()
               : sample;
  }

  void count_fine_node() {
    if (++n_fine_nodes_ != kManyFineNodes) return;
    values_.resize(kBrickSize<D>);
    gather_values<D>(selection_.model(), brick_, 0, values_.data());
    is_gathered_ = true;
  }

  /// Without its value: samples are not touched before a node is known to be active.
  [[nodiscard]] Corner corner_at(const Index<D>& local) const {
    Corner corner;
    for (int i = 0; i < D; ++i) {
      const auto x = static_cast<std::uint32_t>(local[as_size(i)]);
      corner.packed |= x << (kBits * i);
      corner.offset += x * kStride[as_size(i)];
    }
    return corner;
  }

  [[nodiscard]] Corner middle(const Corner& a, const Corner& b) const {
    Corner m{(a.packed + b.packed) >> 1U, (a.offset + b.offset) >> 1U, 0};
    m.value = sample_at(m.offset);
    return m;
  }

  [[nodiscard]] bool overlaps_data(const Local& s) const {
    const Shape<D>& shape = selection_.model().shape;
    for (int i = 0; i < D; ++i) {
      std::int32_t lower = kBrickSamples<D>;
      for (const Corner& corner : s.corner) lower = std::min(lower, coordinate(corner.packed, i));
      if (base_[as_size(i)] + lower >= shape.dims[as_size(i)] - 1) return false;
    }
    return true;
  }

  [[nodiscard]] std::size_t node_index(int level, std::uint32_t packed) const {
    std::size_t at = level_base_[as_size(level)];
    for (int i = 0; i < D; ++i)
      at += as_size(coordinate(packed, i) >> shift_of(level)) *
            level_strides_[as_size(level)][as_size(i)];
    return at;
  }

  /// Whether a simplex with bisected edge a – b has to be looked at. Where attributes are stored,
  /// the node's range tells, before anything else of the simplex is known; `at` is their place.
  bool enters(int level, int tag, const Corner& a, const Corner& b, std::size_t& at,
              TraversalStats& stats) const {
    if (level < 0) return true;
    ++stats.nodes_visited;
    if (level == 0 && tag < D) return true;
    at = node_index(level, (a.packed + b.packed) >> 1U);
    return selection_.is_active(level, at);
  }

  template <typename Emit>
  void descend(const Local& s, int tag, int level, std::size_t at, TraversalStats& stats,
               const Emit& emit) {
    if (level < 0) {
      emit_leaf(s, tag, emit);
      return;
    }
    const Corner m = middle(s.corner[0], s.corner[as_size(tag)]);
    ErrorCode error = 0;
    if (level > 0 || tag == D) {
      error = selection_.error(level, at);
    } else {
      count_fine_node();
      if (is_on_one_side(s, tag, m)) return;
      if (!selection_.is_full()) error = fine_error(s, tag, m);
    }
    if (!selection_.exceeds_tolerance(error)) {
      if (emit_leaf(s, tag, emit)) stats.achieved = std::max(stats.achieved, error);
      return;
    }
    const int next_tag = tag > 1 ? tag - 1 : D;
    const int next_level = tag > 1 ? level : level - 1;
    const Corner& end = s.corner[as_size(tag > 1 ? tag - 1 : D)];
    if (is_partial_ || enters(next_level, next_tag, s.corner[0], end, at, stats)) {
      Local half = s;
      half.corner[as_size(tag)] = m;
      descend_half(half, next_tag, next_level, at, stats, emit);
    }
    const Corner& other_end = s.corner[as_size(tag > 1 ? tag : D)];
    if (is_partial_ || enters(next_level, next_tag, s.corner[1], other_end, at, stats)) {
      // The middle takes the place of corner 0, then moves behind `tag` others.
      Local half = s;
      for (std::size_t i = 0; i < as_size(tag); ++i) half.corner[i] = s.corner[i + 1];
      half.corner[as_size(tag)] = m;
      half.is_positive = s.is_positive != ((tag & 1) != 0);
      descend_half(half, next_tag, next_level, at, stats, emit);
    }
  }

  /// In a brick that reaches beyond the data, nodes are not looked up before the simplex is known
  /// to meet it.
  template <typename Emit>
  void descend_half(const Local& s, int tag, int level, std::size_t at, TraversalStats& stats,
                    const Emit& emit) {
    if (is_partial_ &&
        (!overlaps_data(s) || !enters(level, tag, s.corner[0], s.corner[as_size(tag)], at, stats)))
      return;
    descend(s, tag, level, at, stats, emit);
  }

  /// Whether all samples of a simplex that is bisected at a node of level 0 and tier >= 1 (its
  /// vertices, m, and the middles of the edges that its halves are bisected at) have one sign.
  [[nodiscard]] bool is_on_one_side(const Local& s, int tag, const Corner& m) const {
    const double isovalue = selection_.isovalue();
    const bool side = m.value >= isovalue;
    for (const Corner& corner : s.corner)
      if ((corner.value >= isovalue) != side) return false;
    for (std::size_t i = 0; tag > 1 && i < as_size(tag); ++i)
      if ((middle(s.corner[i], s.corner[i + 1]).value >= isovalue) != side) return false;
    return true;
  }

  [[nodiscard]] bool is_sample(std::uint32_t packed) const {
    return !is_partial_ || selection_.model().shape.is_sample(global(packed));
  }

  [[nodiscard]] static double or_zero(double error) { return std::isnan(error) ? 0 : error; }

  /// The nested error of a node of level 0 and tier >= 1, centre m, whose axis is the edge that s
  /// is bisected at: the largest midpoint error of itself and the finest nodes below it.
  [[nodiscard]] ErrorCode fine_error(const Local& s, int tag, const Corner& m) const {
    const Corner& a = s.corner[0];
    const Corner& b = s.corner[as_size(tag)];
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
        const std::uint32_t at = is_up ? m.offset + step : m.offset - step;
        const std::uint32_t side = kStride[as_size(along)];
        const double mean = 0.5 * (sample_at(at - side) + sample_at(at + side));
        e = std::max(e, or_zero(std::abs(sample_at(at) - mean)));
      }
    }
    return encode_error(float_up(e));
  }

  template <typename Emit>
  bool emit_leaf(const Local& s, int tag, const Emit& emit) {
    int n_inside = 0;
    for (const Corner& corner : s.corner) {
      if (std::isnan(corner.value)) return false;
      n_inside += corner.value >= selection_.isovalue() ? 1 : 0;
    }
    if (n_inside == 0 || n_inside == D + 1) return false;
    if (is_near_hole_) {
      Simplex<D> simplex;
      simplex.tag = tag;
      for (std::size_t i = 0; i <= as_size(D); ++i) simplex.v[i] = global(s.corner[i].packed);
      if (selection_.model().is_removed(simplex)) return false;
    }
    emit(s);
    return true;
  }

  const Selection<D>& selection_;
  Index<D> brick_, base_;
  const std::byte* samples_ = nullptr;  ///< The open brick's.
  std::vector<double> values_;          ///< The same as doubles, holes as NaN, when gathered.
  bool is_gathered_ = false;
  int n_fine_nodes_ = 0;
  std::array<std::array<std::size_t, as_size(D)>, as_size(kBrickLevel<D>) + 1> level_strides_{};
  std::array<std::size_t, as_size(kBrickLevel<D>) + 1> level_base_{};
  bool is_partial_ = false;
  bool is_near_hole_ = false;
};

}  // namespace lode::diamond
