#pragma once

// The simplices that leave a cube of the hierarchy when its node is refined, spelled out.

#include <array>
#include <cstdint>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// A point of a cube of side 2 h, by steps of h from its lowest corner: x + 3 y + 9 z.
using CubePoint = std::uint8_t;
/// Of those 27 points, a bit each.
using CubePoints = std::uint32_t;

[[nodiscard]] constexpr CubePoint cube_point(const Index<3>& steps) {
  return static_cast<CubePoint>(steps[0] + 3 * steps[1] + 9 * steps[2]);
}
[[nodiscard]] constexpr Index<3> steps_of(CubePoint p) { return {{p % 3, p / 3 % 3, p / 9}}; }

/// A simplex between points of a cube, in the order that bisection gives them.
struct CubeSimplex {
  std::array<CubePoint, 4> corner{};
  CubePoints corners = 0;
  Index<3> lower;  ///< In steps.
  bool is_positive = true;
};

/// Of a cube that is split at its centre.
struct CubeLeaves {
  struct Finer {
    CubeSimplex simplex;
    std::uint8_t octant = 0;  ///< The cube of side h that it lies in: bit i at the upper side.
  };
  struct Edge {
    CubePoint node = 0;          ///< Its middle, which is tier 2.
    CubeSimplex simplex;         ///< There if the face's node is refined and this one is not,
    std::array<Finer, 2> finer;  ///< and these if it is: of tier 0 and the next finer level.
  };
  struct Face {
    CubePoint node = 0;                    ///< Its middle, which is tier 1.
    std::array<CubeSimplex, 2> simplices;  ///< There if it is not refined,
    std::array<Edge, 4> edges;             ///< and what lies beside these if it is.
    CubePoints edge_nodes = 0;
  };
  std::array<Face, 6> faces;
  CubePoints edge_nodes = 0;  ///< All twelve.

  /// By the cube's place: bit i is set where its lowest corner is an odd multiple of its side along
  /// axis i.
  [[nodiscard]] static const CubeLeaves& of(unsigned parity);
};

}  // namespace lode::diamond
