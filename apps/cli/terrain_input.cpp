#include "terrain_input.h"

#include <algorithm>
#include <array>

#include "parse.h"

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

}  // namespace

void add_terrain_options(CLI::App& app, TerrainArguments& arguments, TerrainUse use) {
  const char* group = "Rasters of heights";
  const auto add = [&](const char* name, std::string& value, const char* type, const char* help) {
    app.add_option(name, value, help)->type_name(type)->group(group);
  };
  add("--band", arguments.band, "N", "Band of heights, from 1 (default: 1)");
  add("--encoding", arguments.encoding, "terrain-rgb|terrarium",
      "What the colours of a picture stand for");
  if (use == TerrainUse::reading) return;
  add("--model", arguments.model, "MODEL",
      "delaunay_selector (default): a TIN for this question; delaunay_pyramid: builds one first, "
      "whose tolerance may vary");
  add("--insertion", arguments.insertion, "levels|strict",
      "levels (default): errors fall by octaves, faster; strict: the worst of all "
      "samples first, fewer triangles; with --max-cells always strict");
}

Result<void> check_no_terrain(const TerrainArguments& arguments, const std::string& path) {
  if (arguments.is_empty()) return {};
  return fail(
      "{}: expected a raster of heights (.tif, .asc, .hgt, .png, ...) with --band, --encoding, "
      "--model or --insertion, got another file",
      path);
}

Result<void> check_only_terrain(const CLI::App& app, const std::string& path,
                                const std::vector<std::string>& allowed) {
  constexpr std::array kAlways{"--json", "--threads",  "--quiet",
                               "--band", "--encoding", "--nodata"};
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string name = "--" + option->get_lnames().front();
    const bool is_known = std::ranges::find(kAlways, name) != kAlways.end() ||
                          std::ranges::find(allowed, name) != allowed.end();
    if (!is_known) return fail("{}: expected no {} with a raster of heights, got one", path, name);
  }
  return {};
}

Result<HeightReadOptions> to_height_options(const TerrainArguments& arguments,
                                            const ReadingArguments& reading) {
  HeightReadOptions options;
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
  if (!arguments.encoding.empty() && !arguments.band.empty())
    return fail("--encoding: expected no --band with it, as it is of three bands");
  if (!reading.nodata.empty()) {
    LODE_TRY(options.nodata, parse_number("--nodata", reading.nodata));
  }
  return options;
}

Result<std::optional<double>> to_max_error(const std::string& text) {
  if (text.empty()) return std::optional<double>();
  LODE_TRY(const double max_error, parse_number("--max-error", text));
  if (max_error < 0) return fail("--max-error: expected a number >= 0, got '{}'", text);
  return std::optional<double>(max_error);
}

Result<void> check_terrain_model(const std::string& path, const TerrainArguments& arguments) {
  if (!holds_terrain_model(path) || arguments.is_empty()) return {};
  return fail(
      "{}: expected no --band, --encoding, --model or --insertion with a .lode file of terrain, "
      "got one",
      path);
}

Result<std::optional<PyramidOptions>> to_pyramid_options(const TerrainArguments& arguments,
                                                         const std::optional<double>& finest) {
  if (arguments.model.empty() || arguments.model == name_of(TerrainModel::delaunay_selector))
    return std::optional<PyramidOptions>();
  if (arguments.model != name_of(TerrainModel::delaunay_pyramid))
    return fail("--model: expected 'delaunay_selector' or 'delaunay_pyramid', got '{}'",
                arguments.model);
  if (!arguments.insertion.empty())
    return fail("--insertion: expected none with --model delaunay_pyramid, which is 'strict'");
  PyramidOptions options;
  if (finest) options.levels = {*finest};
  return std::optional(options);
}

void add_facts(const TerrainFacts& facts, Json& json, Table& table) {
  const HeightFrame& grid = facts.frame;
  const std::uint64_t n_missing = facts.n_missing;
  const auto n_samples =
      static_cast<std::uint64_t>(grid.n_columns) * static_cast<std::uint64_t>(grid.n_rows);
  json["columns"] = grid.n_columns;
  json["rows"] = grid.n_rows;
  json["type"] = facts.type;
  json["missing_samples"] = n_missing;
  json["to_world"] = grid.to_world;
  json["has_position"] = facts.has_place;
  json["crs"] = text_or_null(grid.crs);
  json["vertical_unit"] = text_or_null(grid.vertical_unit);
  table.add({"samples", fmt::format("{} x {} = {}, {}", grid.n_columns, grid.n_rows,
                                    format_count(n_samples), facts.type)});
  table.add({"missing", format_count(n_missing)});
  table.add({"CRS", grid.crs.empty() ? "not known" : crs_name(grid.crs)});
  table.add({"vertical unit", grid.vertical_unit.empty() ? "not known" : grid.vertical_unit});
}

}  // namespace lode::cli
