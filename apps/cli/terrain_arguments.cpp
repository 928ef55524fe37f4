#include "terrain_arguments.h"

#include <algorithm>
#include <array>

namespace lode::cli {
namespace {

void add_line_options(CLI::App& app, TerrainArguments& arguments) {
  const char* group = "Lines of terrain";
  app.add_flag(
         "--keep-features", arguments.keep_features,
         "Make peaks, passes and pits vertices of every mesh, and the ridges and channels from "
         "passes edges; of models on squares all of their samples vertices")
      ->group(group);
  app.add_option("--feature-relief", arguments.feature_relief,
                 "Keep features that rise or fall by at least this, in units of the heights "
                 "(default: 1 % of their range); means --keep-features")
      ->type_name("R")
      ->group(group);
  app.add_option(
         "--breaklines", arguments.breaklines,
         "Make lines edges of every mesh (not of models on squares): .geojson, .gpkg or .shp, in "
         "any CRS, of all layers; points are left out, lines without heights get the surface's")
      ->type_name("LINES")
      ->group(group);
  app.add_flag("--drape", arguments.drape,
               "Give breaklines the surface's heights, though they have their own")
      ->group(group);
  app.add_option(
         "--drape-error", arguments.drape_error,
         "How far breaklines without heights of their own may be from the surface, where it is "
         "looked at: twice a cell, or mean distance of points (default: half of --max-error, or "
         "without that a quarter percent of the range)")
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
}

}  // namespace

void add_terrain_options(CLI::App& app, TerrainArguments& arguments, TerrainUse use) {
  const char* group = "Rasters of heights";
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->group(group);
  };
  add("--band", arguments.band, "N",
      "Band of heights, from 1 (default: 1); of netCDF the layer, along time and the like");
  add("--variable", arguments.variable, "NAME",
      "Variable of a netCDF file, in groups as deep/z (default: the only one over y and x)");
  add("--encoding", arguments.encoding, "terrain-rgb|terrarium",
      "What the colours of a picture stand for");
  if (use != TerrainUse::rasters) add_point_options(app, arguments);
  app.add_option("--crs", arguments.crs,
                 "CRS of x and y, perhaps of heights too: of points instead of the file's, of a "
                 "raster that has none")
      ->type_name("EPSG:N|EPSG:N+M|WKT")
      ->group("Heights");
  const auto add_of_heights = [&](const char* name, std::string& value, const char* help) {
    app.add_option(name, value, help)->type_name("EPSG:N|WKT|ellipsoid")->group("Heights");
  };
  add_of_heights("--vertical-crs", arguments.vertical_crs,
                 "What heights in the file are above and their unit, whatever it says: a vertical "
                 "CRS, such as EPSG:5773, or the ellipsoid of its CRS");
  add_of_heights("--to-vertical-crs", arguments.to_vertical_crs,
                 "Transform heights to this when they are read, through PROJ; errors hold there");
  if (use == TerrainUse::rasters || use == TerrainUse::reading) return;
  app.add_flag("--wrap", arguments.wrap,
               "Close a raster that goes round the earth: its first column follows its last, and "
               "TINs of the delaunay_selector have the same vertices on both sides")
      ->group(group);
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
      "may vary; complete_pyramid, triangle_lists, linked_triangle_lists: the pyramid in levels; "
      "surface_quadtree, quaternary_triangulation: with gaps; restricted_quadtree; "
      "right_triangle_bisection: any tolerance, which may vary; adaptive_triangulation, "
      "hierarchical_delaunay: in levels, and between them, which may vary");
  add("--insertion", arguments.insertion, "levels|strict|tiles",
      "levels (default): errors fall by octaves, faster; strict: the worst of all "
      "samples first, fewer triangles; with --max-cells always strict; tiles, of rasters: each "
      "tile "
      "on its own between fixed seams, on all threads, fastest, and Delaunay but for seams");
}

Result<InsertionOrder> to_insertion_order(const std::string& insertion) {
  for (const auto order : {InsertionOrder::levels, InsertionOrder::strict, InsertionOrder::tiles})
    if (insertion == name_of(order)) return order;
  return fail("--insertion: expected 'levels', 'strict' or 'tiles', got '{}'", insertion);
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
        "{}: expected scattered points (.las, .xyz, ...) with --class, --duplicates, --max-edge "
        "or --outline, got another file",
        path);
  if (!arguments.to_crs.empty())
    return fail("{}: expected {} with --to-crs, or a .lode file made of these, got another file",
                path, kTerrainFiles);
  if (arguments.has_vertical() || !arguments.crs.empty())
    return fail("{}: expected {} with --crs, --vertical-crs or --to-vertical-crs, got another file",
                path, kTerrainFiles);
  if (arguments.has_lines())
    return fail(
        "{}: expected {} with --keep-features, --feature-relief, --breaklines or --drape, got "
        "another file",
        path, kTerrainFiles);
  if (arguments.is_empty()) return {};
  return fail(
      "{}: expected {} with --band, --variable, --encoding, --wrap, --resample, --oversample, "
      "--model or --insertion, got another file",
      path, kTerrainFiles);
}

Result<void> check_only_terrain(const CLI::App& app, const std::string& path,
                                const std::vector<std::string>& allowed) {
  constexpr std::array kAlways{"--resample",       "--oversample",      "--json",
                               "--threads",        "--quiet",           "--wrap",
                               "--band",           "--encoding",        "--variable",
                               "--nodata",         "--class",           "--duplicates",
                               "--max-edge",       "--outline",         "--crs",
                               "--vertical-crs",   "--to-vertical-crs", "--keep-features",
                               "--feature-relief", "--breaklines",      "--drape",
                               "--drape-error"};
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

}  // namespace lode::cli
