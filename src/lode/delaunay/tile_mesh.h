#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/result.h"
#include "lode/delaunay/grid_cells.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/seams.h"

namespace lode::delaunay {

/// Makes the mesh that a tile begins with: of the outline of its cells, and of all vertices on its
/// sides. Nodes are relative to the tile's first.
class TileMesher {
 public:
  TileMesher(const Seams& seams, const GridCells* cells) : seams_(seams), cells_(cells) {}

  /// Constrained Delaunay, of a tile of that part of the raster; without triangles where it has no
  /// cells. `memory` is used for it.
  [[nodiscard]] Result<LatticeMesh> make(std::size_t tile, const LatticePart& part,
                                         LatticeTriangles memory);

 private:
  /// A side from its smaller column or row, as `first` + i `step`; edges run that way, or back.
  struct Side {
    const SeamSide& seam;
    std::int32_t start;  ///< The place that is first.
    LatticePoint first;
    LatticePoint step;
    bool is_forward;
    std::uint32_t number;
  };
  [[nodiscard]] Result<bool> start(const LatticePart& part, LatticeTriangles& memory);
  void insert_side(LatticeMesh& mesh, const Side& side);
  void insert_between(LatticeMesh& mesh, const Side& side, std::size_t lower, std::size_t upper);
  [[nodiscard]] bool has_cell(const Side& side, std::int32_t place) const;
  void note_owners(const LatticeMesh& mesh, std::span<const std::uint32_t> slots);
  [[nodiscard]] std::uint32_t& owner_of(std::uint32_t side, LatticePoint from);

  const Seams& seams_;
  const GridCells* cells_;
  LatticePoint last_{};                ///< Of the tile.
  LatticePoint origin_{};              ///< In the raster.
  bool is_full_ = true;                ///< The tile has all cells.
  std::vector<std::uint32_t> owners_;  ///< By side, then where an edge on it begins: its triangle.
};

}  // namespace lode::delaunay
