#include "build_terrain.h"

#include <functional>

#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "terrain_facts.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

/// From coarse to fine, whatever their order; none: the default ones.
Result<ToleranceList> to_levels(const std::string& text) {
  if (text.empty()) return ToleranceList();
  LODE_TRY(ToleranceList levels, parse_tolerances("--levels", text));
  std::ranges::sort(levels.values, std::greater());
  const auto twice = std::ranges::adjacent_find(levels.values);
  if (twice != levels.values.end())
    return fail("--levels: expected different tolerances, got the {} {} twice",
                levels.are_shares ? "share" : "number", *twice);
  return levels;
}

Result<TerrainBuildOptions> to_options(const TerrainBuildJob& job) {
  TerrainArguments terrain = job.terrain;
  if (terrain.model.empty()) terrain.model = name_of(TerrainModel::delaunay_pyramid);
  if (terrain.model == name_of(TerrainModel::delaunay_selector))
    return fail(
        "--model: expected a model that is built once, such as 'delaunay_pyramid', got '{}', "
        "which makes a TIN for each question",
        terrain.model);
  LODE_CHECK(check_lined_model(job.input, terrain));
  LODE_CHECK(check_model_of_points(job.input, terrain));
  LODE_TRY(const auto asked, to_build_options(terrain, {}));
  TerrainBuildOptions options = asked.value();
  LODE_TRY(ToleranceList levels, to_levels(job.levels));
  options.levels = std::move(levels.values);
  options.levels_are_shares = levels.are_shares;
  if (!job.memory_limit.empty()) {
    if (!has_links(options.model))
      return fail(
          "--memory-limit: expected --model complete_pyramid or linked_triangle_lists with it, "
          "whose links it limits, got {}",
          terrain.model);
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", job.memory_limit));
  }
  if (!options.levels.empty() && options.model == TerrainModel::implicit_delaunay_pyramid)
    return fail("--levels: expected none with --model {}, which finds its own", terrain.model);
  return options;
}

/// Of BuiltTerrainInfo::n_nodes, one of them.
const char* what_nodes_are(TerrainModel model) {
  if (is_quadtree(model)) return "a square";
  if (is_hierarchy(model) || is_pyramid_of_levels(model)) return "a vertex";
  return model == TerrainModel::right_triangle_bisection ? "a sample" : "an insertion";
}

/// Vertices of hierarchies lie between samples, too.
void warn_of_many(const BuiltTerrainInfo& info, const OpenedTerrain& opened, Session& session) {
  const std::uint64_t full = n_full_triangles(opened.facts, info.n_samples);
  for (const BuiltTerrainInfo::Level& level : info.levels)
    if (is_hierarchy(opened.model) && level.triangles > full)
      session.warn(fmt::format(
          "the level within {} has {} triangles, more than the {} of all samples: other models, or "
          "the raster itself, say as much with fewer",
          format_number(level.tolerance), format_count(level.triangles), format_count(full)));
}

void add_counts(const BuiltTerrainInfo& info, TerrainModel model, Json& json) {
  if (is_quadtree(model)) {
    json["squares"] = info.n_nodes;
    json["kept_samples"] = info.n_kept;
  } else if (model == TerrainModel::right_triangle_bisection) {
    json["first_triangles"] = info.n_base_triangles;
    json["kept_samples"] = info.n_kept;
  } else if (is_pyramid_of_levels(model)) {
    json["vertices"] = info.n_nodes;
    json["first_triangles"] = info.n_base_triangles;
    json["triangles_kept"] = info.n_triangles;
    json["links"] = info.n_links;
    json["fixed_edges"] = info.n_lines;
  } else if (is_hierarchy(model)) {
    json["vertices"] = info.n_nodes;
    json["first_triangles"] = info.n_base_triangles;
    json["triangles_ever"] = info.n_triangles;
    json["fixed_edges"] = info.n_lines;
  } else {
    json["insertions"] = info.n_nodes;
    json["outline_triangles"] = info.n_base_triangles;
    json["triangles_ever"] = info.n_triangles;
    json["fixed_edges"] = info.n_lines;
  }
}

void add_count_rows(const BuiltTerrainInfo& info, TerrainModel model, Table& table) {
  if (is_quadtree(model)) {
    table.add({"squares", format_count(info.n_nodes)});
  } else if (model == TerrainModel::right_triangle_bisection) {
    table.add({"first triangles", format_count(info.n_base_triangles)});
  } else if (is_pyramid_of_levels(model)) {
    table.add({"vertices", format_count(info.n_nodes)});
    table.add({"triangles kept", format_count(info.n_triangles)});
    if (info.n_links > 0) table.add({"links", format_count(info.n_links)});
  } else {
    table.add({is_hierarchy(model) ? "vertices" : "insertions", format_count(info.n_nodes)});
    table.add({"triangles ever", format_count(info.n_triangles)});
  }
}

