#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/half_edge.h"

namespace lode::tetra_mt {

/// How a hierarchy numbers what a mesh has.
struct NodeOrder {
  std::vector<std::uint32_t> base_vertices;  ///< Of the mesh, those that no collapse removes.
  std::vector<std::uint32_t> nodes;          ///< By collapse.
};

/// Nodes in bands, of which each is about seven times what comes before it: first those that were
/// collapsed last, which depend on none of later bands. In a band, and base vertices, along a
/// space-filling curve, so that what is near has near numbers. Unused vertices have none.
[[nodiscard]] NodeOrder order_nodes(const TetraMesh& mesh, std::span<const Collapse> collapses);

}  // namespace lode::tetra_mt
