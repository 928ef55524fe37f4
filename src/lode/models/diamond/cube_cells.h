#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/cube_meter.h"

namespace lode::diamond {

/// Which unit cells of a volume are marched in the style of cubes where others are not: all of
/// whose simplices are in the cut, whose triangles stay within a limit of F = isovalue, and beside
/// which there is no cell that the surface meets and that is not whole. Cells of bricks that holes
/// are beside are none.
class CubeCells {
 public:
  /// `limit`: of |F - isovalue|, field units; may be infinite.
  [[nodiscard]] static Result<CubeCells> find(const Selection<3>& selection,
                                              const CoarseCut<3>& cut,
                                              std::span<const BrickWork<3>> work,
                                              const LatticeFrame& frame, double limit,
                                              Threads threads, Progress& progress);

  /// `cell`: its lowest corner; may be none of the volume's.
  [[nodiscard]] bool contains(const Index<3>& cell) const {
    for (std::size_t i = 0; i < 3; ++i)
      if (cell[i] < 0 || cell[i] >= n_cells_[i]) return false;
    return (cubes_[word_of(cell)] >> (cell[0] & 31) & 1) != 0;
  }
  /// Of all their triangles.
  [[nodiscard]] CubeDeviation measure(const Model<3>& model, const LatticeFrame& frame,
                                      double isovalue, Threads threads) const;

 private:
  [[nodiscard]] std::size_t word_of(const Index<3>& cell) const {
    return (as_size(cell[2]) * as_size(n_cells_[1]) + as_size(cell[1])) * n_words_ +
           as_size(cell[0] / 32);
  }

  Index<3> n_cells_;
  std::size_t n_words_ = 0;           ///< Of a row of cells; a brick's are one.
  std::vector<std::uint32_t> cubes_;  ///< By row, y first.
};

}  // namespace lode::diamond
