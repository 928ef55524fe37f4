#pragma once

#include <array>
#include <cstdint>

#include "lode/core/inline_list.h"
#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_nodes.h"
#include "lode/models/diamond/cell_edges.h"
#include "lode/models/diamond/cube_cells.h"

namespace lode::diamond {

/// Marches the unit cells of one brick after another, row by row: of each those of its six
/// simplices that are there, from a table, or all of it in the style of cubes.
///
/// Where a cell of that style has a neighbour with tetrahedra, the vertex on their face's diagonal
/// cannot go, and is moved along the diagonal onto the segment between the face's other two: the
/// cube's patch is what it would be without the vertex, and the neighbour's, whose vertices may be
/// anywhere on their edges, stays embedded. So |F - isovalue| beside a cube is no more than on it.
class CellMarcher {
 public:
  explicit CellMarcher(const LatticeFrame& frame);

  /// `cubes`: which cells are of that style; null: none. Must outlive what follows.
  void set_cubes(const CubeCells* cubes) { cubes_ = cubes; }

  /// Of the brick that the nodes and the mapper have open.
  void march(const BrickNodes& nodes, BrickIsosurface<3>& mapper);

  /// How far at most a vertex was moved, in world units.
  [[nodiscard]] double farthest_move() const { return farthest_move_; }

 private:
  /// A crossed edge of a unit cell, from the cell's lowest corner.
  struct EdgePlace {
    std::uint32_t place = 0;         ///< Of its entry among BrickVertices.
    std::uint32_t first_sample = 0;  ///< At the end with the smaller key.
    std::uint32_t second_sample = 0;
    LatticeKey first_key = 0;
    LatticeKey second_key = 0;
    std::uint8_t face = 0;  ///< Of a face's diagonal: twice its axis, and 1 at the upper side.
  };
  using EdgePlaces = std::array<EdgePlace, CellEdges::kEdges>;
  using Triangle = std::array<std::uint32_t, 3>;

  /// A row of cells.
  struct Row {
    std::size_t y, z;
    unsigned parity;                       ///< Of y and z, as bits 1 and 2.
    std::array<std::uint64_t, 4> corners;  ///< Which are inside; those with even y and z first.
    std::array<std::uint64_t, 3> axes;     ///< As simplices_along().
    const std::byte* data;                 ///< The first cell's lowest corner.
    std::size_t place;                     ///< Its entry's.
    LatticeKey key;
  };
  /// One of them.
  struct Cell {
    std::size_t x;
    unsigned parity;
    std::size_t signs;         ///< By coordinates modulo 2.
    bool is_flipped;           ///< Whether triangles are to be turned.
    unsigned moved_faces = 0;  ///< Whose diagonal's vertex is moved: bits, as EdgePlace::face.
  };

  /// That a diagonal lies in, by its corners as coordinates modulo 2.
  struct Face {
    std::size_t even, odd;      ///< The diagonal's.
    std::size_t first, second;  ///< Beside the even one, along the first axis and the second.
    std::array<std::size_t, 4> edges;  ///< even-first, first-odd, even-second, second-odd.
  };

  [[nodiscard]] Row row_at(const BrickNodes& nodes, std::size_t y, std::size_t z) const;
  template <typename T>
  void march_row(const Row& row, std::uint32_t crossed);
  template <typename T>
  void march_simplices(const Row& row, const Cell& cell);
  template <typename T>
  void march_cube(const Row& row, const Cell& cell);
  template <typename T>
  [[nodiscard]] std::uint32_t vertex_on(const Row& row, const Cell& cell, std::size_t edge);
  template <typename T>
  [[nodiscard]] std::uint32_t add_moved(const Row& row, const Cell& cell, std::size_t edge);
  template <typename T>
  [[nodiscard]] double value(const Row& row, const Cell& cell, std::uint32_t sample) const;
  template <typename T>
  [[nodiscard]] double crossing_on(const Row& row, const Cell& cell, std::size_t from,
                                   std::size_t to) const;
  [[nodiscard]] static bool is_crossed(const Cell& cell, std::size_t edge);
  [[nodiscard]] Face face_of(std::size_t diagonal) const;
  static void split(InlineList<Triangle, 18>& triangles, const std::array<std::uint32_t, 2>& side,
                    std::uint32_t between);
  [[nodiscard]] unsigned cubes_beside(const Index<3>& cell) const;
  [[nodiscard]] bool has_cell_beside(const Index<3>& cell, unsigned face) const;
  void add(const Triangle& ids, bool is_flipped);

  LatticeFrame frame_;
  const CubeCells* cubes_ = nullptr;
  const BrickNodes* nodes_ = nullptr;
  BrickIsosurface<3>* mapper_ = nullptr;
  double farthest_move_ = 0;
  std::array<EdgePlaces, 8> edges_;  ///< By the parity of the cell's lowest corner.
  /// By the corners it joins, as coordinates modulo 2.
  std::array<std::array<std::uint8_t, 8>, 8> edge_between_{};
};

}  // namespace lode::diamond
