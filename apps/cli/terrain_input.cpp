#include "terrain_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "parse.h"
#include "place_file.h"
#include "point_facts.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

constexpr int kMaxBand = 65536;

VerticalOptions to_vertical_options(const TerrainArguments& arguments) {
  return {arguments.vertical_crs, arguments.to_vertical_crs};
}

Result<PointReadOptions> to_point_options(const TerrainArguments& arguments,
                                          const ReadingArguments& reading) {
  constexpr std::int64_t kMostClasses = 255;
  PointReadOptions options;
  std::string_view rest = arguments.classes;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(','), rest.size());
    LODE_TRY(const auto one,
             parse_integer("--class", std::string(rest.substr(0, end)), 0, kMostClasses));
    options.classes.push_back(static_cast<std::uint8_t>(one));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  options.crs = arguments.crs;
  options.vertical = to_vertical_options(arguments);
  if (!reading.nodata.empty()) {
    LODE_TRY(options.nodata, parse_number("--nodata", reading.nodata));
  }
  return options;
}

/// But for the outline, which is in a file.
Result<PointTerrainOptions> to_domain_options(const TerrainArguments& arguments) {
  PointTerrainOptions options;
  const std::string& duplicates = arguments.duplicates;
  if (duplicates == "min") {
    options.repeated = RepeatedHeights::lowest;
  } else if (duplicates == "max") {
    options.repeated = RepeatedHeights::highest;
  } else if (duplicates == "error") {
    options.repeated = RepeatedHeights::refused;
  } else if (!duplicates.empty() && duplicates != "mean") {
    return fail("--duplicates: expected 'mean', 'min', 'max' or 'error', got '{}'", duplicates);
  }
  if (arguments.max_edge.empty()) return options;
  LODE_TRY(options.max_edge, parse_number("--max-edge", arguments.max_edge));
  if (!(*options.max_edge > 0))
    return fail("--max-edge: expected a number > 0, got '{}'", arguments.max_edge);
  return options;
}

Result<void> set_lines(const TerrainArguments& arguments, TerrainReadOptions& options) {
  if ((arguments.drape || !arguments.drape_error.empty()) && arguments.breaklines.empty())
    return fail("--drape, --drape-error: expected --breaklines with them, got none");
  if (!arguments.drape_error.empty()) {
    LODE_TRY(options.drape_error, parse_number("--drape-error", arguments.drape_error));
    if (!(*options.drape_error >= 0))
      return fail("--drape-error: expected a number >= 0, got '{}'", arguments.drape_error);
  }
  options.breaklines = arguments.breaklines;
  options.is_draped = arguments.drape;
  options.keeps_features = arguments.keep_features;
  if (arguments.feature_relief.empty()) return {};
  LODE_TRY(options.least_relief, parse_number("--feature-relief", arguments.feature_relief));
  if (!(*options.least_relief >= 0))
    return fail("--feature-relief: expected a number >= 0, got '{}'", arguments.feature_relief);
  return {};
}

Result<TerrainReadOptions> to_read_options(const std::string& path,
                                           const TerrainArguments& arguments,
                                           const ReadingArguments& reading) {
  TerrainReadOptions options;
  if (holds_terrain_model(path) && arguments.has_lines())
    return fail(
        "{}: expected a raster or points with --keep-features, --feature-relief, --breaklines or "
        "--drape, got a .lode file",
        path);
  if (holds_terrain_model(path)) return options;
  LODE_CHECK(set_lines(arguments, options));
  if (is_point_path(path)) {
    if (arguments.has_raster())
      return fail(
          "{}: expected no --band, --variable, --encoding, --wrap or --resample with points, got "
          "one",
          path);
    LODE_TRY(options.points, to_point_options(arguments, reading));
    LODE_TRY(options.domain, to_domain_options(arguments));
    return options;
  }
  if (arguments.has_points())
    return fail(
        "{}: expected points (.las, .xyz, ...) with --class, --duplicates, --max-edge or "
        "--outline, got a raster",
        path);
  if (arguments.wrap && arguments.has_lines())
    return fail(
        "--wrap: expected no --keep-features, --feature-relief, --breaklines or --drape with it, "
        "got one");
  options.is_wrapped = arguments.wrap;
  LODE_TRY(options.raster, to_height_options(arguments, reading));
  return options;
}

}  // namespace

namespace {

constexpr int kMostOversampling = 16;

Result<std::optional<Resampling>> to_resampling(const std::string& text) {
  if (text.empty()) return std::optional<Resampling>();
  if (text == "nearest") return std::optional(Resampling::nearest);
  if (text == "bilinear") return std::optional(Resampling::bilinear);
  if (text == "cubic") return std::optional(Resampling::cubic);
  return fail("--resample: expected 'nearest', 'bilinear' or 'cubic', got '{}'", text);
}

}  // namespace

