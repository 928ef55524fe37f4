#pragma once

#include "lode/core/result.h"
#include "lode/delaunay/tin.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/refine/demand.h"

namespace lode::hierarchical_delaunay {

/// A mesh whose triangles all satisfy the demand, which sees a triangle's error, the heights in it
/// and its bounds in the world, with twins and errors; on the fine lattice. Triangles are refined
/// while they do not satisfy it. Where one then has a neighbour whose edge to it is a chain, the
/// constrained Delaunay triangulation between its own corners and the chain stands for it, if that,
/// measured anew at all samples in it and where its edges cross columns and rows, satisfies the
/// demand, and else it is refined, too: so the mesh conforms, and what it says of its errors holds.
/// Triangles of the last level are all that there is. The grid is the one that the model,
/// `hierarchy` and `chains`, was built of: it must have its samples.
[[nodiscard]] Result<delaunay::Tin> tin_of_demand(const triangle_hierarchy::Hierarchy& hierarchy,
                                                  const EdgeChains& chains, const FineGrid& grid,
                                                  const Demand& demand);

}  // namespace lode::hierarchical_delaunay
