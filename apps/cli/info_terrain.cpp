#include "info_terrain.h"

#include <string>

#include "build_terrain.h"
#include "terrain_facts.h"
#include "terrain_query.h"
#include "text.h"

namespace lode::cli {
namespace {

Result<Outcome> run_model_info(const std::string& path, Session& session) {
  LODE_TRY(const OpenedTerrain opened, lode::open_terrain(path, {}, {}, session.progress()));
  Outcome outcome;
  outcome.json["command"] = "info";
  outcome.json["file"] = path;
  outcome.json["format"] = opened.facts.format;
  outcome.json["model"] = name_of(opened.model);
  Table table;
  table.add({"file", path});
  table.add({"model", name_of(opened.model)});
  add_facts(opened.facts, outcome.json, table);
  LODE_CHECK(add_extent(opened.facts, outcome.json, table));
  LODE_TRY(const BuiltTerrainInfo info, opened.built->describe(session.progress()));
  add_built_terrain(info, opened.model, opened.facts.frame.crs, outcome.json, table);
  outcome.text = table.to_string();
  return outcome;
}

Result<Outcome> run_points_info(const std::string& path, const TerrainArguments& terrain,
                                const ReadingArguments& reading, Session& session) {
  LODE_TRY(const OpenedTerrain opened, open_terrain(path, terrain, reading, {}, {}, session));
  const HeightRange range = opened.terrain.range();
  Outcome outcome;
  outcome.json["command"] = "info";
  outcome.json["file"] = path;
  outcome.json["format"] = opened.facts.format;
  Table table;
  table.add({"file", path});
  table.add({"format", opened.facts.format});
  add_facts(opened.facts, outcome.json, table);
  LODE_CHECK(add_extent(opened.facts, outcome.json, table));
  outcome.json["range"] = {range.lower, range.upper};
  table.add({"range", format_heights(range.lower, range.upper)});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

Result<Outcome> run_terrain_info(const std::string& path, const TerrainArguments& terrain,
                                 const ReadingArguments& reading, Session& session) {
  if (holds_terrain_model(path)) return run_model_info(path, session);
  if (is_point_path(path)) return run_points_info(path, terrain, reading, session);
  LODE_TRY(const HeightReadOptions options, to_height_options(terrain, reading));
  LODE_TRY(const HeightRaster raster, read_heights(path, options, session.progress()));
  warn_of_vertical(raster.vertical, path, session);
  const TerrainInfo info = describe_terrain(raster.grid);
  Outcome outcome;
  outcome.json["command"] = "info";
  outcome.json["file"] = path;
  outcome.json["format"] = raster.format;
  Table table;
  table.add({"file", path});
  table.add({"format", raster.format});
  const TerrainFacts facts = facts_of(raster);
  add_facts(facts, outcome.json, table);
  LODE_CHECK(add_extent(facts, outcome.json, table));
  outcome.json["range"] = info.has_heights ? Json::array({info.lower, info.upper}) : Json(nullptr);
  outcome.json["cells"] = info.n_cells;
  outcome.json["left_out_samples"] = info.n_left_out;
  table.add({"range", info.has_heights ? format_heights(info.lower, info.upper) : "none"});
  table.add({"cells", fmt::format("{} with four heights", format_count(info.n_cells))});
  if (info.n_left_out > 0)
    table.add(
        {"left out", fmt::format("{} samples in no such cell", format_count(info.n_left_out))});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace lode::cli
