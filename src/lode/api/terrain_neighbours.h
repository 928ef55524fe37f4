#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/api/terrain_tin.h"

namespace lode {

/// A triangle of a TIN near a place, and what lies beside it.
struct TerrainTriangle {
  /// A triangle across an edge, or across a part of it.
  struct Beside {
    std::uint8_t edge = 0;        ///< 0 to 2: from the corner of that number to the next.
    std::uint8_t other_edge = 0;  ///< The same edge, as the other triangle counts.
    std::uint32_t triangle = 0;   ///< The other one's number.

    friend bool operator==(const Beside&, const Beside&) = default;
  };

  std::uint32_t triangle = 0;    ///< Its number in the TIN.
  std::uint32_t ring = 0;        ///< Steps across edges from the nearest that holds the place.
  std::array<Vec3d, 3> corners;  ///< x, y and height, turning left (x to the right, y up).
  double bound = 0;              ///< Of error, as of TerrainHeight.
  /// By edge, and along it; of an edge where the domain ends there is none.
  std::vector<Beside> beside;
};

/// The triangles that hold a place, at an edge or a corner all that do, and those around them.
struct TerrainNeighbours {
  TerrainHeight::Where where = TerrainHeight::Where::outside;
  std::vector<TerrainTriangle> triangles;  ///< By ring, then by number.
};

struct NeighboursOptions {
  std::uint32_t n_rings = 1;  ///< So many steps from the triangles that hold the place.
  /// In all answers together, each about 250 bytes; more is refused.
  std::uint64_t most_triangles = std::uint64_t{1} << 24;
  Threads threads{};  ///< Answers are the same for any.
};

struct NeighboursReport {
  std::uint64_t n_outside = 0;
  std::uint64_t n_in_gaps = 0;
  std::uint64_t n_triangles = 0;  ///< In all answers together.
  double prepare_seconds = 0;     ///< What making the locator and sorting took, the first time.
  double seconds = 0;
};

}  // namespace lode