Result<HeightReadOptions> to_height_options(const TerrainArguments& arguments,
                                            const ReadingArguments& reading) {
  HeightReadOptions options;
  options.vertical = to_vertical_options(arguments);
  options.crs = arguments.crs;
  if (!arguments.band.empty()) {
    LODE_TRY(const auto band, parse_integer("--band", arguments.band, 1, kMaxBand));
    options.band = static_cast<int>(band);
  }
  options.variable = arguments.variable;
  if (arguments.encoding == "terrain-rgb") {
    options.encoding = HeightEncoding::terrain_rgb;
  } else if (arguments.encoding == "terrarium") {
    options.encoding = HeightEncoding::terrarium;
  } else if (!arguments.encoding.empty()) {
    return fail("--encoding: expected 'terrain-rgb' or 'terrarium', got '{}'", arguments.encoding);
  }
  LODE_TRY(options.to_degrees, to_resampling(arguments.resample));
  if (!arguments.oversample.empty()) {
    if (!options.to_degrees) return fail("--oversample: expected --resample with it, got none");
    LODE_TRY(const auto n,
             parse_integer("--oversample", arguments.oversample, 1, kMostOversampling));
    options.oversampling = static_cast<int>(n);
  }
  if (options.to_degrees && !arguments.encoding.empty())
    return fail("--resample: expected no --encoding with it: colours have nothing in between");
  if (!arguments.encoding.empty() && !arguments.variable.empty())
    return fail("--encoding: expected no --variable with it, which is of netCDF, got one");
  if (!arguments.encoding.empty() && !arguments.band.empty())
    return fail("--encoding: expected no --band with it, as it is of three bands");
  if (!reading.nodata.empty()) {
    LODE_TRY(options.nodata, parse_number("--nodata", reading.nodata));
  }
  return options;
}

Result<std::optional<double>> to_max_error(const std::string& text) {
  if (text.empty()) return std::optional<double>();
  LODE_TRY(const double max_error, parse_tolerance_or_share("--max-error", text));
  return std::optional<double>(max_error);
}

void set_share(const std::string& text, const HeightRange& range,
               std::optional<double>& tolerance) {
  if (tolerance && is_share(text)) *tolerance *= range.upper - range.lower;
}

Result<void> check_terrain_reading(const std::string& path, const TerrainArguments& arguments,
                                   const ReadingArguments& reading) {
  if (auto options = to_read_options(path, arguments, reading); !options) return options.error();
  return {};
}

namespace {

void warn_of_lines(const TerrainLineReport& lines, const std::string& path, Session& session) {
  if (lines.n_points > 0)
    session.warn(fmt::format("{}: {} points are left out, as they are no lines", path,
                             format_count(lines.n_points)));
  if (lines.n_outside > 0)
    session.warn(fmt::format(
        "{}: {} of {} lines lie outside of the domain, or in one place, and are left out", path,
        format_count(lines.n_outside), format_count(lines.n_breaklines)));
  if (lines.n_cut > 0)
    session.warn(fmt::format("{}: {} of {} lines are cut where they leave the domain", path,
                             format_count(lines.n_cut), format_count(lines.n_breaklines)));
  if (lines.n_unequal > 0)
    session.warn(fmt::format(
        "{}: in {} places lines meet at different heights, up to {} apart, and get their mean",
        path, format_count(lines.n_unequal), format_number(lines.largest_spread)));
  if (lines.n_crossing > 0)
    session.warn(fmt::format("{}: {} edges of lines are left out, as they cross the outline", path,
                             format_count(lines.n_crossing)));
}

}  // namespace

Result<OpenedTerrain> open_terrain(const std::string& path, const TerrainArguments& arguments,
                                   const ReadingArguments& reading,
                                   const std::optional<TerrainBuildOptions>& building,
                                   const std::optional<double>& max_error, Session& session,
                                   const TerrainQuestion& question) {
  LODE_TRY(TerrainReadOptions options, to_read_options(path, arguments, reading));
  options.keeps_samples = question.keeps_samples;
  options.is_closed = question.is_closed;
  options.way = question.way;
  options.way_crs = question.way_crs;
  if (max_error && !options.drape_error)
    (question.has_shares ? options.drape_share : options.drape_error) = *max_error / 2;
  if (is_polygon_path(arguments.outline)) {
    options.outline = arguments.outline;
  } else if (!arguments.outline.empty()) {
    LODE_TRY(std::vector<Place> corners, read_places(arguments.outline));
    options.domain.outline = {PlacePolygon{std::move(corners)}};
  }
  std::optional<TerrainBuildOptions> wanted = building;
  if (wanted && question.has_shares) wanted->levels_are_shares = true;
  LODE_TRY(OpenedTerrain opened, lode::open_terrain(path, options, wanted, session.progress()));
  if (opened.facts.points)
    warn_of_points(*opened.facts.points, path, options.domain.repeated, session);
  warn_of_vertical(opened.facts.vertical, path, session);
  if (opened.lines) warn_of_lines(*opened.lines, arguments.breaklines, session);
  return opened;
}

