#pragma once

#include <cstdint>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode::hierarchical_delaunay {

using triangle_hierarchy::ReferenceSurface;

struct HierarchicalDelaunay {
  triangle_hierarchy::Hierarchy hierarchy;
  /// Edges, once for each level, that stay beyond its tolerance between samples, as to refine them
  /// would fold a triangle's border.
  std::uint64_t n_edges_left = 0;
};

/// The hierarchical Delaunay triangulation (L. De Floriani, E. Puppo, "Hierarchical triangulation
/// for multiresolution surface description", ACM TOG 14 (1995)) by the algorithm of L. De Floriani,
/// P. Marzano, E. Puppo 1996, section 7.3 and figure 17. Level 0 is the Delaunay selector's mesh of
/// the domain, or what is given as `first`. At each further level the edges beyond its tolerance
/// at their crossings (ReferenceSurface::worst_crossing()) are refined into chains of vertices,
/// each from itself alone; then the triangles beyond it, or at such edges, are filled with the
/// Delaunay triangulation constrained by their chains, and the selector inserts samples, on no
/// chain, until all are within the tolerance. In the mesh of each level
/// - every sample of the domain is within the tolerance, in every triangle that holds it, up to
///   rounding, 2^-48 of the largest |height|;
/// - within what one refinement made, edges but its border are locally Delaunay, exactly.
/// The same for any number of threads. O(N n log n) in the worst case for N samples and n vertices.
/// Fails on tolerances that do not fall, and when cancelled; of a raster as FineGrid::make() does.
[[nodiscard]] Result<HierarchicalDelaunay> build(
    const ReferenceSurface& surface, std::span<const double> tolerances, Threads threads,
    Progress& progress, const triangle_hierarchy::FirstMesh* first = nullptr);
[[nodiscard]] Result<HierarchicalDelaunay> build(const HeightGrid& grid,
                                                 std::span<const double> tolerances,
                                                 Threads threads, Progress& progress);

}  // namespace lode::hierarchical_delaunay
