#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode::tile_pyramid {

/// A node of a tile's lattice, x to the east and y to the north, and a height.
struct TileVertex {
  LatticePoint node;
  double height = 0;
};

/// The triangles of a tile: a Delaunay triangulation of its vertices, with the square of its
/// lattice as hull; exactly. Heights are multiples of the level's step.
struct TileMesh {
  std::vector<TileVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Turning left.
};

/// Of vertices on the four sides alone, which are all different, the corners among them.
[[nodiscard]] TileMesh mesh_of_sides(std::span<const TileVertex> sides);

/// Inserts vertices at nodes that are inside of the square and different, also from vertices.
void insert_all(TileMesh& mesh, std::span<const TileVertex> vertices);

/// Inserts vertices greedily (delaunay/point_insertion.h), of candidates inside of the square,
/// until none errs by more than max_error. Of several candidates at one node, or at a vertex, the
/// first counts, or none. Returns how many were inserted; fails when cancelled.
[[nodiscard]] Result<std::uint64_t> refine(TileMesh& mesh, std::span<const TileVertex> candidates,
                                           double max_error, Progress& progress);

}  // namespace lode::tile_pyramid
