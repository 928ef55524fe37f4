#pragma once

#include <cstddef>
#include <span>

#include "lode/api/tetra_cut_source.h"
#include "lode/api/tetra_dataset.h"
#include "lode/api/verify_report.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"

namespace lode {

/// Checks a hierarchy by what it says of its reference mesh, which is that of all nodes: its nodes
/// and their order; that random cuts conform, have no cell turned round and fill the same domain;
/// and their stated errors and ranges, and those of uniform tolerances, by a search for each vertex
/// of the reference, and, where it is exact, in the overlay of both. What is wrong with the
/// reference itself counts as right. Where nodes do not fit together no cuts are looked at. Fails
/// where pages cannot be loaded, or when cancelled.
[[nodiscard]] Result<VerifyReport> verify_hierarchy(const TetraCutSource& source,
                                                    const TetraVerifyOptions& options,
                                                    Progress& progress);

/// Compares the mesh of all nodes with the one that it was built from: tetrahedra, and the vertices
/// and values that these have, bit for bit, whatever their order. Vertices with equal positions and
/// values count as equal. `fields`: of the hierarchy, those of the original, in its order.
[[nodiscard]] Result<VerifyReport> compare_with_original(const TetraCutSource& source,
                                                         const TetraMesh& original,
                                                         std::span<const std::size_t> fields,
                                                         Progress& progress);

}  // namespace lode
