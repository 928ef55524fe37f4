#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/midpoint/field_records.h"
#include "lode/models/tetra_mt/midpoint/forest.h"

namespace lode::tetra_mt::midpoint {

/// The fields of a mesh for a forest that was built of it with others, in one pass over its
/// collapses; records as make_field() makes them, without times. `mesh_vertices`: by leaf the
/// mesh's vertex, as ReferenceMesh::match() says. Fails as repeat_collapses() does, and where pages
/// cannot be loaded.
[[nodiscard]] Result<std::vector<FieldRecords>> measure_fields(
    const Forest& forest, std::span<const std::uint32_t> mesh_vertices, const TetraMesh& mesh,
    Threads threads, Progress& progress);

}  // namespace lode::tetra_mt::midpoint
