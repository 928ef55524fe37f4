#include "terrain_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "parse.h"
#include "place_file.h"
#include "point_facts.h"

namespace lode::cli {
namespace {

constexpr int kMaxBand = 65536;

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

/// The name that WKT gives: what its first quotes hold.
std::string crs_name(const std::string& wkt) {
  const std::size_t first = wkt.find('"');
  const std::size_t last = first == std::string::npos ? first : wkt.find('"', first + 1);
  return last == std::string::npos ? wkt : wkt.substr(first + 1, last - first - 1);
}

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
      return fail("{}: expected no --band or --encoding with points, got one", path);
    LODE_TRY(options.points, to_point_options(arguments, reading));
    LODE_TRY(options.domain, to_domain_options(arguments));
    return options;
  }
  if (arguments.has_points())
    return fail(
        "{}: expected points (.las, .xyz, ...) with --class, --duplicates, --max-edge, --outline "
        "or --crs, got a raster",
        path);
  LODE_TRY(options.raster, to_height_options(arguments, reading));
  return options;
}

void add_line_options(CLI::App& app, TerrainArguments& arguments) {
  const char* group = "Lines of terrain";
  app.add_flag(
         "--keep-features", arguments.keep_features,
         "Make peaks, passes and pits vertices of every mesh, and the ridges and channels from "
         "passes edges; of quadtrees all of their samples vertices")
      ->group(group);
  app.add_option("--feature-relief", arguments.feature_relief,
                 "Keep features that rise or fall by at least this, in units of the heights "
                 "(default: 1 % of their range); means --keep-features")
      ->type_name("R")
      ->group(group);
  app.add_option(
         "--breaklines", arguments.breaklines,
         "Make lines edges of every mesh: .geojson, .gpkg or .shp, in any CRS; lines without "
         "heights get the surface's")
      ->type_name("LINES")
      ->group(group);
  app.add_flag("--drape", arguments.drape,
               "Give breaklines the surface's heights, though they have their own")
      ->group(group);
  app.add_option(
         "--drape-error", arguments.drape_error,
         "How far breaklines without heights of their own may be from the surface (default: "
         "half of --max-error, or without that a quarter percent of the range)")
      ->type_name("E")
      ->group(group);
}

void add_point_options(CLI::App& app, TerrainArguments& arguments) {
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->group("Scattered points");
  };
  add("--class", arguments.classes, "N,N,...",
      "Keep only points of these LAS classes, such as 2 (ground)");
  add("--duplicates", arguments.duplicates, "mean|min|max|error",
      "Height where several points share a position (default: mean); error: refuse them");
  add("--max-edge", arguments.max_edge, "L",
      "Leave out of the domain what is in triangles with a longer edge, in the unit of "
      "the CRS, or metres where it is of longitudes and latitudes");
  add("--outline", arguments.outline, "POLYGONS",
      "Leave out of the domain what is outside of polygons: .geojson, .gpkg or .shp, in "
      "any CRS, or text with x and y a line, in the points' coordinates");
  add("--crs", arguments.crs, "EPSG:N|EPSG:N+M|WKT",
      "CRS of x and y, perhaps of heights too, instead of the file's");
}

}  // namespace

