#include "lode/models/diamond/side_box.h"

#include <array>
#include <cmath>

#include "lode/models/diamond/sample_rows.h"

namespace lode::diamond {
namespace {

/// The vertices of a star round its axis, in order, in steps of h from the centre.
struct Ring {
  std::array<Index<3>, 8> steps{};
  std::size_t n = 0;

  void add(const Index<3>& step) { steps[n++] = step; }
  /// The first end of the axis with one or two of its odd coordinates mirrored.
  void add_mirrored(Index<3> first, std::size_t i, std::size_t j) {
    first[i] = -first[i];
    if (j != i) first[j] = -first[j];
    add(first);
  }
};

Index<3> unit(std::size_t axis, std::int32_t sign) {
  Index<3> step;
  step[axis] = sign;
  return step;
}

/// `first` leads to one end of the axis.
Ring ring_round(const Index<3>& first) {
  Ring ring;
  std::array<std::size_t, 3> odd{};
  std::array<std::size_t, 3> even{};
  std::size_t n_odd = 0;
  std::size_t n_even = 0;
  for (std::size_t i = 0; i < 3; ++i) (first[i] != 0 ? odd[n_odd++] : even[n_even++]) = i;
  if (n_odd == 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      ring.add_mirrored(first, i, i);
      ring.add_mirrored(first, i, (i + 1) % 3);
    }
  } else if (n_odd == 2) {
    ring.add_mirrored(first, odd[0], odd[0]);
    ring.add(unit(even[0], 1));
    ring.add_mirrored(first, odd[1], odd[1]);
    ring.add(unit(even[0], -1));
  } else {
    const Index<3> u = unit(even[0], 1);
    const Index<3> v = unit(even[1], 1);
    for (const Index<3>& step : {u, u + v, v, v - u, u * -1, (u + v) * -1, v * -1, u - v})
      ring.add(step);
  }
  return ring;
}

/// By the first end's steps, in base 3.
const Ring& ring_of(const Index<3>& first) {
  static const auto kRings = [] {
    std::array<Ring, 27> rings;
    for (std::size_t i = 0; i < rings.size(); ++i) {
      const Index<3> step = point_of<3>(all_equal<3>(3), i) - all_equal<3>(1);
      if (step != Index<3>{}) rings[i] = ring_round(step);
    }
    return rings;
  }();
  return kRings[linear_index<3>(all_equal<3>(3), first + all_equal<3>(1))];
}

}  // namespace

void SideBox::open(const Index<3>& dims, const LatticeBox<3>& box) {
  dims_ = dims;
  box_ = box;
  size_ = box.upper - box.lower;
  sides_.resize(n_points<3>(size_));
}

template <typename Field>
void SideBox::fill_row(const Field& field, std::size_t row, std::int32_t step) {
  const auto n = as_size(size_[0]);
  const Index<3> first = box_.lower + point_of<3>(size_, row * n);
  see_samples(field, first * step, size_[0], step, [&](std::size_t x, double value, bool is_hole) {
    sides_[row * n + x] = is_hole ? hole : value >= isovalue_ ? inside : outside;
  });
}

void SideBox::set_sides(std::span<const float> values) {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const float value = values[i];
    sides_[i] = std::isnan(value) ? hole : std::signbit(value) ? outside : inside;
  }
}

void SideBox::find(int level, const LatticeBox<3>& centres, std::vector<Index<3>>& found) const {
  Index<3> first;
  Index<3> n;
  for (std::size_t i = 0; i < 3; ++i) {
    first[i] = ((centres.lower[i] - 1) >> level) + 1;
    n[i] = ((centres.upper[i] - 1) >> level) + 1 - first[i];
    if (n[i] <= 0) return;
  }
  for (std::int32_t z = 0; z < n[2]; ++z)
    for (std::int32_t y = 0; y < n[1]; ++y)
      find_in_row(level, first + Index<3>{{0, y, z}}, n[0], found);
}

/// Points of the level's grid. Most nodes are told by three samples.
void SideBox::find_in_row(int level, const Index<3>& row, std::int32_t n,
                          std::vector<Index<3>>& found) const {
  std::array<std::ptrdiff_t, 3> strides{};
  std::ptrdiff_t stride = std::ptrdiff_t{1} << level;
  for (std::size_t i = 0; i < 3; stride *= size_[i++]) strides[i] = stride;
  std::ptrdiff_t to_end = 0;  // from a node to an end of its axis, without the x part
  bool is_even = true;
  for (std::size_t i = 1; i < 3; ++i) {
    if ((row[i] & 1) == 0) continue;
    if (!has_ends(level, row, i)) return;
    is_even = false;
    to_end += (row[i] & 3) == 1 ? -strides[i] : strides[i];
  }
  Index<3> q = row;
  if (is_even) q[0] |= 1;
  for (; q[0] < row[0] + n; q[0] += is_even ? 2 : 1) {
    const bool is_odd = (q[0] & 1) != 0;
    if (is_odd && !has_ends(level, q, 0)) return;
    const std::ptrdiff_t x_part = !is_odd ? 0 : (q[0] & 3) == 1 ? -strides[0] : strides[0];
    const Index<3> p = q * (std::int32_t{1} << level);
    const std::uint8_t* const centre = at(p);
    const std::uint8_t end = centre[to_end + x_part];
    if (end == *centre || end != centre[-(to_end + x_part)]) continue;
    if (*centre != hole && end != hole && is_critical(diamond_at<3>(p))) found.push_back(p);
  }
}

/// Whether round the axis, whose ends lie on the other side than the centre, there is anything
/// but one arc of either side. At the data's border the ring is a path: then one change of
/// sides. Nodes with holes have infinite errors, and are refined for that.
bool SideBox::is_critical(const Diamond<3>& node) const {
  constexpr int kNone = -1;
  Index<3> first = axis_ends<3>(node)[0] - node.centre;
  for (std::size_t i = 0; i < 3; ++i) first[i] >>= node.level;
  const Ring& ring = ring_of(first);
  std::array<int, 8> sides{};
  bool is_closed = true;
  for (std::size_t i = 0; i < ring.n; ++i) {
    const Index<3> p = node.centre + ring.steps[i] * node.h();
    bool is_sample = true;
    for (std::size_t axis = 0; axis < 3; ++axis)
      is_sample = is_sample && p[axis] >= 0 && p[axis] < dims_[axis];
    sides[i] = is_sample ? *at(p) : kNone;
    if (sides[i] == hole) return false;
    is_closed = is_closed && is_sample;
  }
  int n_changes = 0;
  for (std::size_t i = 0; i < ring.n; ++i) {
    const int next = sides[(i + 1) % ring.n];
    n_changes += sides[i] != kNone && next != kNone && sides[i] != next ? 1 : 0;
  }
  return n_changes != (is_closed ? 2 : 1);
}

template void SideBox::fill_row(const Model<3>&, std::size_t, std::int32_t);
template void SideBox::fill_row(const CoarseField<3>&, std::size_t, std::int32_t);
template void SideBox::fill_row(const FlatField<3>&, std::size_t, std::int32_t);

}  // namespace lode::diamond
