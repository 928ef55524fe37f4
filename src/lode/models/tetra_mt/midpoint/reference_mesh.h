#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/region_match.h"

namespace lode::tetra_mt::midpoint {

/// The mesh that a forest was made from, as it says: its leaves, and the cells of all splits.
class ReferenceMesh {
 public:
  /// `coincident_leaves`: Hierarchy's. Looks at every page. Fails where one cannot be loaded,
  /// splits do not fit together, a leaf's code is not that of its position, or leaves at one place
  /// are not told apart; and when cancelled.
  [[nodiscard]] static Result<ReferenceMesh> of(const Forest& forest,
                                                std::span<const std::uint32_t> coincident_leaves,
                                                Progress& progress);

  /// By leaf the mesh's vertex. Fails where a mesh is another: expects the same positions, bit for
  /// bit, the same cells, turned alike, in the same regions where it has any, and codes in the
  /// mesh's steps, so that collapses of the mesh make the forest's nodes. Positions and cells may
  /// come in another order, but for vertices at one place among themselves.
  [[nodiscard]] Result<std::vector<std::uint32_t>> match(const TetraMesh& mesh) const;

 private:
  ReferenceMesh() = default;

  Scales scales_;                      ///< Of the forest's codes.
  std::vector<Vec3d> positions_;       ///< By leaf.
  std::vector<std::uint32_t> leaves_;  ///< by_place(), those at one place as the mesh has them.
  std::vector<Tetrahedron> cells_;     ///< Of leaves: turned() and sorted.
  std::vector<RegionCell> regions_;    ///< Of leaves, where there are any.
};

}  // namespace lode::tetra_mt::midpoint
