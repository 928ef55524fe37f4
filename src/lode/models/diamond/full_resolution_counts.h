#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/isovalue_list.h"

namespace lode::diamond {

/// Triangles and vertices at tolerance 0 of a volume without holes, for all isovalues in one pass
/// over the samples: which of them cross an edge or a tetrahedron follows from the ranks of its
/// ends or vertices, so these are added up by rank (see NetSlice). Bricks whose range misses all
/// isovalues are not read. A progress that is cancelled leaves sums that mean nothing.
[[nodiscard]] CrossingSums count_full_resolution(const Model<3>& model,
                                                 const IsovalueList& isovalues, Threads threads,
                                                 Progress& progress);

/// The same for one isovalue, from its sign bits: for one or two it is faster.
[[nodiscard]] CrossingSums::Counts count_full_resolution(const Model<3>& model, double isovalue,
                                                         Threads threads, Progress& progress);

}  // namespace lode::diamond
