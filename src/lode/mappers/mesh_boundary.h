#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// The faces of a mesh of tetrahedra that one cell alone has: triangles, counter-clockwise seen
/// from outside, with the field's value and attributes at each vertex, the cell's error and region
/// and the patch of each triangle, and positions relative to `origin`. Vertices in the order of the
/// mesh's. Closed, and as manifold as the mesh is: where cells meet in an edge or corner only, so
/// does the surface; a face of three cells or more is none of it. With `patches`, places of some,
/// only their faces, and what is left may be open. O(cells), 64 bytes each for a while.
[[nodiscard]] Surface mesh_boundary(const SimplexMesh& mesh, const Vec3d& origin, Threads threads,
                                    std::span<const std::uint32_t> patches = {});

/// Keeps the cells whose values lie from `low` to `high` everywhere, that is at all four corners,
/// and the vertices that these have, in their order; of `vertex_ids`, unless it is empty, what
/// belongs to these. Returns how many cells are left out. O(cells).
std::uint64_t keep_cells_within(SimplexMesh& mesh, double low, double high,
                                std::vector<std::uint32_t>& vertex_ids);
/// The same of the cells of some regions. Expects the mesh to have regions.
std::uint64_t keep_regions(SimplexMesh& mesh, std::span<const std::int64_t> regions,
                           std::vector<std::uint32_t>& vertex_ids);

}  // namespace lode
