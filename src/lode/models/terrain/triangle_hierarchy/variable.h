#pragma once

#include <optional>

#include "lode/delaunay/tin.h"
#include "lode/models/terrain/triangle_hierarchy/edge_chains.h"
#include "lode/models/terrain/triangle_hierarchy/patch_errors.h"
#include "lode/refine/demand.h"

namespace lode::triangle_hierarchy {

/// A mesh whose triangles all satisfy the demand, which sees a triangle's error, the heights in it
/// and its bounds in the world, with twins and errors; on the fine lattice. Triangles are refined
/// while they do not satisfy it with their errors at samples, or with the tolerance of the level
/// that refines them, beyond which they err there or along their edges. Where one then has a
/// neighbour whose edge to it is a chain, the constrained Delaunay triangulation between its own
/// corners and the chain stands for it, if that satisfies the demand, and the first level's
/// tolerance, with the errors that `errors` finds for it, and else it is refined, too: so the mesh
/// conforms, and what it says of its errors holds. Triangles of the last level are all that there
/// is: that of the hierarchy, or of its first `n_levels`, as if there were no others. Chains and
/// errors are those of the hierarchy.
[[nodiscard]] delaunay::Tin tin_of_demand(const Hierarchy& hierarchy, const EdgeChains& chains,
                                          const PatchErrors& errors, const Demand& demand,
                                          std::optional<int> n_levels = {});

}  // namespace lode::triangle_hierarchy