void add_terrain_options(CLI::App& app, TerrainArguments& arguments, TerrainUse use) {
  const char* group = "Rasters of heights";
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->group(group);
  };
  add("--band", arguments.band, "N", "Band of heights, from 1 (default: 1)");
  add("--encoding", arguments.encoding, "terrain-rgb|terrarium",
      "What the colours of a picture stand for");
  if (use != TerrainUse::rasters) add_point_options(app, arguments);
  const auto add_of_heights = [&](const char* name, std::string& value, const char* help) {
    app.add_option(name, value, help)->type_name("EPSG:N|WKT|ellipsoid")->group("Heights");
  };
  add_of_heights("--vertical-crs", arguments.vertical_crs,
                 "What heights in the file are above and their unit, whatever it says: a vertical "
                 "CRS, such as EPSG:5773, or the ellipsoid of its CRS");
  add_of_heights("--to-vertical-crs", arguments.to_vertical_crs,
                 "Transform heights to this when they are read, through PROJ; errors hold there");
  if (use == TerrainUse::rasters || use == TerrainUse::reading) return;
  add_line_options(app, arguments);
  if (use == TerrainUse::verification) {
    add("--model", arguments.model, "MODEL",
        "What the surface was extracted with (default: delaunay_selector)");
    add("--insertion", arguments.insertion, "levels|strict|tiles",
        "tiles: edges need not be Delaunay on columns and rows that no triangle crosses");
    return;
  }
  add("--model", arguments.model, "MODEL",
      "delaunay_selector (default): a TIN for this question; delaunay_pyramid, "
      "ternary_triangulation and implicit_delaunay_pyramid: built first, for all tolerances, which "
      "may vary; surface_quadtree, quaternary_triangulation: with gaps; restricted_quadtree; "
      "right_triangle_bisection: any tolerance, which may vary; adaptive_triangulation: in levels; "
      "hierarchical_delaunay: in levels, of a raster it may vary");
  add("--insertion", arguments.insertion, "levels|strict|tiles",
      "levels (default): errors fall by octaves, faster; strict: the worst of all "
      "samples first, fewer triangles; with --max-cells always strict; tiles, of rasters: each "
      "tile "
      "on its own between fixed seams, on all threads, fastest, and Delaunay but for seams");
}

Result<InsertionOrder> to_insertion_order(const std::string& insertion) {
  for (const InsertionOrder order : kInsertionOrders)
    if (insertion == name_of(order)) return order;
  return fail("--insertion: expected 'levels', 'strict' or 'tiles', got '{}'", insertion);
}

const char* name_of(InsertionOrder order) {
  if (order == InsertionOrder::tiles) return "tiles";
  return order == InsertionOrder::strict ? "strict" : "levels";
}

void add_resample_option(CLI::App& app, TerrainArguments& arguments) {
  app.add_option("--resample", arguments.resample,
                 "Put a projected raster in degrees of WGS 84, with heights between samples from "
                 "the nearest, 2 x 2 or 4 x 4 of them; errors are of what comes out")
      ->type_name("nearest|bilinear|cubic")
      ->group("Rasters of heights");
  app.add_option("--oversample", arguments.oversample,
                 "With --resample: so many samples along each axis for one of the file's, which "
                 "keeps more of what it has (default: 1)")
      ->type_name("N")
      ->group("Rasters of heights");
}

Result<void> check_no_terrain(const TerrainArguments& arguments, const std::string& path) {
  if (arguments.has_points())
    return fail(
        "{}: expected scattered points (.las, .xyz, ...) with --class, --duplicates, --max-edge, "
        "--outline or --crs, got another file",
        path);
  if (arguments.has_vertical())
    return fail("{}: expected {} with --vertical-crs or --to-vertical-crs, got another file", path,
                kTerrainFiles);
  if (arguments.has_lines())
    return fail(
        "{}: expected {} with --keep-features, --feature-relief, --breaklines or --drape, got "
        "another file",
        path, kTerrainFiles);
  if (arguments.is_empty()) return {};
  return fail("{}: expected {} with --band, --encoding, --model or --insertion, got another file",
              path, kTerrainFiles);
}

Result<void> check_only_terrain(const CLI::App& app, const std::string& path,
                                const std::vector<std::string>& allowed) {
  constexpr std::array kAlways{
      "--resample",      "--oversample",     "--json",       "--threads",      "--quiet",
      "--band",          "--encoding",       "--nodata",     "--class",        "--duplicates",
      "--max-edge",      "--outline",        "--crs",        "--vertical-crs", "--to-vertical-crs",
      "--keep-features", "--feature-relief", "--breaklines", "--drape",        "--drape-error"};
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    const bool is_known = std::ranges::find(kAlways, name) != kAlways.end() ||
                          std::ranges::find(allowed, name) != allowed.end();
    const char* what = is_point_path(path) ? "scattered points" : "a raster of heights";
    if (!is_known) return fail("{}: expected no {} with {}, got one", path, name, what);
  }
  return {};
}

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
  if (!arguments.band.empty()) {
    LODE_TRY(const auto band, parse_integer("--band", arguments.band, 1, kMaxBand));
    options.band = static_cast<int>(band);
  }
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
  if (!arguments.encoding.empty() && !arguments.band.empty())
    return fail("--encoding: expected no --band with it, as it is of three bands");
  if (!reading.nodata.empty()) {
    LODE_TRY(options.nodata, parse_number("--nodata", reading.nodata));
  }
  return options;
}

