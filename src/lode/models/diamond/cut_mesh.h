#pragma once

#include <functional>
#include <span>

#include "lode/core/mesh.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/refinable.h"
#include "lode/refine/demand.h"

namespace lode::diamond {

struct CutMeshOptions {
  /// Whose touches() says which simplices are in focus.
  Demand focus = [](const NodeFacts&) { return 1.0; };
  bool only_focus = false;  ///< Leaves out simplices that are neither finest nor in focus.
  /// Only simplices whose corners, in the world, it says so of, and of all that hold these; none:
  /// all.
  std::function<bool(std::span<const Vec3d>)> is_near{};
  std::uint64_t n_expected = 0;  ///< Cells to reserve memory for.
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
