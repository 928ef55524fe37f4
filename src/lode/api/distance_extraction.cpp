#include "lode/api/distance_extraction.h"

#include <algorithm>
#include <cmath>

#include "lode/core/stopwatch.h"
#include "lode/models/diamond/distance_cut.h"

namespace lode {

void add_distance(const diamond::DistanceCutReport& found, double seconds, ExtractReport& report) {
  DistanceReport& distance = *report.distance;
  distance.proven_distance = std::max(distance.proven_distance, found.proven);
  distance.rounds += found.n_rounds;
  distance.nodes_refined += found.n_nodes;
  distance.full_triangles += found.n_full_triangles;
  distance.lost_triangles += found.n_lost;
  distance.lost_size = std::max(distance.lost_size, found.lost_size);
  report.seconds.distance += seconds;
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

Result<diamond::IsosurfaceReport> extract_within_distance(const Dataset::Impl& impl,
                                                          diamond::IsosurfaceQuery query,
                                                          const ExtractOptions& options,
                                                          Surface& surface, ExtractReport& report,
                                                          Progress& progress) {
  if (!report.distance) report.distance = DistanceReport{.max_distance = *options.max_distance};
  LODE_TRY(const auto* const held, impl.model(progress));
  const auto& model = std::get<diamond::Model<3>>(*held);
  if (query.tolerance == 0) {  // it is the surface that it is to be near
    const std::size_t n_before = query.replaces ? 0 : surface.triangles.size();
    auto part = diamond::extract_isosurface<3>(model, query, surface, progress);
    report.distance->full_triangles += surface.triangles.size() - n_before;
    return part;
  }
  const Stopwatch watch;
  LODE_TRY(const auto worlds, impl.world_errors(progress));
  LODE_TRY(const diamond::DistanceCut cut,
           diamond::find_distance_cut(model, query, *options.max_distance, *worlds, progress));
  add_distance(cut.report, watch.seconds(), report);
  query.wanted = &cut.nodes;
  return diamond::extract_isosurface<3>(model, query, surface, progress);
}

}  // namespace lode