Result<std::optional<double>> to_max_error(const std::string& text) {
  if (text.empty()) return std::optional<double>();
  if (text.ends_with('%'))
    return fail("--max-error: expected units of the heights with terrain, got '{}'", text);
  LODE_TRY(const double max_error, parse_number("--max-error", text));
  if (max_error < 0) return fail("--max-error: expected a number >= 0, got '{}'", text);
  return std::optional<double>(max_error);
}

Result<void> check_terrain_reading(const std::string& path, const TerrainArguments& arguments,
                                   const ReadingArguments& reading) {
  if (auto options = to_read_options(path, arguments, reading); !options) return options.error();
  return {};
}

namespace {

void warn_of_lines(const TerrainLineReport& lines, const std::string& path, Session& session) {
  if (lines.n_outside > 0)
    session.warn(fmt::format(
        "{}: {} of {} lines lie outside of the domain, or in one place, and are left out", path,
        format_count(lines.n_outside), format_count(lines.n_breaklines)));
  if (lines.n_cut > 0)
    session.warn(fmt::format("{}: {} of {} lines are cut where they leave the domain", path,
                             format_count(lines.n_cut), format_count(lines.n_breaklines)));
  if (lines.n_crossing > 0)
    session.warn(fmt::format("{}: {} edges of lines are left out, as they cross the outline", path,
                             format_count(lines.n_crossing)));
}

Json counts_of(const terrain_features::FeatureCounts& counts) {
  return {{"peaks", counts.peaks}, {"passes", counts.passes}, {"pits", counts.pits}};
}

}  // namespace

void add_lines(const OpenedTerrain& opened, Json& json, Table& table) {
  if (!opened.lines) return;
  const TerrainLineReport& lines = *opened.lines;
  Json& all = json["lines"];
  if (lines.kept_features) {
    const auto& kept = *lines.kept_features;
    all["features"] = {{"relief", lines.least_relief},
                       {"kept", counts_of(kept)},
                       {"all", counts_of(*lines.all_features)},
                       {"ridges", lines.n_ridges},
                       {"channels", lines.n_channels}};
    table.add(
        {"features", fmt::format("{} peaks, {} passes, {} pits of a relief of {} or more",
                                 format_count(kept.peaks), format_count(kept.passes),
                                 format_count(kept.pits), format_number(lines.least_relief))});
  }
  if (lines.n_breaklines > 0) {
    all["breaklines"] = {{"lines", lines.n_breaklines},
                         {"own_heights", lines.n_own_heights},
                         {"drape_error", lines.drape_error},
                         {"outside", lines.n_outside},
                         {"cut", lines.n_cut},
                         {"left_out_edges", lines.n_crossing},
                         {"replaced_samples", lines.n_replaced},
                         {"largest_change", lines.largest_change},
                         {"largest_move", lines.largest_move}};
    table.add({"breaklines",
               fmt::format("{}, {} with their own heights", format_count(lines.n_breaklines),
                           format_count(lines.n_own_heights))});
    if (lines.n_replaced > 0)
      table.add({"replaced",
                 fmt::format("{} samples under breaklines, by up to {}",
                             format_count(lines.n_replaced), format_number(lines.largest_change))});
  }
  all["edges"] = lines.n_edges;
  all["seconds"] = lines.seconds;
}

Result<OpenedTerrain> open_terrain(const std::string& path, const TerrainArguments& arguments,
                                   const ReadingArguments& reading,
                                   const std::optional<TerrainBuildOptions>& building,
                                   const std::optional<double>& max_error, Session& session) {
  LODE_TRY(TerrainReadOptions options, to_read_options(path, arguments, reading));
  if (max_error && !options.drape_error) options.drape_error = *max_error / 2;
  if (is_polygon_path(arguments.outline)) {
    options.outline = arguments.outline;
  } else if (!arguments.outline.empty()) {
    LODE_TRY(std::vector<Place> corners, read_places(arguments.outline));
    options.domain.outline = {PlacePolygon{std::move(corners)}};
  }
  LODE_TRY(OpenedTerrain opened, lode::open_terrain(path, options, building, session.progress()));
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
  if (is_of_any_points(*model) || (is_on_squares(*model) && !has_breaklines)) return {};
  return fail(
      "{}: expected --model delaunay_selector, delaunay_pyramid, ternary_triangulation or "
      "implicit_delaunay_pyramid with --breaklines, or with --keep-features and --feature-relief "
      "one of these or a model on squares, got '{}', which cannot keep edges",
      path, arguments.model);
}

