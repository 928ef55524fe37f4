#pragma once

#include "lode/api/tetra_dataset.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"

namespace lode {

/// As TetraDataset::build() says.
[[nodiscard]] Result<tetra_mt::HalfEdgeCollapses> collapse_mesh(const TetraMesh& mesh,
                                                                const TetraBuildOptions& options,
                                                                Progress& progress);
[[nodiscard]] Result<tetra_mt::Hierarchy> build_hierarchy(const TetraMesh& mesh,
                                                          const TetraBuildOptions& options,
                                                          Progress& progress);

[[nodiscard]] Result<tetra_mt::midpoint::Hierarchy> build_midpoints(
    const TetraMesh& mesh, const TetraBuildOptions& options, Progress& progress);

}  // namespace lode
