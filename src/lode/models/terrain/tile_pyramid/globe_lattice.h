#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/lattice_point.h"
#include "lode/models/terrain/tile_pyramid/tile_mesh.h"

namespace lode::tile_pyramid {

/// Clients draw straight triangles between vertices on the globe, which has chords below its
/// surface however flat the terrain is. Cells that a tile's side is cut into at least, such that
/// the chords of these cells' diagonals sag, at the equator, by at most 3/8 of what clients take
/// the level's error to be: 31 on levels 0 and 1, half as many every other level, 1 from level 10.
[[nodiscard]] int n_globe_cells(int level);

/// Nodes between neighbours on a side, at most.
[[nodiscard]] std::int32_t most_gap(int level);

/// Nodes of a lattice of n_globe_cells() both ways, inside of the tile, that have no vertex within
/// a quarter of a cell both ways. With them, and sides without larger gaps, no place of the tile is
/// farther than 1.07 cells from a vertex: that is the most that Delaunay triangles have for the
/// radius of their circle, but for some on the sides, and the chords of all then sag by less than
/// what clients assume.
[[nodiscard]] std::vector<LatticePoint> missing_globe_nodes(const TileMesh& mesh, int level);

}  // namespace lode::tile_pyramid
