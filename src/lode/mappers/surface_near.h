#pragma once

#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/facet_grid.h"

namespace lode {

/// The triangles of a surface as facets, relative to its origin.
[[nodiscard]] std::vector<Facet> facets_of(const Surface& surface);

/// Whether places are near a surface of triangles. Safe from many threads.
class SurfaceNear {
 public:
  /// `distance`: world units, > 0.
  SurfaceNear(const Surface& surface, double distance)
      : origin_(surface.origin),
        distance_(distance),
        facets_(facets_of(surface)),
        grid_(facets_, distance) {}
  SurfaceNear(const SurfaceNear&) = delete;  // the grid refers to the facets
  SurfaceNear& operator=(const SurfaceNear&) = delete;
  ~SurfaceNear() = default;

  /// Within the distance of p, world units.
  [[nodiscard]] bool is_within(const Vec3d& p) const {
    return grid_.find(p - origin_, {.limit = distance_}).facet != FacetGrid::kNone;
  }

 private:
  Vec3d origin_;
  double distance_;
  std::vector<Facet> facets_;
  FacetGrid grid_;
};

}  // namespace lode
