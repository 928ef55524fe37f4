#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/models/diamond/error_code.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/pinch.h"

namespace lode::diamond {

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

/// The samples of one brick after another, and what they tell of simplices and of the nodes that
/// have no stored attributes: those of level 0 and tier >= 1.
template <int D>
class BrickSamples {
 public:
  explicit BrickSamples(const Model<D>& model) : model_(model), slack_(rounding_slack<D>(model)) {}

  void open(const Index<D>& brick) {
    brick_ = brick;
    base_ = brick * kBrickEdge<D>;
    samples_ = model_.brick(linear_index<D>(model_.brick_dims, brick));
    is_gathered_ = false;
    is_partial_ = false;
    is_near_end_ = false;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t last = model_.shape.dims[i] - 1;
      is_partial_ = is_partial_ || base_[i] + kBrickEdge<D> > last;
      // No node that is decided here reaches farther: centre edge / 2, reach three times that.
      is_near_end_ = is_near_end_ || base_[i] + 2 * kBrickEdge<D> > last;
    }
    is_near_hole_ = model_.has_holes() && has_hole_round(brick);
  }

  /// The brick's lower corner in the lattice.
  [[nodiscard]] const Index<D>& base() const { return base_; }

  /// The brick's samples, in the field's storage.
  [[nodiscard]] const std::byte* data() const { return samples_; }

  /// A point's lattice coordinates.
  [[nodiscard]] Index<D> global(std::uint32_t packed) const {
    Index<D> p = base_;
    for (int i = 0; i < D; ++i) p[as_size(i)] += BrickPoint::coordinate(packed, i);
    return p;
  }

  /// A point of the brick, given by its coordinates there, without its value.
  [[nodiscard]] BrickPoint point(const Index<D>& local) const {
    BrickPoint p;
    for (int i = 0; i < D; ++i) {
      const auto x = static_cast<std::uint32_t>(local[as_size(i)]);
      p.packed |= x << (BrickPoint::kBits * i);
      p.offset += x * kStride[as_size(i)];
    }
    return p;
  }

  /// The sample there; NaN for a hole.
  [[nodiscard]] double value(std::uint32_t offset) const {
    if (is_gathered_) return values_[offset];
    const double sample = visit_storage_type(model_.storage, [&]<typename T>() {
      return static_cast<double>(reinterpret_cast<const T*>(samples_)[offset]);
    });
    return is_near_hole_ && model_.is_hole(sample) ? std::numeric_limits<double>::quiet_NaN()
                                                   : sample;
  }

  /// Converts all samples at once, where so many are asked for that it pays.
  void gather() {
    values_.resize(kBrickSize<D>);
    gather_values<D>(model_, brick_, 0, values_.data());
    is_gathered_ = true;
  }

  /// Frees what gather() has taken.
  void forget() {
    if (is_gathered_) values_ = {};
    is_gathered_ = false;
  }

  /// The middle of an edge, without its value.
  [[nodiscard]] static BrickPoint between(const BrickPoint& a, const BrickPoint& b) {
    return {(a.packed + b.packed) >> 1U, (a.offset + b.offset) >> 1U, 0};
  }

  [[nodiscard]] bool overlaps_data(const BrickSimplex<D>& s) const {
    if (!is_partial_) return true;
    for (int i = 0; i < D; ++i) {
      std::int32_t lower = kBrickSamples<D>;
      for (const BrickPoint& corner : s.corner)
        lower = std::min(lower, BrickPoint::coordinate(corner.packed, i));
      if (base_[as_size(i)] + lower >= model_.shape.dims[as_size(i)] - 1) return false;
    }
    return true;
  }

  /// Whether all of a simplex lies in the data.
  [[nodiscard]] bool is_in_data(const BrickSimplex<D>& s) const {
    if (!is_partial_) return true;
    return std::all_of(s.corner.begin(), s.corner.end(), [this](const BrickPoint& corner) {
      return model_.shape.is_sample(global(corner.packed));
    });
  }

  /// Whether the node with this centre is to be refined whatever its error, since simplices of it
  /// or below it reach across the end of the data.
  [[nodiscard]] bool reaches_across(const BrickPoint& centre, int level) const {
    return is_near_end_ && model_.shape.reaches_across(global(centre.packed), level);
  }

  /// Whether holes take a simplex away whose corners are finite: that has a finite error, or is one
  /// of the finest.
  [[nodiscard]] bool is_removed(const BrickSimplex<D>& s) const {
    if (!is_near_hole_) return false;
    Simplex<D> simplex;
    for (std::size_t i = 0; i <= as_size(D); ++i) simplex.v[i] = global(s.corner[i].packed);
    const LatticeBox<D> box = bounds_of(simplex);
    return box.upper - box.lower == all_equal<D>(1) && model_.is_removed_cell(box.lower);
  }

