#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Cells per edge of the cubes whose errors are computed together, one per SIMD lane.
template <int D>
inline constexpr std::int32_t kPlanEdge = D == 3 ? 16 : 32;
/// Cubes computed side by side.
inline constexpr std::size_t kLanes = 8;
/// Lattice points of such a cube.
template <int D>
inline constexpr std::size_t kPlanPoints = D == 3 ? 17 * 17 * 17 : 33 * 33;
/// Cubes per brick.
template <int D>
inline constexpr int kPlansPerBrick = D == 3 ? 8 : 16;

/// One interpolant F' on a cube, spelled out: which points are its vertices, how every other
/// point's value is the mean of two earlier ones (F' is linear along each diamond's axis), and
/// for which node each point counts. Points are given as places in arrays of kLanes values a point.
struct InterpolantPass {
  struct Mean {
    std::uint16_t to, first, second;
  };
  struct Region {
    std::uint32_t node = 0;   ///< Its centre, as a number among the cube's points.
    std::uint32_t begin = 0;  ///< Its points, as a range of `points`.
    std::uint32_t end = 0;
  };
  std::vector<std::uint16_t> vertices;
  std::vector<Mean> means;  ///< In order of evaluation.
  std::vector<Region> regions;
  std::vector<std::uint16_t> points;
};

/// The points of a cube's Kuhn simplex in rows. A coarser interpolant is linear there.
template <int D>
struct KuhnSimplex {
  struct Row {
    std::uint16_t first, n;                   ///< Place of the first point; how many.
    std::array<std::uint16_t, as_size(D)> u;  ///< Steps to the first point along each chain edge.
  };
  Simplex<D> simplex;                                ///< In canonical coordinates.
  std::array<std::uint16_t, as_size(D) + 1> corner;  ///< Bit i: at the far end of axis i.
  std::uint16_t step = 0;                            ///< Between points of a row, along edge 0.
  std::vector<Row> rows;
};

/// Everything needed to find the own errors of all nodes of sides 4 .. kPlanEdge inside a cube of
/// side kPlanEdge, and the error of any coarser interpolant on its Kuhn simplices. All numbers are
/// of the (kPlanEdge+1)^D points of the cube in canonical coordinates: the corner ≡ 0 mod
/// 2·kPlanEdge at the origin, mirrored so that all coordinates grow from it.
template <int D>
struct CubePlan {
  struct NodePass {
    int level = 0;
    InterpolantPass pass;
  };
  std::vector<NodePass> node_passes;  ///< Per sub-cube and tier; regions are nodes.
  std::vector<KuhnSimplex<D>> kuhn;

  [[nodiscard]] static const CubePlan& instance();
};

extern template struct CubePlan<2>;
extern template struct CubePlan<3>;

/// A cube of the hierarchy with its canonical coordinates: the corner ≡ 0 mod 2·side at the
/// origin, mirrored so that all coordinates grow from it.
template <int D>
struct CanonicalCube {
  std::int32_t side = 0;
  Index<D> even_corner;
  Index<D> sign;

  CanonicalCube() = default;
  friend bool operator==(const CanonicalCube&, const CanonicalCube&) = default;

  /// The cube of this side that contains the unit cell with lowest corner `cell`.
  CanonicalCube(const Index<D>& cell, std::int32_t cube_side) : side(cube_side) {
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t number = cell[i] / side;
      sign[i] = (number & 1) != 0 ? -1 : 1;
      even_corner[i] = (number + (number & 1)) * side;
    }
  }
  [[nodiscard]] Index<D> lowest_corner() const {
    Index<D> p = even_corner;
    for (std::size_t i = 0; i < as_size(D); ++i)
      if (sign[i] < 0) p[i] -= side;
    return p;
  }
  [[nodiscard]] Index<D> local(const Index<D>& p) const {
    Index<D> u;
    for (std::size_t i = 0; i < as_size(D); ++i) u[i] = (p[i] - even_corner[i]) * sign[i];
    return u;
  }
  [[nodiscard]] Index<D> global(const Index<D>& u) const {
    Index<D> p;
    for (std::size_t i = 0; i < as_size(D); ++i) p[i] = even_corner[i] + sign[i] * u[i];
    return p;
  }
};

