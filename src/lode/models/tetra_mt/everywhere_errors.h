#pragma once

#include <cstdint>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/half_edge.h"

namespace lode::tetra_mt {

struct EverywhereReport {
  std::uint64_t n_faces = 0;     ///< That were compared with the reference.
  std::uint64_t n_by_range = 0;  ///< Of these by nothing but F's range.
};

/// Makes each collapse's errors, which hold at samples, hold everywhere: at least |F - F'| at all
/// points of the domain in the tetrahedra that come of it. Both are linear where a tetrahedron of
/// the reference and one of the cut meet, so it is largest at corners of what they have in common:
/// vertices of the reference, which are samples, and points on faces of the cut's, which
/// ReferenceOverlay finds. As good as the mesh's boundary stays in its planes.
[[nodiscard]] Result<EverywhereReport> make_errors_hold_everywhere(const TetraMesh& mesh,
                                                                   HalfEdgeCollapses& collapses,
                                                                   Threads threads,
                                                                   Progress& progress);

}  // namespace lode::tetra_mt
