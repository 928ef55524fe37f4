#pragma once

#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"

namespace lode::tetra_mt::midpoint {

/// Of the collapses: what was asked of them.
struct RepeatRules {
  double boundary_tolerance = 0;
  bool has_world_errors = false;
};

/// What is known of collapses that were chosen for other fields.
struct RepeatedCollapses {
  std::vector<EdgeFacts> facts;  ///< By collapse and field.
  std::vector<float> errors;     ///< EdgeCollapses'.
};

/// Does collapses of a mesh again, to measure its fields: in one pass, each vertex that goes a
/// sample of the tetrahedron that covers it. Whatever the order, of those that collapse_edges() may
/// have taken in, what comes of each collapse and field is, bit for bit, what that finds with this
/// field among its own. Where one end is a maximum of a field and the other a minimum, which that
/// does not collapse, the new vertex has the value that lies where it does. Fails as
/// collapse_edges() does, where a collapse is none of the mesh, and when cancelled.
[[nodiscard]] Result<RepeatedCollapses> repeat_collapses(const TetraMesh& mesh,
                                                         std::span<const EdgeCollapse> collapses,
                                                         const RepeatRules& rules, Threads threads,
                                                         Progress& progress);

}  // namespace lode::tetra_mt::midpoint