/// The centres of the nodes of a tier of a cube of side `side` (lowest corner at the origin,
/// local coordinates u) whose closed domain contains u: snap the `tier` coordinates that are
/// nearest to the cube's border to it, all others to the middle; ties give several.
template <int D>
[[nodiscard]] NearPoints<D> nodes_containing(const Index<D>& u, std::int32_t side, int tier);

/// Per tier, the centre of the one such node whose inside contains u, which lies on none's border.
template <int D>
[[nodiscard]] std::array<Index<D>, as_size(D)> nodes_round(const Index<D>& u, std::int32_t side);

/// Sorts axes [first, D) so that before(a, b) holds for no later a and earlier b; equal ones stay.
template <std::size_t D, typename Before>
constexpr void sort_axes(std::array<int, D>& axes, std::size_t first, const Before& before) {
  for (std::size_t i = first + 1; i < D; ++i)
    for (std::size_t j = i; j > first && before(axes[j], axes[j - 1]); --j)
      std::swap(axes[j], axes[j - 1]);
}

/// The axes, those first along which a point of a cube (local coordinates u) is nearest to the
/// cube's border, and how far it is from that.
template <int D>
struct BorderOrder {
  std::array<int, as_size(D)> axes;
  Index<D> distance;

  BorderOrder(const Index<D>& u, std::int32_t side) {
    for (std::size_t i = 0; i < as_size(D); ++i) {
      axes[i] = static_cast<int>(i);
      distance[i] = std::min(u[i], side - u[i]);
    }
    sort_axes(axes, 0, [&](int a, int b) { return distance[as_size(a)] < distance[as_size(b)]; });
  }
};

template <int D>
std::array<Index<D>, as_size(D)> nodes_round(const Index<D>& u, std::int32_t side) {
  const BorderOrder<D> order(u, side);
  std::array<Index<D>, as_size(D)> nodes;
  Index<D> node = all_equal<D>(side / 2);
  for (std::size_t tier = 0; tier < as_size(D); ++tier) {
    nodes[tier] = node;
    const std::size_t axis = as_size(order.axes[tier]);
    node[axis] = 2 * u[axis] < side ? 0 : side;
  }
  return nodes;
}

/// Per tier, the value at local coordinates u, in a cube of side `side` in canonical orientation,
/// of the interpolant in which the cube's nodes of lower tiers are refined. `vertex(Index<D>)`
/// gives the values at the cube's corners and node centres, in halves of the side. All weights are
/// multiples of 1/side: exact for integers while they fit in a double.
template <int D, typename VertexValue>
[[nodiscard]] std::array<double, as_size(D)> interpolants_at(const Index<D>& u, std::int32_t side,
                                                             const VertexValue& vertex) {
  const BorderOrder<D> border(u, side);
  std::array<double, as_size(D)> values;
  // The centres of the cube, then of the faces u lies nearest to: weights are steps of distance.
  Index<D> p = all_equal<D>(1);
  double sum = 0;
  std::int32_t used = 0;  // 2 · (border distance) given away so far, of `side`
  for (std::size_t tier = 0; tier < as_size(D); ++tier) {
    // The rest is on the Kuhn simplices of the face left over, scaled by what remains.
    std::array<int, as_size(D)> order = border.axes;
    std::array<std::int32_t, as_size(D)> rest{};
    Index<D> v = p;
    for (std::size_t j = tier; j < as_size(D); ++j) {
      const std::size_t axis = as_size(order[j]);
      v[axis] = 0;
      rest[axis] = 2 * u[axis] - used;  // doubled, in [0, 2·(side - used)]
    }
    sort_axes(order, tier, [&](int a, int b) { return rest[as_size(a)] > rest[as_size(b)]; });
    double total = sum;
    std::int32_t left = 2 * (side - used);
    for (std::size_t j = tier; j <= as_size(D); ++j) {
      const std::int32_t next = j < as_size(D) ? rest[as_size(order[j])] : 0;
      if (left > next) total += 0.5 * static_cast<double>(left - next) * vertex(v);
      left = next;
      if (j < as_size(D)) v[as_size(order[j])] = 2;
    }
    values[tier] = total / static_cast<double>(side);
    const std::size_t axis = as_size(border.axes[tier]);
    const std::int32_t weight = 2 * border.distance[axis] - used;
    if (weight > 0) sum += static_cast<double>(weight) * vertex(p);
    used += weight;
    p[axis] = 2 * u[axis] <= side ? 0 : 2;
  }
  return values;
}

}  // namespace lode::diamond
