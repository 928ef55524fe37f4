#pragma once

#include "lode/core/box.h"
#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/result.h"
#include "lode/render/cell_links.h"

namespace lode {

/// Round the vertices that cells use; a point at 0 without cells. Corners must be vertices.
[[nodiscard]] Box3d bounds_of_cells(const SimplexMesh& mesh);

/// A mesh of tetrahedra made ready for rays, whatever the view and the transfer function. Refers
/// to the mesh, which must outlive it. Const members may be called from any thread.
class MeshVolume {
 public:
  /// Fails on values and positions that are not finite (or above 1e150), a number of values other
  /// than that of positions, and what link_cells() refuses. Flat and inverted cells are taken. An
  /// empty mesh is a volume without anything in it. O(cells), 64 bytes each.
  [[nodiscard]] static Result<MeshVolume> build(const SimplexMesh& mesh, Threads threads);

  [[nodiscard]] const SimplexMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const CellLinks& links() const { return links_; }
  [[nodiscard]] const Box3d& bounds() const { return bounds_; }

 private:
  MeshVolume(const SimplexMesh& mesh, CellLinks links, const Box3d& bounds)
      : mesh_(&mesh), links_(std::move(links)), bounds_(bounds) {}

  const SimplexMesh* mesh_;
  CellLinks links_;
  Box3d bounds_;
};

}  // namespace lode
