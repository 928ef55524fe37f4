#pragma once

#include <array>
#include <cstdint>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Most isovalues whose ranks a NetSlice holds: 0 .. kMostRanked.
inline constexpr std::size_t kMostRanked = 127;

/// A slice of a brick's samples and, for each, what the cells and edges that have been added say of
/// it. A surface between two values is crossed by what has a vertex on either side, so that sums
/// over vertices by their ranks count it: an edge is 1 at its lower end and -1 at its upper one; a
/// tetrahedron's triangles are 1 at its two lowest vertices and -1 at the other two. Of equal ranks
/// either may count as the lower one. A sample's sums are `left` + `right`.
struct NetSlice {
  static constexpr std::size_t kStride = 48;  ///< From row to row; rows of 33 samples.
  static constexpr std::size_t kSize = as_size(kBrickSamples<3>) * kStride + 64;
  using Row = std::array<std::int8_t, kSize>;

  alignas(64) Row rank;  ///< Of samples; beyond the data those of any.
  alignas(64) Row left_triangles{};
  alignas(64) Row right_triangles{};
  alignas(64) Row left_edges{};
  alignas(64) Row right_edges{};

  void clear();
};

/// A layer of cells between two slices, n_cells (1 .. 32) in each of n_rows rows, even or odd, in a
/// brick.
struct CellLayer {
  NetSlice& lower;
  NetSlice& upper;
  std::int32_t n_cells;
  std::int32_t n_rows;
  bool is_odd;
};

/// Adds the six tetrahedra of each cell of a layer and the seven edges that begin at each one's
/// lowest corner. The result is the same on every processor.
void add_crossing_nets(const CellLayer& layer);

}  // namespace lode::diamond
