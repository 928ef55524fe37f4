#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/diamond/side_box.h"

namespace lode::diamond {

/// A field that is *relaxed* within a persistence P of an isovalue c: only on which side of c it is
/// counts. A node that a cut does not refine has the mean of its axis' ends, as the cut
/// interpolates, where its sample may be on the mean's side: inside from c - P on, outside below
/// c + P. Other nodes, and those that the cut refines, keep their samples. So the sides are those
/// of a field within P of the samples. docs/models/diamond3d.md, "The topology kept".
///
/// Here: what it is above the isovalue at the samples of a box of a lattice, a field's or every
/// 2^k-th point of it an axis. A negative zero is outside; NaN: a hole.
class RelaxedBox {
 public:
  /// `is_finest`: of a lattice that has all of a field's samples.
  RelaxedBox(double isovalue, double persistence, bool is_finest)
      : sides_(isovalue),
        is_finest_(is_finest),
        isovalue_(isovalue),
        least_inside_(isovalue - persistence),
        least_fixed_inside_(isovalue + persistence) {}

  /// As SideBox's.
  void open(const Index<3>& dims, const LatticeBox<3>& box);
  [[nodiscard]] std::size_t n_rows() const { return sides_.n_rows(); }
  /// The samples themselves.
  template <typename Field>
  void fill_row(const Field& field, std::size_t row, std::int32_t step);

  /// The nodes of n levels, coarse ones first. The box begins and ends at multiples of 2^(n - 1),
  /// or where the lattice does. coarser(p): the relaxed value of a point whose coordinates are all
  /// multiples of 2^n; is_refined(p): whether the cut refines the node, as far
  /// as that is known.
  template <typename Coarser, typename IsRefined>
  void relax(int n_levels, const Coarser& coarser, const IsRefined& is_refined);

  [[nodiscard]] bool contains(const Index<3>& p) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (p[i] < sides_.box().lower[i] || p[i] >= sides_.box().upper[i]) return false;
    return true;
  }
  [[nodiscard]] float value(const Index<3>& p) const { return values_[index_of(p)]; }
  /// Of a point and those behind it along x, as far as the box goes.
  [[nodiscard]] const float* values_from(const Index<3>& p) const {
    return values_.data() + index_of(p);
  }
  /// Likewise: which sides they may be on.
  [[nodiscard]] const std::uint8_t* marks_from(const Index<3>& p) const {
    return marks_.data() + index_of(p);
  }
  /// Whether a sample with this mark can be on one side alone.
  [[nodiscard]] static bool is_fixed(std::uint8_t mark) {
    return mark != (kMayBeInside | kMayBeOutside);
  }
  /// Nodes that are not on their samples' side.
  [[nodiscard]] const std::vector<Index<3>>& turned() const { return turned_; }
  /// Of the relaxed field.
  [[nodiscard]] const SideBox& sides() const { return sides_; }

 private:
  static constexpr std::uint8_t kMayBeInside = 1;
  static constexpr std::uint8_t kMayBeOutside = 2;

  template <typename T>
  void set_row(std::span<const T> samples, std::size_t at);
  /// A node, whose axis' ends have this mean.
  template <typename IsRefined>
  void relax_node(const Index<3>& p, std::size_t at, float mean, const IsRefined& is_refined);
  /// Nothing is between nodes of the finest level: where they do not turn, what they are on their
  /// side is not asked again.
  [[nodiscard]] bool is_asked(int level, float own, float mean) const {
    return level > 0 || !is_finest_ || std::signbit(mean) != std::signbit(own);
  }
  template <typename ValueAt, typename IsRefined>
  void relax_coarsest(int level, const ValueAt& value_at, const IsRefined& is_refined);
  template <typename IsRefined>
  void relax_level(int level, const IsRefined& is_refined);
  template <typename IsRefined>
  void relax_row(int level, const Index<3>& row, const IsRefined& is_refined);
  [[nodiscard]] bool has_ends(int level, std::int32_t x, std::size_t axis) const {
    return ((x >> level) & 1) == 0 || x + (std::int32_t{1} << level) < sides_.dims()[axis];
  }
  /// The first multiple of a step in the box.
  [[nodiscard]] std::int32_t first_of(std::int32_t step, std::size_t axis) const {
    return (sides_.box().lower[axis] + step - 1) / step * step;
  }
  [[nodiscard]] std::size_t index_of(const Index<3>& p) const {
    return linear_index<3>(size_, p - sides_.box().lower);
  }

  SideBox sides_;
  bool is_finest_;
  double isovalue_;
  double least_inside_;        ///< c - P,
  double least_fixed_inside_;  ///< and c + P.
  Index<3> size_;
  std::vector<float> values_;        ///< x fastest,
  std::vector<std::uint8_t> marks_;  ///< and which sides they may be on.
  std::vector<Index<3>> turned_;
};

