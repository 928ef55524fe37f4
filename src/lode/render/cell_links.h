#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/result.h"

namespace lode {

/// A tetrahedron, and what is across each of its faces, as four words of two numbers, the first in
/// the lower half: corners 0 and 1, 2 and 3; across corner 0 and 1, 2 and 3.
struct LinkedCell {
  std::array<std::uint64_t, 4> words;

  /// Across the face that does not have corner i: a cell, or kOuter + the number of an outer face.
  [[nodiscard]] std::uint32_t across(std::size_t i) const {
    return static_cast<std::uint32_t>(words[2 + i / 2] >> 32 * (i % 2));
  }
};

/// Which cells of a mesh share faces. A face is outer where it has one cell, or more than two.
struct CellLinks {
  static constexpr std::uint32_t kOuter = std::uint32_t{1} << 31;

  struct OuterFace {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t cell;
  };
  std::vector<LinkedCell> cells;
  std::vector<OuterFace> outer_faces;  ///< By cell, then by the corner across.
};

/// O(cells). Fails on corners that are no vertex, cells with a corner twice, and above 2^29 cells.
[[nodiscard]] Result<CellLinks> link_cells(const SimplexMesh& mesh, Threads threads);

}  // namespace lode