void add_level_rows(const BuiltTerrainInfo& info, Json& json, Table& table) {
  json["levels"] = Json::array();
  for (const BuiltTerrainInfo::Level& level : info.levels) {
    json["levels"].push_back({{"tolerance", level.tolerance},
                              {"triangles", level.triangles},
                              {"vertices", level.vertices},
                              {"smallest_angle", level.smallest_angle},
                              {"median_angle", level.median_angle}});
    table.add({"level", fmt::format("within {}: {} triangles, smallest angles {:.1f}° at least, "
                                    "{:.1f}° in the middle",
                                    format_number(level.tolerance), format_count(level.triangles),
                                    level.smallest_angle, level.median_angle)});
  }
}

}  // namespace

Result<void> check_terrain_build(const TerrainBuildJob& job, const CLI::App& app) {
  LODE_CHECK(check_only_terrain(app, job.input, {"--levels", "--model", "--memory-limit"}));
  if (!is_lode_path(job.output))
    return fail("{}: expected an output that ends in .lode", job.output);
  if (auto options = to_options(job); !options) return options.error();
  LODE_CHECK(check_terrain_reading(job.input, job.terrain, job.reading));
  return check_paths_differ({job.input}, {job.output});
}

bool is_in_angles(const std::string& crs) {
  const auto metric = read_metric(crs);
  return metric && metric->ellipsoid;
}

void add_built_terrain(const BuiltTerrainInfo& info, TerrainModel model, const std::string& crs,
                       Json& json, Table& table) {
  json["range"] = {info.range.lower, info.range.upper};
  json["samples"] = info.n_samples;
  json["left_out_samples"] = info.n_left_out;
  add_counts(info, model, json);
  json["memory_bytes"] = info.memory_bytes;
  for (const BuiltTerrainInfo::Part& part : info.parts)
    json["parts"].push_back(
        {{"name", part.name},
         {"memory_bytes", part.memory_bytes},
         // Of a file that is opened, and not of one that is being written.
         {"file_bytes", part.file_bytes > 0 ? Json(part.file_bytes) : Json(nullptr)}});
  json["finest_error"] = info.max_error;
  json["error_kind"] = "at samples";
  table.add({"range", format_heights(info.range.lower, info.range.upper)});
  if (info.n_left_out > 0)
    table.add(
        {"left out", fmt::format("{} {}", format_count(info.n_left_out),
                                 info.is_of_points ? "points that are not in the domain"
                                                   : "samples in no cell with four heights")});
  if (info.n_lines > 0) table.add({"fixed edges", format_count(info.n_lines)});
  if (info.n_kept > 0) table.add({"kept samples", format_count(info.n_kept)});
  add_count_rows(info, model, table);
  table.add({"memory", format_bytes(info.memory_bytes)});
  for (const BuiltTerrainInfo::Part& part : info.parts)
    table.add({part.name, fmt::format("{} in memory", format_bytes(part.memory_bytes)) +
                              (part.file_bytes > 0
                                   ? fmt::format(", {} in the file", format_bytes(part.file_bytes))
                                   : "")});
  table.add({"finest error", fmt::format("{} at samples", format_number(info.max_error))});
  add_level_rows(info, json, table);
  if (info.levels.empty()) return;
  const bool is_plane_of_angles = is_in_angles(crs);
  json["angles_are_in"] = is_plane_of_angles ? "plane of longitudes and latitudes" : "plane";
  if (is_plane_of_angles)
    table.add({"angles",
               "in the plane of longitudes and latitudes: a degree east as long as one "
               "north"});
}

Result<Outcome> run_terrain_build(const TerrainBuildJob& job, Session& session) {
  LODE_TRY(const TerrainBuildOptions options, to_options(job));
  LODE_CHECK(check_writable(job.output));
  const Stopwatch watch;
  LODE_TRY(const OpenedTerrain opened,
           open_terrain(job.input, job.terrain, job.reading, options, {}, session));
  const double build_seconds = watch.seconds();
  const Stopwatch write_watch;
  LODE_TRY(const std::uint64_t n_bytes, opened.built->save(job.output, session.progress()));
  const double write_seconds = write_watch.seconds();
  LODE_TRY(const BuiltTerrainInfo info, opened.built->describe(session.progress()));
  warn_of_many(info, opened, session);
  Outcome outcome;
  Json& json = outcome.json;
  Table table;
  json["command"] = "build";
  json["input"] = job.input;
  json["output"] = job.output;
  json["model"] = name_of(opened.model);
  add_facts(opened.facts, json, table);
  add_lines(opened, json, table);
  table.add({"model", name_of(opened.model)});
  add_built_terrain(info, opened.model, opened.facts.frame.crs, json, table);
  json["file_bytes"] = n_bytes;
  json["seconds"] = {
      {"total", build_seconds + write_seconds}, {"build", build_seconds}, {"write", write_seconds}};
  json["warnings"] = session.warnings();
  table.add({"read and build", format_seconds(build_seconds)});
  table.add({"write", format_seconds(write_seconds)});
  std::string rate;
  if (info.n_nodes > 0)
    rate = fmt::format(" ({:.1f} bytes {})",
                       static_cast<double>(n_bytes) / static_cast<double>(info.n_nodes),
                       what_nodes_are(opened.model));
  table.add({"file size", format_bytes(n_bytes) + rate});
  table.add({"output", job.output});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace lode::cli
