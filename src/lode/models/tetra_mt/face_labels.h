#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// By tetrahedron of the closed mesh: its region, or interfaces.h's label of the patch on whose
/// face it is. Empty where there is one region and no patch.
[[nodiscard]] std::vector<std::uint32_t> labels_of(const TetraMesh& mesh,
                                                   std::span<const Tetrahedron> closed);

}  // namespace lode::tetra_mt
