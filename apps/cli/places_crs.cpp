#include "places_crs.h"

#include <fmt/format.h>

#include <cmath>

#include "lode/api/round_terrain.h"
#include "terrain_facts.h"

namespace lode::cli {

void add_places_crs(CLI::App& app, std::string& places_crs, const char* which) {
  app.add_option(
         "--places-crs", places_crs,
         fmt::format("CRS of {}, x east or longitude first (default: that of the terrain)", which))
      ->type_name("EPSG:N|WKT");
}

Result<void> check_places_crs(const std::string& places_crs) {
  if (places_crs.empty()) return {};
  const Result<void> status = check_target_crs(places_crs);
  if (!status) return fail("--places-crs: {}", status.error().message);
  return {};
}

Result<std::optional<SourceCrs>> open_places_crs(const std::string& places_crs,
                                                 const std::string& input, const HeightFrame& frame,
                                                 Session& session) {
  if (places_crs.empty()) return std::optional<SourceCrs>();
  const Place middle = frame.world((frame.n_columns - 1) / 2.0, (frame.n_rows - 1) / 2.0);
  auto source = open_source_crs(places_crs, frame.crs, middle);
  if (!source) return fail("{}: --places-crs: {}", input, source.error().message);
  if (source->is_guess)
    session.warn(fmt::format(
        "--places-crs: PROJ knows no way between the datums of {} and of the terrain, with the "
        "grids that are there, and takes one for the other: places may be off by hundreds of "
        "metres",
        source->name));
  return std::optional(*std::move(source));
}

Result<std::vector<Place>> places_of_terrain(const std::vector<Place>& given,
                                             const std::optional<SourceCrs>& source,
                                             const std::vector<std::string>& names) {
  std::vector<Place> places = given;
  if (!source) return places;
  source->map->apply(places);
  for (std::size_t i = 0; i < places.size(); ++i)
    if (std::isnan(places[i][0]))
      return fail(
          "--places-crs: {}: expected one that the CRS of the terrain has, got {:.12g}, {:.12g} of "
          "{}",
          i < names.size() ? names[i] : fmt::format("place {}", i + 1), given[i][0], given[i][1],
          source->name);
  return places;
}

Result<TerrainWay> way_on(const OpenedTerrain& opened, const HorizontalMetric& metric,
                          const std::optional<SourceCrs>& source, const TerrainWay& given) {
  LODE_TRY(const std::vector<Place> ends,
           places_of_terrain({given.from, given.to}, source, {"--from", "--to"}));
  const Place& from = ends[0];
  const Place& to = ends[1];
  if (opened.is_closed) return TerrainWay{from, nearest_turn(metric, from, to)};
  const double middle = (from[0] + to[0]) / 2;
  const Place turned{{turns_towards(metric, middle_x(opened.facts.frame), middle), 0}};
  return TerrainWay{from + turned, to + turned};
}

}  // namespace lode::cli
