#pragma once

// The tables that whole rows of cells are written from.

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/core/surface.h"
#include "lode/mappers/kuhn_cube.h"

namespace lode::diamond {

/// How the edges of cells whose lowest corner has one parity are numbered: all cells have 19, which
/// go by their ends as seen from the cell's corner with even coordinates. Those on the diagonals of
/// faces come last.
struct CellEdges {
  static constexpr std::size_t kEdges = 19;
  static constexpr std::size_t kCubeEdges = 13;  ///< All that the style of cubes has.

  alignas(32) std::array<CellEdge, 32> edge{};  ///< By these numbers; then 0.
  bool is_flipped = false;                      ///< Whether triangles are to be turned.
  const KuhnCubeCases* by_corners = nullptr;
};

/// By the parity and the frame, as kuhn_cube_cases() or cube_cases().
[[nodiscard]] const CellEdges& cell_edges(int parity, bool is_mirrored, SurfaceStyle style);

/// The triangles of a cell by its corners, where bit k is the one whose coordinates are odd along
/// the axes of k, and edges as CellEdges numbers them.
struct alignas(64) CellCase {
  std::array<std::uint8_t, 63> edge;  ///< Three for each triangle, then anything.
  std::uint8_t n_ends;                ///< How many of them there are: up to 36.
};

/// 256 of them, of cells whose lowest corner is even along all axes.
[[nodiscard]] const CellCase* cell_cases(SurfaceStyle style);

/// The same by a set of axes before the corners: of the simplices whose chain from the even corner
/// begins along one of them, in the style of tetrahedra.
[[nodiscard]] const CellCase* cell_cases_by_axes();

/// An edge of a cell by its ends, the even one first: bit i of an end is set where it is odd along
/// axis i.
using CellEdgeEnds = std::array<std::uint8_t, 2>;
[[nodiscard]] const std::array<CellEdgeEnds, CellEdges::kEdges>& cell_edge_ends();

}  // namespace lode::diamond
