#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/mesh.h"
#include "lode/mappers/section.h"

namespace lode {

// Which tetrahedra a surface is made of: by cell, 1 or 0. O(cells), the boundary O(cells log
// cells).

/// Those with a face that no other has.
[[nodiscard]] std::vector<std::uint8_t> cells_at_boundary(const SimplexMesh& mesh);
/// Those that meet one of the planes.
[[nodiscard]] std::vector<std::uint8_t> cells_at_planes(const SimplexMesh& mesh,
                                                        std::span<const SectionPlane> planes);
/// Those with one of the values somewhere.
[[nodiscard]] std::vector<std::uint8_t> cells_with_values(const SimplexMesh& mesh,
                                                          std::span<const double> values);

/// Leaves tetrahedra that are marked, with their errors, and all vertices; errors of attributes are
/// then theirs. Regions and patches are not looked after.
void keep_marked_cells(SimplexMesh& mesh, std::span<const std::uint8_t> is_marked);

}  // namespace lode