Result<void> check_model_of_points(const std::string& path, const TerrainArguments& arguments) {
  const auto model = built_model_of(arguments.model);
  if (!is_point_path(path) || !model || is_of_any_points(*model)) return {};
  return fail(
      "{}: expected a raster with --model {}, got scattered points: delaunay_pyramid, "
      "ternary_triangulation and implicit_delaunay_pyramid can be built of these",
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
      "{}: expected no --band, --encoding, --nodata, --model, --insertion or options of lines, "
      "points "
      "or heights with a .lode file of terrain, got one",
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
  if (!is_hierarchy(building.model)) return;
  building.levels.clear();
  if (!finest) return;
  constexpr int kDoublings = 10;
  for (int k = *finest > 0 ? kDoublings : 0; k >= 0; --k)
    building.levels.push_back(std::ldexp(*finest, k));
}

void warn_of_vertical(const VerticalOutcome& outcome, const std::string& path, Session& session) {
  for (const std::string& note : outcome.notes) session.warn(fmt::format("{}: {}", path, note));
}

Result<void> check_upwards(const HeightFrame& frame, const std::string& path) {
  if (!has_depths(frame.crs)) return {};
  return fail(
      "{}: expected heights, which grow upwards, got {}, which grows downwards: --to-vertical-crs "
      "transforms it when a raster or points are read",
      path, vertical_name(frame.crs));
}

void add_facts(const TerrainFacts& facts, Json& json, Table& table) {
  const HeightFrame& frame = facts.frame;
  json["columns"] = frame.n_columns;
  json["rows"] = frame.n_rows;
  json["type"] = facts.type;
  json["missing_samples"] = facts.n_missing;
  json["to_world"] = frame.to_world;
  json["has_position"] = facts.has_place;
  json["crs"] = text_or_null(frame.crs);
  const std::string vertical = vertical_name(frame.crs);
  json["vertical_crs"] = text_or_null(vertical);
  json["vertical_unit"] = text_or_null(frame.vertical_unit);
  const VerticalOutcome& outcome = facts.vertical;
  if (!outcome.transformation.empty())
    json["vertical_transformation"] = {
        {"name", outcome.transformation},
        {"accuracy", outcome.accuracy ? Json(*outcome.accuracy) : Json(nullptr)}};
  json["is_of_points"] = facts.is_of_points || facts.points.has_value();
  if (facts.points) {
    add_point_facts(*facts.points, json, table);
  } else if (facts.is_of_points) {
    table.add({"lattice", fmt::format("{} x {}, of {}", frame.n_columns, frame.n_rows,
                                      facts.type == "points" ? "points" : "a raster with lines")});
  } else {
    const std::int64_t n_samples = std::int64_t{frame.n_columns} * frame.n_rows;
    table.add(
        {"samples", fmt::format("{} x {} = {}, {}", frame.n_columns, frame.n_rows,
                                format_count(static_cast<std::uint64_t>(n_samples)), facts.type)});
  }
  if (!facts.points || facts.n_missing > 0) table.add({"missing", format_count(facts.n_missing)});
  table.add({"CRS", frame.crs.empty() ? "not known" : crs_name(frame.crs)});
  table.add({"vertical CRS", vertical.empty() ? "not known" : vertical});
  table.add({"vertical unit", frame.vertical_unit.empty() ? "not known" : frame.vertical_unit});
  if (!outcome.transformation.empty())
    table.add(
        {"transformed",
         fmt::format("{}{}", outcome.transformation,
                     outcome.accuracy ? fmt::format(", accuracy {} m", *outcome.accuracy) : "")});
}

}  // namespace lode::cli
