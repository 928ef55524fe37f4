#pragma once

// Marching tetrahedra of a whole unit cell in one table look-up: the six Kuhn simplices of a
// cell of the finest lattice, as the diamond hierarchy splits it.

#include <array>
#include <cstdint>

namespace lode {

/// Every edge of the finest lattice starts at its anchor, the lowest corner of its box, and goes
/// along a direction: a set of axes, 1 .. 7. Edges of one direction that share a row of anchors
/// (equal y and z) are numbered together. A cell touches 14 such series in the four rows of its
/// corners; this is the series of a direction (without the axes the row is moved along).
[[nodiscard]] constexpr int edge_series(int direction, int row_y, int row_z) {
  constexpr std::array<int, 8> kFirstRow{-1, 0, 1, 2, 3, 4, 5, 6};
  if (row_y == 0 && row_z == 0) return kFirstRow[static_cast<std::size_t>(direction)];
  if (row_y == 1 && row_z == 0) return direction == 1 ? 7 : direction == 4 ? 8 : 9;
  if (row_y == 0) return 9 + direction;
  return 13;
}
inline constexpr int kEdgeSeries = 14;

/// A crossed edge of a cell: series + 16 · (anchor's x - cell's x).
using CellEdge = std::uint8_t;

/// A corner of a cell: bit i is set at its upper side along axis i.
using CellCorner = std::uint8_t;

/// The edge between two corners, one of which is above the other or equal along every axis.
[[nodiscard]] CellEdge cell_edge(CellCorner a, CellCorner b);
/// Its corners, the lower one first.
[[nodiscard]] std::array<CellCorner, 2> edge_corners(CellEdge edge);

/// The triangles of one cell for one set of inside corners.
struct KuhnCubeCase {
  std::uint8_t n_edges = 0;
  std::uint8_t n_triangles = 0;
  std::array<CellEdge, 19> edges{};
  std::array<std::array<std::uint8_t, 3>, 12> triangles{};  ///< Indices into `edges`.
};

/// By the set of inside corners; corner bit x + 2y + 4z.
using KuhnCubeCases = std::array<KuhnCubeCase, 256>;

/// The cases of cells whose lowest corner has these coordinates modulo 2 (bit i: axis i), for
/// lattices with right-handed axes or mirrored ones. Triangles are counter-clockwise seen from
/// the outside (lower values) in world coordinates.
[[nodiscard]] const KuhnCubeCases& kuhn_cube_cases(int parity, bool is_mirrored);

/// The same of cells with an even lowest corner and right-handed axes, but only in those of the six
/// simplices whose chain from the even corner begins along an axis of the set.
[[nodiscard]] KuhnCubeCases kuhn_cube_cases_along(unsigned first_axes);

}  // namespace lode
