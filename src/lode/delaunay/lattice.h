#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "lode/core/lattice_point.h"

namespace lode::delaunay {

using lode::LatticePoint;

/// Of a triangle.
using LatticeCorners = std::array<LatticePoint, 3>;

/// The nodes of some columns and rows.
struct LatticePart {
  LatticePoint first;
  LatticePoint last;
};

/// Nodes of a lattice in 32 bits each, ordered as they lie in rows.
class LatticePacking {
 public:
  /// Whether the nodes of a lattice fit: the bits of a column and of a row, together.
  [[nodiscard]] static bool fits(std::int64_t n_columns, std::int64_t n_rows) {
    const auto bits = [](std::int64_t n) {
      return static_cast<int>(std::bit_width(static_cast<std::uint64_t>(n - 1)));
    };
    return bits(n_columns) + bits(n_rows) <= 32 && n_columns <= kMaxSide && n_rows <= kMaxSide;
  }
  /// What float32 counts exactly.
  static constexpr std::int64_t kMaxSide = std::int64_t{1} << 24;

  explicit LatticePacking(std::int32_t n_columns)
      : shift_(static_cast<int>(std::bit_width(static_cast<std::uint32_t>(n_columns - 1)))) {}

  [[nodiscard]] std::uint32_t pack(LatticePoint p) const {
    return (static_cast<std::uint32_t>(p.y) << shift_) | static_cast<std::uint32_t>(p.x);
  }
  [[nodiscard]] LatticePoint unpack(std::uint32_t packed) const {
    return {static_cast<std::int32_t>(packed & ((std::uint32_t{1} << shift_) - 1)),
            static_cast<std::int32_t>(packed >> shift_)};
  }

 private:
  int shift_;
};

/// Nodes by their numbers in a list, which outlives this.
class ListedNodes {
 public:
  explicit ListedNodes(std::span<const LatticePoint> nodes) : nodes_(nodes) {}

  [[nodiscard]] LatticePoint unpack(std::uint32_t number) const { return nodes_[number]; }

 private:
  std::span<const LatticePoint> nodes_;
};

/// Twice the area of a, b, c: positive when they turn left (x to the right, y up). Exactly, for
/// coordinates of at most 30 bits.
[[nodiscard]] inline std::int64_t doubled_area(LatticePoint a, LatticePoint b, LatticePoint c) {
  return std::int64_t{b.x - a.x} * (c.y - a.y) - std::int64_t{b.y - a.y} * (c.x - a.x);
}

/// The determinant that is positive when p lies inside the circle of a, b, c, which turn left; all
/// relative to p. `Wide` has to hold 3 · 2^(4 n + 2) for differences of n bits.
template <typename Wide>
[[nodiscard]] Wide circle_determinant(LatticePoint a, LatticePoint b, LatticePoint c) {
  const auto lifted = [](LatticePoint p) {
    return std::int64_t{p.x} * p.x + std::int64_t{p.y} * p.y;
  };
  const auto crossed = [](LatticePoint p, LatticePoint q) {
    return std::int64_t{p.x} * q.y - std::int64_t{p.y} * q.x;
  };
  return static_cast<Wide>(lifted(a)) * crossed(b, c) +
         static_cast<Wide>(lifted(b)) * crossed(c, a) +
         static_cast<Wide>(lifted(c)) * crossed(a, b);
}

/// Below it lifts and cross products stay below 2^29, their products below 2^58.
inline constexpr std::int32_t kNarrowLattice = 1 << 14;

/// Whether the origin lies inside the circle of a, b, c, which turn left, and not on it: exactly,
/// for coordinates of at most 31 bits; kIsNarrow: that are all below kNarrowLattice.
template <bool kIsNarrow>
[[nodiscard]] bool is_origin_in_circle(LatticePoint a, LatticePoint b, LatticePoint c) {
  __extension__ using Int128 = __int128;
  if constexpr (kIsNarrow) return circle_determinant<std::int64_t>(a, b, c) > 0;
  const auto size = [](std::int32_t d) { return static_cast<std::uint32_t>(std::abs(d)); };
  const std::uint32_t all = size(a.x) | size(a.y) | size(b.x) | size(b.y) | size(c.x) | size(c.y);
  if (all < kNarrowLattice) return circle_determinant<std::int64_t>(a, b, c) > 0;
  return circle_determinant<Int128>(a, b, c) > 0;
}

/// The same of p, for coordinates of at most 30 bits.
[[nodiscard]] inline bool is_in_circle(LatticePoint a, LatticePoint b, LatticePoint c,
                                       LatticePoint p) {
  const auto relative = [p](LatticePoint q) { return LatticePoint{q.x - p.x, q.y - p.y}; };
  return is_origin_in_circle<false>(relative(a), relative(b), relative(c));
}

}  // namespace lode::delaunay
