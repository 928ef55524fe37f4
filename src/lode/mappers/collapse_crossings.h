#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {

/// Pairs of triangles, at least one of them among `triangles`, that meet anywhere but at common
/// corners and edges, exactly; {t, t} for one of zero area, or with a corner that collapses have
/// moved onto another vertex. Corners that collapses have not moved are common where coordinates
/// are equal. Sorted, each once. `live`: all triangles that are there, ascending.
[[nodiscard]] Result<std::vector<std::array<std::uint32_t, 2>>> find_crossings(
    const CollapseMesh& mesh, std::span<const std::uint32_t> live,
    std::span<const std::uint32_t> triangles, Threads threads, Progress& progress);

}  // namespace lode::simplification
