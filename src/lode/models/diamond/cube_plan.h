#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Cells per edge of the cubes whose errors are computed together, one per SIMD lane.
template <int D>
inline constexpr std::int32_t kPlanEdge = D == 3 ? 16 : 32;
/// Lattice points of such a cube.
template <int D>
inline constexpr std::size_t kPlanPoints = D == 3 ? 17 * 17 * 17 : 33 * 33;
/// Cubes per brick.
template <int D>
inline constexpr int kPlansPerBrick = D == 3 ? 8 : 16;

/// One interpolant F' on a cube, spelled out: which points are its vertices, how every other
/// point's value is the mean of two earlier ones (F' is linear along each diamond's axis), and
/// for which node each point counts.
struct InterpolantPass {
  struct Mean {
    std::uint16_t to, first, second;
  };
  struct Region {
    std::uint32_t target = 0;  ///< A node's offset in the cube, or the number of a Kuhn simplex.
    std::uint32_t begin = 0;   ///< Its points, as a range of `points`.
    std::uint32_t end = 0;
  };
  std::vector<std::uint16_t> vertices;
  std::vector<Mean> means;  ///< In order of evaluation.
  std::vector<Region> regions;
  std::vector<std::uint16_t> points;
};

/// Everything needed to find the own errors of all nodes of sides 4 .. kPlanEdge inside a cube of
/// side kPlanEdge, and the error of any coarser interpolant on its Kuhn simplices. All offsets are
/// into the (kPlanEdge+1)^D points of the cube in canonical coordinates: the corner ≡ 0 mod
/// 2·kPlanEdge at the origin, mirrored so that all coordinates grow from it.
template <int D>
struct CubePlan {
  struct NodePass {
    int level = 0;
    InterpolantPass pass;
  };
  std::vector<NodePass> node_passes;  ///< Per sub-cube and tier; regions are nodes.
  InterpolantPass kuhn;               ///< Tier 0 on the whole cube; regions are Kuhn simplices.
  std::vector<Simplex<D>> kuhn_simplices;  ///< In canonical coordinates, in `kuhn`'s order.

  [[nodiscard]] static const CubePlan& instance();
};

extern template struct CubePlan<2>;
extern template struct CubePlan<3>;

/// A cube of the hierarchy with its canonical coordinates: the corner ≡ 0 mod 2·side at the
/// origin, mirrored so that all coordinates grow from it.
template <int D>
struct CanonicalCube {
  std::int32_t side;
  Index<D> even_corner;
  Index<D> sign;

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
[[nodiscard]] std::vector<Index<D>> nodes_containing(const Index<D>& u, std::int32_t side,
                                                     int tier);

/// The value at local coordinates u, in a cube of side `side` in canonical orientation, of the
/// interpolant in which the cube's nodes of tiers below `tier` are refined. `vertex(Index<D>)`
/// gives the values at the cube's corners and node centres (canonical local coordinates). All
/// weights are multiples of 1/side: exact for integers while they fit in a double.
template <int D, typename VertexValue>
[[nodiscard]] double interpolant_at(const Index<D>& u, std::int32_t side, int tier,
                                    const VertexValue& vertex) {
  std::array<int, as_size(D)> order;
  std::array<std::int32_t, as_size(D)> border_distance;
  for (int i = 0; i < D; ++i) {
    order[as_size(i)] = i;
    border_distance[as_size(i)] = std::min(u[as_size(i)], side - u[as_size(i)]);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return border_distance[as_size(a)] < border_distance[as_size(b)];
  });
  // The centres of the cube, then of the faces u lies nearest to: weights are steps of distance.
  Index<D> p;
  for (int i = 0; i < D; ++i) p[as_size(i)] = side / 2;
  double sum = 0;
  std::int32_t used = 0;  // 2 · (border distance) given away so far, of `side`
  for (int j = 0; j < tier; ++j) {
    const std::size_t axis = as_size(order[as_size(j)]);
    const std::int32_t weight = 2 * border_distance[axis] - used;
    if (weight > 0) sum += static_cast<double>(weight) * vertex(p);
    used += weight;
    p[axis] = 2 * u[axis] <= side ? 0 : side;
  }
  // The rest is on the Kuhn simplices of the face left over, scaled by what remains.
  std::array<std::int32_t, as_size(D)> rest{};
  for (int j = tier; j < D; ++j) {
    const std::size_t axis = as_size(order[as_size(j)]);
    p[axis] = 0;
    rest[axis] = 2 * u[axis] - used;  // doubled, in [0, 2·(side - used)]
  }
  std::stable_sort(order.begin() + tier, order.end(),
                   [&](int a, int b) { return rest[as_size(a)] > rest[as_size(b)]; });
  std::int32_t left = 2 * (side - used);
  for (int j = tier; j <= D; ++j) {
    const std::int32_t next = j < D ? rest[as_size(order[as_size(j)])] : 0;
    if (left > next) sum += 0.5 * static_cast<double>(left - next) * vertex(p);
    left = next;
    if (j < D) p[as_size(order[as_size(j)])] = side;
  }
  return sum / static_cast<double>(side);
}

}  // namespace lode::diamond
