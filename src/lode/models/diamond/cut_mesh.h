#pragma once

#include <optional>

#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/refinable.h"
#include "lode/refine/demand.h"

namespace lode::diamond {

/// World points near a plane, or all of them.
struct NearPlane {
  Vec3d point;
  Vec3d normal;         ///< Unit length.
  double distance = 0;  ///< World units.
};

struct CutMeshOptions {
  /// Whose touches() says which simplices are in focus.
  Demand focus = [](const NodeFacts&) { return 1.0; };
  bool only_focus = false;          ///< Leaves out simplices that are neither finest nor in focus.
  std::optional<NearPlane> near{};  ///< Only simplices that come so near the plane.
  std::uint64_t n_expected = 0;     ///< Cells to reserve memory for.
};

struct CutMeshReport {
  double achieved_error = 0;     ///< Largest error of a cell in focus.
  double largest_error = 0;      ///< Largest error of a cell.
  std::uint64_t n_left_out = 0;  ///< Simplices with present and removed cells, left unrefined.
};

/// The mesh of a cut: its simplices, cut exactly at the end of the data, with the values of F'.
/// Vertices are samples' places, also where simplices are cut; they are numbered in the order of
/// the leaves. Simplices that holes remove do not exist; those that holes remove in part are left
/// out. A cell's error is the stored nested one of the node that would bisect its simplex, at most
/// the field's whole range. Replaces `mesh`. Of pages those must be held that the cut's nodes take.
template <int D, typename Field>
[[nodiscard]] Result<CutMeshReport> mesh_of_cut(const Refinable<D, Field>& opened, const Cut& cut,
                                                const CutMeshOptions& options, SimplexMesh& mesh,
                                                Progress& progress);

}  // namespace lode::diamond
