// What must hold of collapses, whatever their order.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <vector>

#include "lode/models/tetra_mt/half_edge.h"

namespace lode::test {

/// Of collapses that succeed.
[[nodiscard]] tetra_mt::HalfEdgeCollapses collapsed(const TetraMesh& mesh, std::uint64_t base_cells,
                                                    const tetra_mt::CollapseRules& rules,
                                                    Threads threads);

[[nodiscard]] std::vector<std::array<std::uint32_t, 2>> pairs(
    const tetra_mt::HalfEdgeCollapses& result);

[[nodiscard]] std::set<std::uint32_t> vertices_of(
    const std::vector<std::array<std::uint32_t, 4>>& tetrahedra);

/// Conforming, of the same volume, of the same range, and what its collapses make.
void expect_simpler(const TetraMesh& mesh, const tetra_mt::HalfEdgeCollapses& result);

/// By brute force, at all samples that went.
void expect_errors_true(const TetraMesh& mesh, const tetra_mt::HalfEdgeCollapses& result);

}  // namespace lode::test
