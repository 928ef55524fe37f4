#include "lode/api/opened_terrain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <new>
#include <numbers>
#include <utility>

#include "lode/api/files.h"
#include "lode/api/round_terrain.h"
#include "lode/api/terrain_features.h"
#include "lode/core/out_of_memory.h"
#include "lode/io/crs_metric.h"
#include "lode/io/line_file.h"
#include "lode/io/polygon_file.h"
#include "lode/locate/polygon_locator.h"
#include "lode/store/reader.h"

namespace lode {
namespace {

TerrainFacts facts_of(const BuiltTerrain& built) {
  const BuiltTerrainInfo info = built.describe_source();
  return {.frame = built.frame(),
          .format = "LODE",
          .type = info.sample_type,
          .has_place = info.has_place,
          .n_missing = info.n_missing,
          .is_of_points = info.is_of_points};
}

OpenedTerrain of_built(BuiltTerrain built) {
  Terrain terrain = built.terrain();
  TerrainFacts facts = facts_of(built);
  const TerrainModel model = built.model();
  auto samples = built.samples();
  return {.terrain = std::move(terrain),
          .model = model,
          .facts = std::move(facts),
          .built = std::move(built),
          .samples = std::move(samples)};
}

/// Names the file, unless the reason is that the user stopped.
template <typename T>
Result<T> naming(const std::string& path, Result<T> result, const Progress& progress) {
  if (result || progress.is_cancelled()) return result;
  return fail("{}: {}", path, result.error().message);
}

TerrainFacts point_facts_of(const io::PointFile& file, const PointTerrain& terrain) {
  const HeightPoints& points = terrain.points;
  return {.frame = points,
          .format = file.format,
          .type = "points",
          .has_place = true,
          .n_missing = file.counts.n_missing,
          .points = PointFacts{.counts = file.counts,
                               .has_classes = file.has_classes(),
                               .crs_note = file.crs_note,
                               .n_nodes = points.nodes.size(),
                               .n_outside = terrain.n_outside,
                               .n_left_out = terrain.domain.n_left_out,
                               .n_outline = terrain.domain.outline.size(),
                               .n_repeated = points.n_repeated,
                               .largest_spread = points.largest_spread,
                               .largest_move = points.largest_move,
                               .step = points.step()},
          .vertical = file.vertical};
}

/// Of places, those in polygons.
std::uint64_t count_in(std::span<const PlacePolygon> polygons, std::span<const Vec3d> places) {
  const PolygonLocator outline(polygons);
  return static_cast<std::uint64_t>(std::ranges::count_if(places, [&](const Vec3d& place) {
    return outline.holds({{place[0], place[1]}});
  }));
}

/// Points on both sides of where longitudes jump, side by side, and their outline with them; how
/// many of those in it were moved, and by a turn.
std::uint64_t bring_together(const HorizontalMetric& metric, io::PointFile& file,
                             PointTerrainOptions& domain) {
  const auto from = turn_from(metric, file.points);
  if (!from) return 0;
  // Where a turn is no number of steps, points would be moved to nodes of another lattice.
  const double n_steps = whole_turn(metric) / file.lattice.step;
  constexpr double kRounding = 1e-3;
  if (!(std::abs(n_steps - std::round(n_steps)) < kRounding)) file.lattice = {};
  std::vector<Vec3d> moved;
  for (const Vec3d& p : file.points)
    if (p[0] < *from) moved.push_back(p);
  turn_places(metric, *from, moved);
  const std::uint64_t n_turned = turn_places(metric, *from, file.points);
  if (domain.outline.empty()) return n_turned;
  domain.outline = turn_polygons(metric, *from, std::move(domain.outline));
  domain.is_outline_near = true;
  return count_in(domain.outline, moved);
}

/// Lines without jumps of longitudes, and those that are whole turns away from a terrain's there:
/// at both ends of a terrain where they reach over one that is the other again.
void bring_near(const HeightFrame& frame, std::vector<PlaceLine>& lines) {
  const Result<HorizontalMetric> metric = io::read_metric(frame.crs);
  if (!metric || !metric->ellipsoid) return;
  const auto [first, last] = std::minmax(
      {frame.world(0, 0)[0], frame.world(frame.n_columns - 1, 0)[0],
       frame.world(0, frame.n_rows - 1)[0], frame.world(frame.n_columns - 1, frame.n_rows - 1)[0]});
  const double turn = whole_turn(*metric);
  const std::size_t n = lines.size();
  for (std::size_t i = 0; i < n; ++i) {
    unroll(*metric, lines[i]);
    const auto [west, east] =
        std::ranges::minmax(lines[i], {}, [](const Vec3d& p) { return p[0]; });
    const double shift = turns_towards(*metric, middle_x(frame), (west[0] + east[0]) / 2);
    for (Vec3d& p : lines[i]) p[0] += shift;
    if (!is_longitude(*metric, west[0]) || !is_longitude(*metric, east[0])) continue;
    for (const double other : {-turn, turn}) {
      const bool is_there = west[0] + shift + other < last && east[0] + shift + other > first;
      if (!is_there) continue;
      PlaceLine copy = lines[i];
      for (Vec3d& p : copy) p[0] += other;
      lines.push_back(std::move(copy));
    }
  }
}

Result<TerrainLineOptions> read_line_options(const TerrainReadOptions& options,
                                             const HeightFrame& frame, const HeightRange& range) {
  constexpr double kDefaultShare = 0.0025;
  TerrainLineOptions lines;
  lines.least_relief = options.least_relief;
  if (options.keeps_features && !lines.least_relief) lines.least_relief = default_relief(range);
  lines.is_draped = options.is_draped;
  const double share = options.drape_share.value_or(kDefaultShare);
  lines.drape_error =
      options.drape_error.value_or(std::max(0.0, share * (range.upper - range.lower)));
  if (options.breaklines.empty()) return lines;
  LODE_TRY(io::LineFile file, io::read_lines(options.breaklines, frame.crs));
  lines.breaklines = std::move(file.lines);
  lines.n_points = file.n_points;
  bring_near(frame, lines.breaklines);
  return lines;
}

/// Of what was opened without.
template <typename Source>
Result<void> open_lines(const std::string& path, const TerrainReadOptions& options, Source source,
                        const HeightRange& range, OpenedTerrain& opened, Progress& progress) {
  LODE_TRY(const TerrainLineOptions lines, read_line_options(options, opened.facts.frame, range));
  LODE_TRY(LinedTerrain made,
           naming(path, add_lines(std::move(source), lines, progress), progress));
  opened.points = std::make_shared<const PointTerrain>(std::move(made.terrain));
  opened.terrain = to_terrain(opened.points);
  opened.lines = made.report;
  return {};
}

Result<OpenedTerrain> open_points(const std::string& path, const TerrainReadOptions& options,
                                  Progress& progress) {
  PointTerrainOptions domain = options.domain;
  io::PolygonFile outline;
  if (!options.outline.empty()) {
    LODE_TRY(outline, io::read_polygons(options.outline));
  }
  LODE_TRY(io::PointFile file, io::read_points(path, options.points, progress));
  if (!options.outline.empty()) {
    LODE_TRY(domain.outline, io::polygons_in(outline, file.crs));
  }
  LODE_TRY(const HorizontalMetric metric, naming(path, io::read_metric(file.crs), progress));
  const std::uint64_t n_turned = bring_together(metric, file, domain);
  LODE_TRY(PointTerrain made,
           naming(path, make_point_terrain(file.points, file.lattice, metric, domain, progress),
                  progress));
  made.points.crs = file.crs;
  made.points.vertical_unit = file.vertical_unit;
  TerrainFacts facts = point_facts_of(file, made);
  facts.points->n_turned = n_turned;
  auto points = std::make_shared<const PointTerrain>(std::move(made));
  OpenedTerrain opened{.terrain = to_terrain(points), .facts = std::move(facts), .points = points};
  if (options.has_lines())
    LODE_CHECK(open_lines(path, options, *points, height_range(points->points), opened, progress));
  return opened;
}

/// Of points, or of a raster with lines: what was opened becomes what was built of it.
Result<void> build_of_points(const std::string& path, const TerrainBuildOptions& building,
                             OpenedTerrain& opened, Progress& progress) {
  TerrainBuildOptions options = building;
  options.sample_type = opened.facts.type;
  options.has_place = opened.facts.has_place;
  LODE_TRY(BuiltTerrain built,
           naming(path, BuiltTerrain::build(*opened.points, options, progress), progress));
  opened.terrain = built.terrain();
  opened.model = built.model();
  opened.facts.is_of_points = true;
  opened.built = std::move(built);
  return {};
}

Error not_round(const HeightGrid& grid, const HorizontalMetric& metric) {
  const double degrees = metric.angle_unit * 180 / std::numbers::pi;
  if (const auto row = first_row_apart(grid, metric))
    return fail(
        "wrap: expected a last column with the heights of the first, whose place it has, got "
        "others, first in row {}",
        *row);
  const std::string got = metric.ellipsoid ? fmt::format("{} columns, {} degrees apart",
                                                         grid.n_columns, grid.to_world[1] * degrees)
                                           : "one in no geographic CRS";
  return fail(
      "wrap: expected a raster from west to east whose columns go all the way round, 360 "
      "degrees, got {}",
      got);
}

/// The ends of the options' way, in the raster's CRS.
Result<std::array<Vec<double, 2>, 2>> way_of(const TerrainReadOptions& options,
                                             const HeightGrid& grid) {
  std::array<Vec<double, 2>, 2> way = *options.way;
  if (options.way_crs.empty()) return way;
  LODE_TRY(const io::SourceCrs source,
           io::open_source_crs(options.way_crs, grid.crs,
                               grid.world((grid.n_columns - 1) / 2.0, (grid.n_rows - 1) / 2.0)));
  source.map->apply(way);
  return way;
}

/// As the options say; whether it was. `goes_round`: whether it could be.
Result<bool> close_round(const TerrainReadOptions& options, HeightGrid& grid, bool& goes_round) {
  if (options.is_wrapped && options.has_lines())
    return fail("wrap: expected no breaklines or features with it, got some");
  const bool is_wanted = options.is_wrapped || options.is_closed || options.way;
  const Result<HorizontalMetric> read = io::read_metric(grid.crs);
  if (!read && is_wanted) return read.error();
  if (!read) return false;
  const HorizontalMetric& metric = *read;
  const auto n_turn = columns_of_turn(grid, metric);
  goes_round = n_turn.has_value();
  if (options.is_wrapped && !n_turn) return not_round(grid, metric);
  if (!n_turn || !is_wanted || options.has_lines()) return false;
  double at = grid.to_world[0];
  if (options.way) {
    LODE_TRY(const auto way, way_of(options, grid));
    if (!is_longitude(metric, way[0][0]) || !is_longitude(metric, way[1][0])) return false;
    at = std::min(way[0][0], nearest_turn(metric, way[0], way[1])[0]);
  }
  grid = cut_open_at(grid, *n_turn, at);
  return true;
}

/// What of its lines a model of a raster keeps that has no edges of points.
Result<void> keep_features(const std::string& path, const TerrainReadOptions& reading,
                           const HeightGrid& grid, TerrainBuildOptions& building,
                           TerrainLineReport& report, Progress& progress) {
  LODE_TRY(const TerrainLineOptions wanted, read_line_options(reading, grid, height_range(grid)));
  if (!is_hierarchy(building.model)) {
    LODE_TRY(
        building.kept,
        naming(path, find_feature_nodes(grid, *wanted.least_relief, report, progress), progress));
    return {};
  }
  LODE_TRY(LinedTerrain lined, naming(path, add_lines(grid, wanted, progress), progress));
  building.lined = std::make_shared<const PointTerrain>(std::move(lined.terrain));
  report = lined.report;
  return {};
}

/// Whether a model of a raster is one of its samples and lines as points. Hierarchies of
/// triangulations have features, which run between samples, without that.
bool is_built_of_points(const TerrainReadOptions& reading, TerrainModel model) {
  return reading.has_lines() && is_of_any_points(model) &&
         (!is_hierarchy(model) || !reading.breaklines.empty());
}

/// A model of a raster itself, and not of its samples as points.
Result<OpenedTerrain> build_of_raster(const std::string& path, const TerrainReadOptions& reading,
                                      const TerrainBuildOptions& building, io::HeightRaster read,
                                      Progress& progress) {
  if (!reading.breaklines.empty())
    return fail(
        "{}: expected no breaklines with a {}, got some: the delaunay_selector takes them, the "
        "delaunay_pyramid, the ternary_triangulation, the implicit_delaunay_pyramid, the "
        "adaptive_triangulation and the hierarchical_delaunay; other models features",
        path, name_of(building.model));
  TerrainBuildOptions options = building;
  options.sample_type = read.type;
  options.has_place = read.has_place;
  std::optional<TerrainLineReport> lines;
  if (reading.has_lines())
    LODE_CHECK(keep_features(path, reading, read.grid, options, lines.emplace(), progress));
  LODE_TRY(BuiltTerrain built,
           naming(path, BuiltTerrain::build(read.grid, options, progress), progress));
  OpenedTerrain opened = of_built(std::move(built));
  opened.facts.form = read.form;
  opened.facts.vertical = read.vertical;
  opened.lines = lines;
  if (!opened.samples && reading.keeps_samples) {
    const auto raster = std::make_shared<const io::HeightRaster>(std::move(read));
    opened.samples = {raster, &raster->grid};
  }
  return opened;
}

Result<OpenedTerrain> open_raster(const std::string& path, const TerrainReadOptions& reading,
                                  const std::optional<TerrainBuildOptions>& building,
                                  Progress& progress) {
  LODE_TRY(io::HeightRaster read, io::read_heights(path, reading.raster, progress));
  TerrainFacts facts = lode::facts_of(read);
  LODE_TRY(const bool is_closed,
           naming(path, close_round(reading, read.grid, facts.goes_round), progress));
  if (building && !is_built_of_points(reading, building->model)) {
    LODE_TRY(OpenedTerrain opened,
             build_of_raster(path, reading, *building, std::move(read), progress));
    opened.is_closed = is_closed;
    return opened;
  }
  const auto raster = std::make_shared<const io::HeightRaster>(std::move(read));
  const std::shared_ptr<const HeightGrid> grid(raster, &raster->grid);
  OpenedTerrain opened{.terrain = Terrain(grid), .facts = std::move(facts), .grid = grid};
  opened.is_closed = is_closed;
  // Lines may change heights.
  if (!reading.has_lines()) opened.samples = grid;
  if (reading.has_lines())
    LODE_CHECK(
        open_lines<const HeightGrid&>(path, reading, *grid, height_range(*grid), opened, progress));
  if (building) LODE_CHECK(build_of_points(path, *building, opened, progress));
  return opened;
}

}  // namespace

TerrainFacts facts_of(const io::HeightRaster& raster) {
  return {.frame = raster.grid,
          .format = raster.format,
          .type = raster.type,
          .has_place = raster.has_place,
          .n_missing = raster.grid.n_missing(),
          .form = raster.form,
          .vertical = raster.vertical};
}

std::optional<MeasuredSamples> measured_samples(const OpenedTerrain& opened) {
  if (opened.samples) return MeasuredSamples(opened.samples);
  if (!opened.points) return {};
  const PointTerrain& terrain = *opened.points;
  auto kept = std::make_shared<NodeHeights>();
  kept->frame = terrain.points;
  for (std::size_t i = 0; i < terrain.points.nodes.size(); ++i) {
    if (terrain.domain.triangle_of[i] == delaunay::kNoHalfEdge) continue;
    kept->nodes.push_back(terrain.points.nodes[i]);
    kept->heights.push_back(terrain.points.heights[i]);
  }
  return MeasuredSamples(std::shared_ptr<const NodeHeights>(std::move(kept)));
}

bool holds_terrain_model(const std::string& path) {
  return is_lode_path(path) && BuiltTerrain::is_model_of(path);
}

Result<void> check_lode_opens(const std::string& path) {
  LODE_TRY(const auto reader, store::Reader::open(path));
  static_cast<void>(reader);
  return {};
}

bool holds_terrain(const std::string& path) {
  return io::is_height_path(path) || io::is_point_path(path) || holds_terrain_model(path);
}

Result<OpenedTerrain> open_terrain(const std::string& path, const TerrainReadOptions& reading,
                                   const std::optional<TerrainBuildOptions>& building,
                                   Progress& progress) try {
  if (is_lode_path(path)) {
    LODE_TRY(BuiltTerrain opened, BuiltTerrain::open(path, progress));
    return of_built(std::move(opened));
  }
  if (io::is_point_path(path) && building && !is_of_any_points(building->model))
    return fail("{}: expected a raster to build a {} of, got scattered points", path,
                name_of(building->model));
  if (io::is_point_path(path)) {
    LODE_TRY(OpenedTerrain opened, open_points(path, reading, progress));
    if (building) LODE_CHECK(build_of_points(path, *building, opened, progress));
    return opened;
  }
  return open_raster(path, reading, building, progress);
} catch (const std::bad_alloc&) {
  return out_of_memory("open the terrain", path);
}

}  // namespace lode
