#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode::tetra_mt {

/// Fails where a mesh is not that of all nodes: vertices at the same places in the same order, bit
/// for bit, and the same tetrahedra in any order. `mesh_vertices`: by the hierarchy's vertex the
/// mesh's.
[[nodiscard]] Result<void> check_same_mesh(const PackedHierarchy& hierarchy,
                                           std::span<const std::uint32_t> mesh_vertices,
                                           const TetraMesh& mesh, Progress& progress);

/// The fields of a mesh for a hierarchy that was built of it with others, in one pass over its
/// nodes: all collapses again, each vertex that goes a sample of the tetrahedron that covers it.
/// Errors hold at samples; world errors are found where the hierarchy's first field has them.
/// Expects what check_same_mesh() does not fail on. Fails where pages cannot be loaded, a value is
/// not finite, or when cancelled.
[[nodiscard]] Result<std::vector<NumberedField>> measure_fields(
    const PackedHierarchy& hierarchy, std::span<const std::uint32_t> mesh_vertices,
    const TetraMesh& mesh, Progress& progress);

}  // namespace lode::tetra_mt