Result<void> check_lined_model(const std::string& path, const TerrainArguments& arguments) {
  const auto model = built_model_of(arguments.model);
  if (!arguments.has_lines() || !model) return {};
  const bool has_breaklines = !arguments.breaklines.empty() || arguments.drape;
  if (is_of_any_points(*model) || !has_breaklines) return {};
  return fail(
      "{}: expected --model delaunay_selector, delaunay_pyramid, complete_pyramid, triangle_lists, "
      "linked_triangle_lists, ternary_triangulation, "
      "implicit_delaunay_pyramid, adaptive_triangulation or hierarchical_delaunay with "
      "--breaklines, got '{}', which has no edges but those of squares: --keep-features and "
      "--feature-relief are for all models",
      path, arguments.model);
}

Result<void> check_model_of_points(const std::string& path, const TerrainArguments& arguments) {
  const auto model = built_model_of(arguments.model);
  if (!is_point_path(path) || !model || is_of_any_points(*model)) return {};
  return fail(
      "{}: expected a raster with --model {}, got scattered points: delaunay_pyramid, "
      "complete_pyramid, triangle_lists, linked_triangle_lists, "
      "ternary_triangulation, implicit_delaunay_pyramid, adaptive_triangulation and "
      "hierarchical_delaunay can be built of these",
      path, arguments.model);
}

/// Points have no columns and rows to cut along, and lines might cross these.
Result<void> check_insertion(const std::string& path, const TerrainArguments& arguments) {
  if (arguments.insertion != name_of(InsertionOrder::tiles)) return {};
  if (is_point_path(path))
    return fail("--insertion: expected 'levels' or 'strict' with scattered points, got 'tiles'");
  if (!arguments.has_lines()) return {};
  return fail(
      "--insertion: expected 'levels' or 'strict' with --keep-features, --feature-relief, "
      "--breaklines or --drape, got 'tiles'");
}

Result<void> check_terrain_model(const std::string& path, const TerrainArguments& arguments,
                                 const ReadingArguments& reading) {
  LODE_CHECK(check_insertion(path, arguments));
  LODE_CHECK(check_lined_model(path, arguments));
  LODE_CHECK(check_model_of_points(path, arguments));
  if (!holds_terrain_model(path) || (arguments.is_empty() && reading.nodata.empty())) return {};
  return fail(
      "{}: expected no --band, --variable, --encoding, --wrap, --nodata, --crs, --model, "
      "--insertion or options of lines, points or heights with a .lode file of terrain, got one",
      path);
}

Result<TerrainModel> to_built_model(const std::string& name) {
  if (const auto model = built_model_of(name)) return *model;
  std::string names = fmt::format("'{}'", name_of(TerrainModel::delaunay_selector));
  for (const TerrainModel model : kBuiltTerrainModels)
    names += fmt::format(", '{}'", name_of(model));
  return fail("--model: expected one of {}, got '{}'", names, name);
}

Result<std::optional<TerrainBuildOptions>> to_build_options(const TerrainArguments& arguments,
                                                            const std::optional<double>& finest) {
  if (arguments.model.empty() || arguments.model == name_of(TerrainModel::delaunay_selector))
    return std::optional<TerrainBuildOptions>();
  TerrainBuildOptions options;
  LODE_TRY(options.model, to_built_model(arguments.model));
  if (!arguments.insertion.empty())
    return fail("--insertion: expected none with --model {}, which is 'strict'", arguments.model);
  if (finest) options.levels = {*finest};
  return std::optional(options);
}

void choose_levels(const std::optional<double>& finest, TerrainBuildOptions& building) {
  if (!is_hierarchy(building.model) && !is_pyramid_of_levels(building.model)) return;
  building.levels.clear();
  if (!finest) return;
  constexpr int kDoublings = 10;
  for (int k = *finest > 0 ? kDoublings : 0; k >= 0; --k)
    building.levels.push_back(std::ldexp(*finest, k));
}

void warn_of_vertical(const VerticalOutcome& outcome, const std::string& path, Session& session) {
  for (const std::string& note : outcome.notes) session.warn(fmt::format("{}: {}", path, note));
}

void hint_at_wrap(const OpenedTerrain& opened, const std::string& path, Session& session) {
  if (!opened.facts.goes_round || opened.is_closed || opened.lines) return;
  session.warn(
      fmt::format("{}: goes round the earth, and ends at its last column: --wrap closes it", path));
}

Result<void> check_upwards(const HeightFrame& frame, const std::string& path) {
  if (!has_depths(frame.crs)) return {};
  return fail(
      "{}: expected heights, which grow upwards, got {}, which grows downwards: --to-vertical-crs "
      "transforms it when a raster or points are read",
      path, vertical_name(frame.crs));
}

}  // namespace lode::cli
