#pragma once

// Cuts points, segments and convex polygons by the planes of the finest simplices.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "lode/core/vec.h"

namespace lode::diamond {

/// A point, a segment or a convex polygon, by its corners.
class Piece {
 public:
  // A triangle gains at most one corner by each of a cell's six planes. Cutting by the three
  // diagonal planes, rounding may make corners alternate between the sides: at most half as many
  // again each time, 9 -> 13 -> 20 -> 30.
  static constexpr std::size_t kMaxCorners = 32;

  // Neither the constructor nor copies touch corners that are not there: pieces are made by the
  // dozen for each triangle.
  Piece() {}
  explicit Piece(const std::array<Vec3d, 3>& triangle) : size_(3) {
    for (std::size_t i = 0; i < 3; ++i) corners_[i] = triangle[i].v;
  }
  Piece(const Piece& other) { *this = other; }
  Piece& operator=(const Piece& other) {
    size_ = other.size_;
    std::copy_n(other.corners_.begin(), size_, corners_.begin());
    return *this;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] Vec3d operator[](std::size_t i) const { return {corners_[i]}; }
  void clear() { size_ = 0; }
  void add(const Vec3d& corner) { corners_[size_++] = corner.v; }

 private:
  std::array<std::array<double, 3>, kMaxCorners> corners_;
  std::size_t size_ = 0;
};

/// Where a piece lies with respect to a plane; what lies in it is below.
enum class Sides : std::uint8_t { below, above, both };

/// The point of the segment a b where a value linear along it, value_a and value_b of opposite
/// signs at its ends, is zero. It stays inside the segment's box, so that coordinates of a convex
/// polygon's corners keep rising once and falling once.
[[nodiscard]] inline Vec3d zero_between(const Vec3d& a, double value_a, const Vec3d& b,
                                        double value_b) {
  const double t = value_a / (value_a - value_b);
  Vec3d p;
  for (std::size_t i = 0; i < 3; ++i)
    p[i] = std::clamp(a[i] + t * (b[i] - a[i]), std::min(a[i], b[i]), std::max(a[i], b[i]));
  return p;
}

/// Splits a piece that has parts on both sides of a plane, where value(corner) is zero, into `low`
/// and `high`; these stay as they are if it lies on one side. settle(p) may move a new corner
/// onto the plane.
template <typename Value, typename Settle>
[[nodiscard]] Sides split(const Piece& piece, Value value, Settle settle, Piece& low, Piece& high) {
  const std::size_t n = piece.size();
  std::array<double, Piece::kMaxCorners> values;
  bool has_low = false;
  bool has_high = false;
  for (std::size_t i = 0; i < n; ++i) {
    values[i] = value(piece[i]);
    has_low |= values[i] < 0;
    has_high |= values[i] > 0;
  }
  if (!has_low || !has_high) return has_high ? Sides::above : Sides::below;
  low.clear();
  high.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3d corner = piece[i];
    if (values[i] <= 0) low.add(corner);
    if (values[i] >= 0) high.add(corner);
    // A segment has one edge, not two.
    if (n == 2 && i == 1) break;
    const std::size_t next = i + 1 < n ? i + 1 : 0;
    if (!((values[i] < 0 && values[next] > 0) || (values[i] > 0 && values[next] < 0))) continue;
    Vec3d p = zero_between(corner, values[i], piece[next], values[next]);
    settle(p);
    low.add(p);
    high.add(p);
  }
  return Sides::both;
}

/// Calls visit(k, part) for the part of the piece in each layer k <= coordinate <= k + 1 of an
/// axis with n samples. The piece lies inside the lattice; an axis of one sample is one layer.
template <typename Visit>
void visit_layers(const Piece& piece, std::size_t axis, std::int32_t n, Visit visit) {
  double lowest = piece[0][axis];
  double highest = lowest;
  for (std::size_t i = 1; i < piece.size(); ++i) {
    lowest = std::min(lowest, piece[i][axis]);
    highest = std::max(highest, piece[i][axis]);
  }
  const std::int32_t last_layer = std::max(n - 2, 0);
  const auto first = std::min(static_cast<std::int32_t>(std::floor(lowest)), last_layer);
  const auto last =
      std::clamp(static_cast<std::int32_t>(std::ceil(highest)) - 1, first, last_layer);
  if (first == last) {
    visit(first, piece);
    return;
  }
  Piece rest = piece;
  Piece low;
  Piece high;
  for (std::int32_t k = first; k < last; ++k) {
    const double plane = static_cast<double>(k + 1);
    const Sides sides = split(
        rest, [&](const Vec3d& p) { return p[axis] - plane; }, [&](Vec3d& p) { p[axis] = plane; },
        low, high);
    if (sides == Sides::above) continue;
    visit(k, sides == Sides::both ? low : rest);
    if (sides == Sides::below) return;
    rest = high;
  }
  visit(last, rest);
}

/// Calls visit(cell, part) for the part of the piece in each unit cell, named by its lowest sample.
template <typename Visit>
void visit_cells(const Piece& piece, const Index3& dims, Visit visit) {
  visit_layers(piece, 0, dims[0], [&](std::int32_t x, const Piece& slab) {
    visit_layers(slab, 1, dims[1], [&](std::int32_t y, const Piece& bar) {
      visit_layers(bar, 2, dims[2], [&](std::int32_t z, const Piece& part) {
        visit(Index3{{x, y, z}}, part);
      });
    });
  });
}

/// Calls visit(part) for the part of the piece in each Kuhn simplex of the unit cube, the piece
/// being given in coordinates (u, v, w) from the corner all simplices' main diagonal starts at.
template <std::size_t Plane = 0, typename Visit>
void visit_kuhn_simplices(const Piece& piece, Visit visit) {
  constexpr std::array<std::array<std::size_t, 2>, 3> kPlanes = {{{0, 1}, {1, 2}, {2, 0}}};
  if constexpr (Plane == kPlanes.size()) {
    visit(piece);
  } else {
    constexpr std::size_t kFirst = kPlanes[Plane][0];
    constexpr std::size_t kSecond = kPlanes[Plane][1];
    Piece low;
    Piece high;
    const Sides sides = split(
        piece, [](const Vec3d& p) { return p[kFirst] - p[kSecond]; },
        [](Vec3d& p) { p[kSecond] = p[kFirst]; }, low, high);
    visit_kuhn_simplices<Plane + 1>(sides == Sides::both ? low : piece, visit);
    if (sides == Sides::both) visit_kuhn_simplices<Plane + 1>(high, visit);
  }
}

}  // namespace lode::diamond
