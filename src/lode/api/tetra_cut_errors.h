#pragma once

#include <cstdint>
#include <string>
#include <vector>

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
  double largest_certain = 0;        ///< Less what rounding may be.
  double largest_stated = 0;         ///< By a cell.
  double farthest_outside = 0;       ///< World units.
  std::string first;                 ///< What is wrong with the first that something is.

  void append(const TetraCutErrors& later);
};

/// Where a boundary that moves may have left vertices: outside of all cells, or, across a gap, in
/// those of another part. Only such as lie near the reference's boundary: what its faces sweep is
/// no farther from it than they move.
struct MovedBoundary {
  std::vector<bool> is_near;  ///< By vertex.
  double reach = 0;           ///< How far from it cells are looked at, world units.
};
/// `deviation`: how far boundaries of cuts are from the reference's, at most.
[[nodiscard]] MovedBoundary find_moved(const TetraVertices& vertices,
                                       const TetraCutShape& reference, double deviation,
                                       Threads threads);

/// `vertices`: with a field's values; `cells`: with what they state of it. A vertex may be where
/// several cells touch, or lie over one another: what one of them states is enough. What rounding
/// does to F' is allowed for; and, where a vertex is outside by no more than that, by how much F'
/// may differ between there and the cell. `moved`: where the boundary may move by more than
/// rounding. Then vertices outside have no F'; and of those inside that are near the boundary the
/// cells within reach count beside those that hold them, at the weights nearest to theirs that are
/// inside. The same for any number of threads.
[[nodiscard]] TetraCutErrors measure_errors(const TetraVertices& vertices, const TetraCells& cells,
                                            const MovedBoundary* moved, Threads threads);

}  // namespace lode
