#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/cube_meter.h"
#include "lode/models/diamond/node_set.h"

namespace lode::diamond {

/// Which unit cells of a volume, or of a file's part, are marched in the style of cubes where
/// others are not: all of whose simplices are in the cut, whose triangles keep to a limit, and
/// beside which there is no cell that the surface meets and that is not whole. Cells of bricks that
/// holes are beside are none.
class CubeCells {
 public:
  /// None.
  CubeCells() = default;
  /// All cells, which measure() does not know of.
  [[nodiscard]] static CubeCells all(const Shape<3>& shape);
  /// Of bricks of the selection's lattice; what lies round them counts as none, but where all cells
  /// are cubes. Within a distance none are that have a corner of `weak` (may be null): pieces that
  /// leave_out() takes may be what the others in them are near.
  [[nodiscard]] static Result<CubeCells> find(const Selection<3>& selection,
                                              std::span<const CutBrick<3>> bricks,
                                              const LatticeFrame& frame, const CubeLimit& limit,
                                              const NodeSet<3>* weak, Threads threads,
                                              Progress& progress);

  /// Whether all cells are cubes that the surface meets, so that none has to be looked at for the
  /// sake of its neighbours.
  [[nodiscard]] static bool are_all(bool has_holes, const CubeLimit& limit);

  /// `cell`: its lowest corner; may be none of the lattice's. Of cells that the surface does not
  /// meet it says nothing.
  [[nodiscard]] bool contains(const Index<3>& cell) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (cell[i] < 0 || cell[i] >= n_cells_[i]) return false;
    return are_all_ || (cubes_[word_of(cell)] >> (cell[0] & 31) & 1) != 0;
  }
  /// Twice that while they are found.
  [[nodiscard]] std::uint64_t n_bytes() const { return cubes_.size() * sizeof(std::uint32_t); }
  /// Of the triangles of those in some of the bricks.
  [[nodiscard]] CubeDeviation measure(const Selection<3>& selection,
                                      std::span<const CutBrick<3>> bricks,
                                      const LatticeFrame& frame, Threads threads) const;

 private:
  explicit CubeCells(const Shape<3>& shape);

  [[nodiscard]] std::size_t word_of(const Index<3>& cell) const {
    return (as_size(cell[2]) * as_size(n_cells_[1]) + as_size(cell[1])) * n_words_ +
           as_size(cell[0] / 32);
  }
  void leave_out_beside(std::span<const std::uint32_t> others, Threads threads);

  Index<3> n_cells_;
  std::size_t n_words_ = 0;           ///< Of a row of cells; a brick's are one.
  std::vector<std::uint32_t> cubes_;  ///< By row, y first.
  bool are_all_ = false;
};

}  // namespace lode::diamond
