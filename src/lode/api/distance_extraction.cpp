#include "lode/api/distance_extraction.h"

#include <algorithm>
#include <cmath>

namespace lode {

void add_distance(const diamond::DistanceCutReport& found, ExtractReport& report) {
  DistanceReport& distance = *report.distance;
  distance.proven_distance = std::max(distance.proven_distance, found.proven);
  distance.rounds += found.n_rounds;
  distance.nodes_refined += found.n_nodes;
  distance.full_triangles += found.n_full_triangles;
  distance.lost_triangles += found.n_lost;
  distance.lost_size = std::max(distance.lost_size, found.lost_size);
}

Result<void> check_max_distance(const ExtractOptions& options) {
  if (!options.max_distance) return {};
  if (!(*options.max_distance > 0 && std::isfinite(*options.max_distance)))
    return fail("expected a finite max_distance > 0, got {}", *options.max_distance);
  if (options.style == SurfaceStyle::cubes)
    return fail("max_distance: expected style tetra with it, got cubes, which is not proven");
  if (options.border == Border::closed)
    return fail("max_distance: expected an open border with it, as caps are not proven");
  if (options.clip)
    return fail(
        "max_distance: expected no clip box with it: what lies near may be on its other side");
  if (options.min_component > 1)
    return fail("max_distance: expected all pieces kept with it, got min_component {}",
                options.min_component);
  return {};
}

}  // namespace lode
