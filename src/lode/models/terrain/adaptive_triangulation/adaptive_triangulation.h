#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/adaptive_triangulation/splitting.h"
#include "lode/models/terrain/triangle_hierarchy/hierarchy.h"
#include "lode/models/terrain/triangle_hierarchy/patch.h"

namespace lode::adaptive_triangulation {

struct AdaptiveTriangulation {
  triangle_hierarchy::Hierarchy hierarchy;
  /// How often each Rule was applied.
  std::array<std::uint64_t, kRules> n_splits{};
  /// Edges, once for each level, that stay beyond its tolerance between samples, as to split them
  /// would turn a triangle over.
  std::uint64_t n_edges_left = 0;
};

/// The adaptive hierarchical triangulation by the iterative algorithm of L. De Floriani, P.
/// Marzano, E. Puppo 1996, section 7.2 and figure 16: triangles beyond a level's tolerance are
/// split by the five rules, on the edges that are beyond it at their worst crossings
/// (ReferenceSurface::worst_crossing()), and else at the worst sample, until no triangle is. The
/// initial triangulation, which the paper wants of surface-specific points, is the Delaunay
/// selector's within the first tolerance, or what is given as `first`. In the mesh of each level
/// - every sample of the domain is within the tolerance, in every triangle that holds it;
/// - so are all edges at their crossings, but for `n_edges_left`;
/// both up to rounding, 2^-48 of the largest |height|. The same for any number of threads. O(N n)
/// in the worst case for N samples and n vertices. Fails on tolerances that do not fall, and when
/// cancelled; of a raster as FineGrid::make() does.
[[nodiscard]] Result<AdaptiveTriangulation> build(
    const triangle_hierarchy::ReferenceSurface& surface, std::span<const double> tolerances,
    Threads threads, Progress& progress, const triangle_hierarchy::FirstMesh* first = nullptr);
[[nodiscard]] Result<AdaptiveTriangulation> build(const HeightGrid& grid,
                                                  std::span<const double> tolerances,
                                                  Threads threads, Progress& progress);

}  // namespace lode::adaptive_triangulation
