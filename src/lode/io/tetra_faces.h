#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/split_cells.h"

namespace lode::io {

/// How tetrahedra hang together through faces.
struct TetraFaces {
  std::vector<std::uint32_t> components;  ///< By tetrahedron; numbered by their first one.
  std::uint32_t n_components = 0;
  /// By tetrahedron, 0 or 1: those of one component that are wound alike, so that each sees a face
  /// they share the other way round, have the same.
  std::vector<std::uint8_t> windings;
  std::vector<std::uint8_t>
      is_orientable;  ///< By component: whether windings are that in all of it.
  /// Faces of one tetrahedron only, by their corners, which ascend.
  std::vector<std::array<std::uint32_t, 3>> boundary;
};

/// Fails at the first face, in the order of its points, that has more than two tetrahedra. Points
/// are below `n_points`. Takes 70 bytes a tetrahedron.
[[nodiscard]] Result<TetraFaces> connect_faces(const std::string& path, const SplitCells& split,
                                               std::size_t n_points);

}  // namespace lode::io
