#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/half_edge.h"

namespace lode::tetra_mt {

/// How a hierarchy numbers what a mesh has.
struct NodeOrder {
  std::vector<std::uint32_t> base_vertices;  ///< Of the mesh, those that no collapse removes.
  std::vector<std::uint32_t> nodes;          ///< By collapse.
};

/// Nodes in bands: first those that tetrahedra of the base wait for, which every query looks at;
/// then by the tolerance below which a query of the whole domain looks at them, each band about
/// seven times what of these comes before it. So what a tolerance asks for lies in the first bands.
/// In a band, and base vertices, along a space-filling curve, so that what is near has near
/// numbers. Unused vertices have none.
[[nodiscard]] NodeOrder order_nodes(const TetraMesh& mesh, const HalfEdgeCollapses& collapses);

}  // namespace lode::tetra_mt