  /// Whether holes leave two arcs of simplices round the edge between two corners of one.
  [[nodiscard]] bool is_pinched(const BrickPoint& a, const BrickPoint& b) const {
    if constexpr (D == 3)
      return is_near_hole_ && diamond::is_pinched(model_.shape, global(a.packed), global(b.packed),
                                                  [this](const Index<3>& cell) {
                                                    return model_.is_removed_cell(cell);
                                                  });
    return false;
  }

  /// Whether all samples of a simplex that is bisected at a node of level 0 and tier >= 1 (its
  /// vertices, m, and the middles of the edges that its halves are bisected at) are on one side, as
  /// selection.side(value) says.
  template <typename Sides>
  [[nodiscard]] bool is_on_one_side(const BrickSimplex<D>& s, int tag, const BrickPoint& m,
                                    const Sides& selection) const {
    const auto side = selection.side(m.value);
    for (const BrickPoint& corner : s.corner)
      if (selection.side(corner.value) != side) return false;
    for (std::size_t i = 0; tag > 1 && i < as_size(tag); ++i)
      if (selection.side(value(between(s.corner[i], s.corner[i + 1]).offset)) != side) return false;
    return true;
  }

  /// The nested error of a node of level 0 and tier >= 1, centre m, whose axis is the edge that s
  /// is bisected at: the largest midpoint error of itself and the finest nodes below it. s meets
  /// the data and the node does not reach across its end, so all its samples are there.
  [[nodiscard]] ErrorCode fine_error(const BrickSimplex<D>& s, int tag, const BrickPoint& m) const {
    const BrickPoint& a = s.corner[0];
    const BrickPoint& b = s.corner[as_size(tag)];
    if (is_near_hole_ && model_.is_mixed(global(m.packed))) return kInfiniteError;
    double e = or_zero(std::abs(m.value - 0.5 * (a.value + b.value)));
    if (tag == 1) return encode_error(float_up(e + slack_));
    for (int k = 0; k < D; ++k) {
      if (coordinate(a.packed, k) == coordinate(b.packed, k)) continue;
      int along = 0;  // the other axis of the face
      while (along == k || coordinate(a.packed, along) == coordinate(b.packed, along)) ++along;
      for (const bool is_up : {false, true}) {
        const std::uint32_t packed_step = 1U << (BrickPoint::kBits * k);
        const std::uint32_t packed = is_up ? m.packed + packed_step : m.packed - packed_step;
        if (is_near_hole_ && model_.is_mixed(global(packed))) return kInfiniteError;
        const std::uint32_t step = kStride[as_size(k)];
        const std::uint32_t at = is_up ? m.offset + step : m.offset - step;
        const std::uint32_t side = kStride[as_size(along)];
        const double mean = 0.5 * (value(at - side) + value(at + side));
        e = std::max(e, or_zero(std::abs(value(at) - mean)));
      }
    }
    return encode_error(float_up(e + slack_));
  }

 private:
  static constexpr std::array<std::uint32_t, 3> kStride{
      1, static_cast<std::uint32_t>(kBrickSamples<D>),
      static_cast<std::uint32_t>(kBrickSamples<D>* kBrickSamples<D>)};

  static constexpr std::int32_t coordinate(std::uint32_t packed, int axis) {
    return BrickPoint::coordinate(packed, axis);
  }

  [[nodiscard]] bool has_hole_round(const Index<D>& brick) const {
    for (int code = 0, n = D == 3 ? 27 : 9; code < n; ++code) {
      Index<D> b = brick;
      bool exists = true;
      for (int i = 0, rest = code; i < D; ++i, rest /= 3) {
        b[as_size(i)] += rest % 3 - 1;
        exists = exists && b[as_size(i)] >= 0 && b[as_size(i)] < model_.brick_dims[as_size(i)];
      }
      if (exists && model_.brick_holes[linear_index<D>(model_.brick_dims, b)] != 0) return true;
    }
    return false;
  }

  [[nodiscard]] static double or_zero(double error) { return std::isnan(error) ? 0 : error; }

  const Model<D>& model_;
  double slack_;
  Index<D> brick_, base_;
  const std::byte* samples_ = nullptr;  ///< The open brick's.
  std::vector<double> values_;          ///< The same as doubles, holes as NaN, when gathered.
  bool is_gathered_ = false;
  bool is_partial_ = false;
  bool is_near_end_ = false;
  bool is_near_hole_ = false;
};

}  // namespace lode::diamond
