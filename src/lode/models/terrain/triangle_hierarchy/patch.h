#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/terrain/triangle_hierarchy/reference_surface.h"

namespace lode::triangle_hierarchy {

/// Triangles whose corners are places, by their numbers, turning left.
struct Patch {
  std::vector<Place> places;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The coarsest triangulation of a surface's domain.
[[nodiscard]] Patch base_patch(const ReferenceSurface& surface);

/// A mesh of a surface's domain for level 0, in place of the selector's from the coarsest one. Its
/// places are samples; each line is an edge of it, or a chain of edges on it: see Hierarchy::lines.
struct FirstMesh {
  Patch patch;
  std::vector<std::array<std::uint32_t, 2>> lines;  ///< By places.
};

/// Whether samples on the outline of a patch may be inserted.
enum class Outline : std::uint8_t { fixed, open };

/// What has become of a patch.
struct SelectedPatch {
  Patch patch;                        ///< New places follow the old ones.
  std::vector<double> sample_errors;  ///< By triangle, the largest of all samples in it.
};

/// The Delaunay selector in a patch (paper 004, sections 3 and 7.3): the worst sample is inserted,
/// again and again, until all that may be are within the limit; edges but the outline's stay
/// Delaunay. Of samples with equal errors the first in rows. The patch is constrained Delaunay.
/// O(N n log n) in the worst case for N samples, n of them inserted. Fails when cancelled.
[[nodiscard]] Result<SelectedPatch> select_samples(const ReferenceSurface& surface, Patch patch,
                                                   double limit, Outline outline,
                                                   Progress& progress);

}  // namespace lode::triangle_hierarchy
