#include "lode/api/mapped_terrain.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "lode/api/terrain_selection.h"
#include "lode/core/out_of_memory.h"
#include "lode/core/stopwatch.h"
#include "lode/delaunay/predicates.h"
#include "lode/mappers/tin_surface.h"

namespace lode {
namespace {

/// Of vertices. Fails where there are none in the other CRS.
Result<std::vector<Vec<double, 2>>> map_vertices(const delaunay::Tin& tin, const HeightFrame& frame,
                                                 const TerrainMapOptions& mapping,
                                                 Progress& progress) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 16;
  const std::size_t n = tin.vertices.size();
  std::vector<Vec<double, 2>> places;
  places.reserve(n);
  for (const LatticePoint& p : tin.vertices) places.push_back(frame.world(p.x, p.y));
  for (std::size_t first = 0; first < n; first += kAtOnce) {
    if (progress.is_cancelled()) return cancelled_error();
    mapping.map.apply(std::span(places).subspan(first, std::min(kAtOnce, n - first)));
    progress.report("mapping", static_cast<double>(first) / static_cast<double>(n));
  }
  const auto is_none = [](const Vec<double, 2>& p) { return std::isnan(p[0]); };
  const auto first = std::ranges::find_if(places, is_none);
  if (first == places.end()) return places;
  const LatticePoint& node = tin.vertices[static_cast<std::size_t>(first - places.begin())];
  const Vec<double, 2> at = frame.world(node.x, node.y);
  return fail(
      "expected terrain that lies where {} is of use, got {} of {} vertices that PROJ finds no "
      "place for in it, the first at {}, {}: clip the terrain, or choose a CRS for its area",
      mapping.name, std::ranges::count_if(places, is_none), n, at[0], at[1]);
}

Result<void> check_turns(const delaunay::Tin& tin, const HeightFrame& frame,
                         std::span<const Vec<double, 2>> places, const std::string& name) {
  std::uint64_t n_turned = 0;
  Vec<double, 2> at{};
  for (const auto& [a, b, c] : turning_left_in_world(tin, frame)) {
    if (delaunay::orientation(places[a], places[b], places[c]) > 0) continue;
    if (n_turned++ == 0) at = frame.world(tin.vertices[a].x, tin.vertices[a].y);
  }
  if (n_turned == 0) return {};
  return fail(
      "expected triangles that keep their turn in {}, got {} of {} that turn over or get flat, the "
      "first at {}, {}: where long edges bend beyond thin triangles a smaller tolerance helps, or "
      "a model of right triangles (right_triangle_bisection); where a seam or pole of the CRS is "
      "crossed clip the terrain, or choose a CRS for its area",
      name, n_turned, tin.triangles.size(), at[0], at[1]);
}

Result<MeasuredSamples> kept_vertices(const Terrain& terrain, const TerrainOptions& options,
                                      Progress& progress) {
  const TerrainOptions finest{.max_error = terrain.origin().finest_error(),
                              .threads = options.threads};
  LODE_TRY(SelectedTerrain all,
           terrain.origin().select(finest, delaunay::TinLinks::left_out, progress));
  auto nodes = std::make_shared<NodeHeights>();
  nodes->frame = terrain.frame();
  nodes->nodes = std::move(all.tin.vertices);
  nodes->heights = std::move(all.tin.heights);
  return MeasuredSamples(std::shared_ptr<const NodeHeights>(std::move(nodes)));
}

}  // namespace

Result<MappedTerrain> extract_mapped_terrain(const Terrain& terrain, const TerrainOptions& options,
                                             const TerrainMapOptions& mapping,
                                             Progress& progress) try {
  const Stopwatch watch;
  const HeightFrame& frame = terrain.frame();
  MappedTerrain mapped;
  if (mapping.clip) mapped.terrain.clip.emplace();
  LODE_TRY(SelectedTerrain selected,
           mapping.clip
               ? select_clipped(terrain, options, *mapping.clip, *mapped.terrain.clip, progress)
               : terrain.origin().select(options, delaunay::TinLinks::left_out, progress));
  TerrainReport& report = mapped.terrain.report;
  report = selected.report;
  report.seconds = watch.seconds();
  const Stopwatch map_watch;
  const delaunay::Tin& tin = selected.tin;
  LODE_TRY(const auto places, map_vertices(tin, frame, mapping, progress));
  LODE_CHECK(check_turns(tin, frame, places, mapping.name));
  std::optional<MeasuredSamples> samples = mapping.samples;
  if (!samples) {
    mapped.measured_at = MeasuredAt::kept_vertices;
    LODE_TRY(samples, kept_vertices(terrain, options, progress));
  }
  LODE_TRY(mapped.errors,
           measure_mapped({tin, frame, places}, mapping.map, *samples, options.threads, progress));
  std::vector<Vec3d> vertices;
  vertices.reserve(places.size());
  for (std::size_t i = 0; i < places.size(); ++i)
    vertices.push_back({{places[i][0], places[i][1], tin.heights[i]}});
  TinSurface made = to_surface(tin, std::move(vertices),
                               frame.is_mirrored() ? TriangleTurns::right : TriangleTurns::left);
  report.height_slack = made.height_slack;
  report.position_slack = made.position_slack;
  report.n_turned = made.n_turned;
  mapped.terrain.surface = std::move(made.surface);
  mapped.terrain.places = std::move(made.places);
  mapped.seconds = map_watch.seconds();
  return mapped;
} catch (const std::bad_alloc&) {
  return out_of_memory("transform the terrain");
}

}  // namespace lode
