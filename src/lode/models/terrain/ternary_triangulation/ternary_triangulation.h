#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/insertions/history.h"

namespace lode::ternary_triangulation {

/// The ternary triangulation (L. De Floriani, B. Falcidieno, G. Nagy, C. Pienovi, "A hierarchical
/// structure for surface approximation", 1984; paper 004, section 7.1): a triangle whose samples
/// err by more than max_error is joined to the worst of them, which makes three of it. A sample
/// on an edge splits the triangles on both sides, each into two, so that meshes match. The domain
/// and its outline are those of the Delaunay selector. As insertions, whose times are the meshes.
[[nodiscard]] Result<insertions::History> build(const HeightGrid& grid, double max_error,
                                                Progress& progress);

/// The parts that a triangle is split into, appended: three, or two at a sample on an edge; none of
/// triangles that stay. The triangle is their union, exactly.
void add_parts(const insertions::History& history, std::uint32_t t,
               std::vector<std::uint32_t>& parts);

/// How large the hierarchy is, as section 4 of paper 004 counts.
struct HierarchySize {
  std::uint64_t n_regions = 0;   ///< Of all subdivisions, but for the root's: each triangle once.
  std::uint64_t n_expanded = 0;  ///< Triangles of the finest mesh.
  std::uint32_t n_levels = 0;    ///< The most that are nested in each other, the base's one.
};
[[nodiscard]] HierarchySize size_of(const insertions::History& history);

}  // namespace lode::ternary_triangulation
