#pragma once

#include <cstdint>
#include <string>

#include "lode/api/tetra_cut_shape.h"

namespace lode {

/// What the vertices of the reference mesh that a cut has not got say of it, and of one field. F'
/// is found where each of them lies, by a search of its own, and held against what the cell there
/// states.
struct TetraCutErrors {
  std::uint64_t n_vertices = 0;      ///< Looked at.
  std::uint64_t n_above_stated = 0;  ///< |F - F'| above the error that the cell there states;
  std::uint64_t n_out_of_range = 0;  ///< F not in its range.
  std::uint64_t n_outside = 0;       ///< Of all cells, by more than rounding;
  std::uint64_t n_far_outside = 0;   ///< and of these farther than the boundary may move.
  double largest = 0;                ///< |F - F'|.
  double largest_stated = 0;         ///< By a cell.
  double farthest_outside = 0;       ///< World units.
  std::string first;                 ///< What is wrong with the first that something is.

  void append(const TetraCutErrors& later);
};

/// `vertices`: with the field's values. A vertex may be where several cells touch, or lie over one
/// another: what one of them states is enough. What rounding does to F' is allowed for; and, where
/// a vertex is outside by no more than the boundary may move, by how much F' may differ between
/// there and the cell. Where the boundary may move by more than rounding, vertices outside have no
/// F', and of those inside cells that near count beside those that hold them. The same for any
/// number of threads. Fails where pages cannot be loaded.
[[nodiscard]] Result<TetraCutErrors> measure_errors(const tetra_mt::PackedHierarchy& hierarchy,
                                                    std::size_t field,
                                                    const TetraVertices& vertices,
                                                    const TetraCells& cells, Threads threads);

}  // namespace lode