template <typename Coarser, typename IsRefined>
void RelaxedBox::relax(int n_levels, const Coarser& coarser, const IsRefined& is_refined) {
  turned_.clear();
  const LatticeBox<3>& box = sides_.box();
  const std::int32_t step = std::int32_t{1} << n_levels;
  for (std::int32_t z = first_of(step, 2); z < box.upper[2]; z += step)
    for (std::int32_t y = first_of(step, 1); y < box.upper[1]; y += step)
      for (std::int32_t x = first_of(step, 0); x < box.upper[0]; x += step)
        values_[index_of({{x, y, z}})] = coarser(Index<3>{{x, y, z}});
  const auto value_at = [&](const Index<3>& p) { return contains(p) ? value(p) : coarser(p); };
  if (n_levels > 0) relax_coarsest(n_levels - 1, value_at, is_refined);
  for (int level = n_levels - 2; level >= 0; --level) relax_level(level, is_refined);
  sides_.set_sides(values_);
}

template <typename IsRefined>
void RelaxedBox::relax_node(const Index<3>& p, std::size_t at, float mean,
                            const IsRefined& is_refined) {
  float& own = values_[at];
  const bool is_turned = std::signbit(mean) != std::signbit(own);
  const std::uint8_t may_be = std::signbit(mean) ? kMayBeOutside : kMayBeInside;
  if (is_turned && (marks_[at] & may_be) == 0) return;
  if (std::isnan(mean) || std::isnan(own) || is_refined(p)) return;
  own = mean;
  if (is_turned) turned_.push_back(p);
}

/// Their axes may leave the box.
template <typename ValueAt, typename IsRefined>
void RelaxedBox::relax_coarsest(int level, const ValueAt& value_at, const IsRefined& is_refined) {
  const LatticeBox<3>& box = sides_.box();
  const std::int32_t h = std::int32_t{1} << level;
  for (std::int32_t z = first_of(h, 2); z < box.upper[2]; z += h)
    for (std::int32_t y = first_of(h, 1); y < box.upper[1]; y += h)
      for (std::int32_t x = first_of(h, 0); x < box.upper[0]; x += h) {
        const Index<3> p{{x, y, z}};
        if (((x | y | z) & h) == 0 || !has_ends(level, x, 0) || !has_ends(level, y, 1) ||
            !has_ends(level, z, 2))
          continue;
        const auto ends = axis_ends<3>(diamond_at<3>(p));
        const float mean = 0.5F * (value_at(ends[0]) + value_at(ends[1]));
        if (is_asked(level, value(p), mean)) relax_node(p, index_of(p), mean, is_refined);
      }
}

template <typename IsRefined>
void RelaxedBox::relax_level(int level, const IsRefined& is_refined) {
  const LatticeBox<3>& box = sides_.box();
  const std::int32_t h = std::int32_t{1} << level;
  for (std::int32_t z = first_of(h, 2); z < box.upper[2]; z += h)
    for (std::int32_t y = first_of(h, 1); y < box.upper[1]; y += h)
      if (has_ends(level, y, 1) && has_ends(level, z, 2))
        relax_row(level, {{first_of(h, 0), y, z}}, is_refined);
}

/// Along a row the two steps to the ends of an axis are the same for every second even node, and
/// for every fourth odd one.
template <typename IsRefined>
void RelaxedBox::relax_row(int level, const Index<3>& row, const IsRefined& is_refined) {
  const std::int32_t h = std::int32_t{1} << level;
  std::ptrdiff_t to_end = 0;  // without the x part
  std::ptrdiff_t stride = h;
  for (std::size_t i = 1; i < 3; ++i) {
    stride *= size_[i - 1];
    if ((row[i] & h) != 0) to_end += ((row[i] >> level) & 3) == 1 ? -stride : stride;
  }
  const auto relax_every = [&](std::int32_t step, std::int32_t remainder, std::ptrdiff_t end) {
    const std::int32_t skipped = ((remainder - row[0]) % step + step) % step;
    const float* own = values_.data() + index_of(row) + skipped;
    const bool is_odd = (remainder & h) != 0;
    const std::int32_t n = std::min(sides_.box().upper[0], sides_.dims()[0] - (is_odd ? h : 0));
    for (std::int32_t x = row[0] + skipped; x < n; x += step, own += step) {
      const float mean = 0.5F * (own[end] + own[-end]);
      if (is_asked(level, *own, mean))
        relax_node({{x, row[1], row[2]}}, static_cast<std::size_t>(own - values_.data()), mean,
                   is_refined);
    }
  };
  if (((row[1] | row[2]) & h) != 0) relax_every(2 * h, 0, to_end);
  relax_every(4 * h, h, to_end - h);
  relax_every(4 * h, 3 * h, to_end + h);
}

}  // namespace lode::diamond
