#include <fmt/format.h>

#include <memory>

#include "build_tetra.h"
#include "command.h"
#include "describe.h"
#include "info_terrain.h"
#include "input.h"
#include "sample_range.h"
#include "tetra_input.h"
#include "text.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

struct InfoArguments {
  std::string input;
  ReadingArguments reading;
  TerrainArguments terrain;
};

Json file_json(const std::string& path, const std::string& format) {
  Json json;
  json["command"] = "info";
  json["file"] = path;
  json["format"] = format;
  return json;
}

Outcome report_lode(const std::string& path, const DatasetInfo& info) {
  Outcome outcome;
  outcome.json = file_json(path, "lode");
  outcome.json.update(to_json(info));
  Table table;
  table.add({"file", path});
  table.add({"format", "lode"});
  table.add({"model", info.model});
  add_volume(table, info.volume);
  table.add({"range", describe_range(info)});
  table.add({"holes", fmt::format("{} samples, {} unit cells removed", format_count(info.n_holes),
                                  format_count(info.n_removed_cells))});
  table.add({"base error", format_number(info.base_error)});
  add_sizes(table, info);
  outcome.text = table.to_string() + '\n' + describe_levels(info);
  return outcome;
}

std::string join(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += (text.empty() ? "" : ", ") + (name.empty() ? std::string("(unnamed)") : name);
  return text;
}

/// What the header says; for a file whose field, component or time is still to be chosen it is
/// all there is to say.
Outcome report_header(const std::string& path, const FileDescription& file) {
  const VolumeInfo volume{
      .grid = file.grid, .type = file.type, .field_name = {}, .nodata = {}, .units = file.units};
  Outcome outcome;
  outcome.json = file_json(path, file.format);
  outcome.json.update(to_json(volume));
  outcome.json.erase("field");
  outcome.json.erase("nodata");
  outcome.json["frame_note"] = file.frame_note;
  outcome.json["fields"] = file.fields;
  outcome.json["components"] = file.n_components;
  outcome.json["times"] = file.n_times;
  Table table;
  table.add({"file", path});
  table.add({"format", file.format});
  add_volume(table, volume);
  if (!file.frame_note.empty()) table.add({"frame note", file.frame_note});
  table.add({"fields", join(file.fields)});
  if (file.n_components > 1) table.add({"components", fmt::format("{}", file.n_components)});
  if (file.n_times > 1) table.add({"time steps", fmt::format("{}", file.n_times)});
  outcome.text = table.to_string();
  return outcome;
}

bool is_choice_open(const FileDescription& file, const ReadOptions& options) {
  return (file.fields.size() > 1 && !options.field) ||
         (file.n_components > 1 && !options.component) || (file.n_times > 1 && !options.time);
}

Result<void> add_samples(Outcome& outcome, VolumeSource& source, Session& session) {
  LODE_TRY(const SampleRange range, find_sample_range(source, session.progress()));
  const VolumeInfo& volume = source.info();
  const bool has_values = range.n_holes < static_cast<std::uint64_t>(volume.grid.n_samples());
  outcome.json["field"] = volume.field_name;
  outcome.json["sample_type"] = name_of(volume.type);
  outcome.json["range"] = has_values ? Json::array({range.lower, range.upper}) : Json(nullptr);
  outcome.json["holes"] = range.n_holes;
  Table table;
  if (!volume.field_name.empty()) table.add({"field", volume.field_name});
  table.add({"read as", std::string(name_of(volume.type))});
  table.add({"range", has_values ? format_range(range.lower, range.upper) : "none"});
  table.add({"holes", fmt::format("{} samples", format_count(range.n_holes))});
  outcome.text += '\n' + table.to_string();
  return {};
}

Result<void> check_info(const InfoArguments& arguments, const CLI::App& app) {
  if (holds_terrain(arguments.input)) {
    LODE_CHECK(check_only_terrain(app, arguments.input, {}));
    LODE_CHECK(check_terrain_model(arguments.input, arguments.terrain, arguments.reading));
    return check_terrain_reading(arguments.input, arguments.terrain, arguments.reading);
  }
  LODE_CHECK(check_no_terrain(arguments.terrain, arguments.input));
  return holds_cells(arguments.input) ? check_tetra_reading(arguments.reading, arguments.input)
                                      : check_reading_options(arguments.reading, arguments.input);
}

Result<Outcome> run_info(const InfoArguments& arguments, Session& session) {
  if (holds_terrain(arguments.input))
    return run_terrain_info(arguments.input, arguments.terrain, arguments.reading, session);
  if (holds_cells(arguments.input)) return tetra_info(arguments.input, arguments.reading, session);
  if (is_lode_path(arguments.input)) {
    LODE_TRY(const Input input, open_input(session, arguments.input, arguments.reading));
    return report_lode(arguments.input, input.info);
  }
  LODE_TRY(const ReadOptions options, to_read_options(arguments.reading, session.threads()));
  LODE_TRY(const FileDescription file, describe_volume(arguments.input, options));
  Outcome outcome = report_header(arguments.input, file);
  if (is_choice_open(file, options)) {
    session.note(fmt::format("{}: choose with --field, --component or --time to see the range",
                             arguments.input));
    return outcome;
  }
  LODE_TRY(const auto source, open_volume(arguments.input, options));
  LODE_CHECK(add_samples(outcome, *source, session));
  return outcome;
}

}  // namespace

/// Of volumes, meshes and terrain.
constexpr HelpFooter kInfoFooter{{{
    {"", "  lode info scan.nrrd\n"},
    {"", "  lode info wing.vtu\n"},
    {"", "  lode info dem.tif\n  lode info survey.las --class 2\n"},
}}};

Command add_info_command(CLI::App& program) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* app =
      program.add_subcommand("info", "Show what a volume, mesh, terrain or .lode file holds");
  app->add_option("file", arguments->input, "File to look at")->type_name("FILE")->required();
  add_reading_options(*app, arguments->reading);
  add_terrain_options(*app, arguments->terrain, TerrainUse::reading);
  return {app, [arguments, app] { return check_info(*arguments, *app); },
          [arguments](Session& session) { return run_info(*arguments, session); }, kInfoFooter};
}

}  // namespace lode::cli
