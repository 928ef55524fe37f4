#include "describe.h"

#include <fmt/format.h>

namespace lode::cli {
namespace {

Json vector_json(const Vec3d& v) { return Json::array({v[0], v[1], v[2]}); }

std::string vector_text(const Vec3d& v) {
  return fmt::format("{}, {}, {}", format_number(v[0]), format_number(v[1]), format_number(v[2]));
}

double per_sample(std::uint64_t bytes, const DatasetInfo& info) {
  const auto n = static_cast<double>(info.volume.grid.n_samples());
  return n > 0 ? static_cast<double>(bytes) / n : 0;
}

Json level_json(const LevelInfo& level) {
  Json json;
  json["level"] = level.level;
  json["step"] = level.step;
  json["samples"] = level.n_samples;
  json["nodes"] = level.n_nodes;
  json["max_error"] = level.max_error;
  json["bytes"] = level.bytes;
  return json;
}

}  // namespace

Json to_json(const VolumeInfo& volume) {
  const RegularGrid& grid = volume.grid;
  Json json;
  json["dims"] = grid.dims.v;
  json["samples"] = grid.n_samples();
  json["spacing"] = vector_json(grid.spacing);
  json["origin"] = vector_json(grid.origin);
  for (const Vec3d& row : grid.direction.rows) json["direction"].push_back(vector_json(row));
  json["frame"] = name_of(grid.frame);
  json["type"] = name_of(volume.type);
  json["field"] = volume.field_name;
  json["nodata"] = volume.nodata ? Json(*volume.nodata) : Json(nullptr);
  add_units(json, volume.units);
  return json;
}

Json to_json(const DatasetInfo& info) {
  Json json = to_json(info.volume);
  json["model"] = info.model;
  json["range"] = Json::array({info.range_min, info.range_max});
  json["holes"] = info.n_holes;
  json["removed_cells"] = info.n_removed_cells;
  json["base_error"] = info.base_error;
  // A dataset in memory has no sizes on disk; zeros would claim that it had.
  if (info.data_bytes + info.attribute_bytes > 0) {
    json["data_bytes"] = info.data_bytes;
    json["attribute_bytes"] = info.attribute_bytes;
    json["data_bytes_per_sample"] = per_sample(info.data_bytes, info);
    json["attribute_bytes_per_sample"] = per_sample(info.attribute_bytes, info);
  }
  json["levels"] = Json::array();
  for (const LevelInfo& level : info.levels) json["levels"].push_back(level_json(level));
  return json;
}

void add_units(Json& json, const Units& units) {
  const auto unit = [](const std::string& name) {
    return name.empty() ? Json(nullptr) : Json(name);
  };
  json["length_unit"] = unit(units.length);
  json["value_unit"] = unit(units.value);
}

std::string describe_units(const Units& units) {
  std::string text = units.length.empty() ? "" : "lengths in " + units.length;
  if (!units.value.empty()) text += (text.empty() ? "values in " : ", values in ") + units.value;
  return text;
}

void add_units(Table& table, const Units& units) {
  if (!units.is_empty()) table.add({"units", describe_units(units)});
}

void add_volume(Table& table, const VolumeInfo& volume) {
  const RegularGrid& grid = volume.grid;
  table.add(
      {"dims", fmt::format("{} x {} x {} = {} samples", grid.dims[0], grid.dims[1], grid.dims[2],
                           format_count(static_cast<std::uint64_t>(grid.n_samples())))});
  table.add({"type", std::string(name_of(volume.type))});
  if (!volume.field_name.empty()) table.add({"field", volume.field_name});
  table.add({"spacing", vector_text(grid.spacing)});
  table.add({"origin", vector_text(grid.origin)});
  constexpr const char* kAxes[] = {"x axis", "y axis", "z axis"};
  for (std::size_t i = 0; i < 3; ++i) table.add({kAxes[i], vector_text(grid.direction.column(i))});
  table.add({"frame", std::string(name_of(grid.frame))});
  add_units(table, volume.units);
  if (volume.nodata) table.add({"nodata", format_number(*volume.nodata)});
}

void add_sizes(Table& table, const DatasetInfo& info) {
  if (info.data_bytes + info.attribute_bytes == 0) return;
  const auto size = [&](std::uint64_t bytes) {
    return fmt::format("{} ({:.3f} bytes per sample)", format_bytes(bytes),
                       per_sample(bytes, info));
  };
  table.add({"data on disk", size(info.data_bytes)});
  table.add({"the rest", size(info.attribute_bytes)});
}

std::string describe_range(const DatasetInfo& info) {
  if (info.n_holes == static_cast<std::uint64_t>(info.volume.grid.n_samples())) return "none";
  return format_range(info.range_min, info.range_max);
}

std::string describe_levels(const DatasetInfo& info) {
  Table table({"level", "step", "samples", "nodes", "largest error", "on disk"});
  for (auto level = info.levels.rbegin(); level != info.levels.rend(); ++level)
    table.add(
        {fmt::format("{}", level->level), format_count(static_cast<std::uint64_t>(level->step)),
         format_count(level->n_samples), format_count(level->n_nodes),
         format_number(level->max_error), level->bytes > 0 ? format_bytes(level->bytes) : ""});
  return table.to_string();
}

}  // namespace lode::cli
