#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <set>

#include "build_tetra.h"
#include "command.h"
#include "lode/api/tetra_attachment.h"
#include "outputs.h"
#include "parse.h"
#include "tetra_input.h"
#include "tetra_record.h"
#include "text.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

struct AttachArguments {
  std::vector<std::string> files;  ///< The model, meshes, the output.
  std::string at;
  ReadingArguments reading;

  [[nodiscard]] const std::string& model() const { return files.front(); }
  [[nodiscard]] const std::string& output() const { return files.back(); }
};

/// A mesh that is to be read, one step of it.
struct StepToRead {
  std::string path;
  ReadingArguments reading;
  std::optional<double> time{};
  bool has_own_time = false;  ///< It is the file's.
};

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    parts.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return parts;
}

Result<std::vector<StepToRead>> steps_of(const AttachArguments& arguments) {
  std::vector<StepToRead> steps;
  for (std::size_t i = 1; i + 1 < arguments.files.size(); ++i)
    for (const std::string& solution : split(arguments.reading.solution))
      for (const std::string& step : split(arguments.reading.time)) {
        StepToRead& made = steps.emplace_back(StepToRead{arguments.files[i], arguments.reading});
        made.reading.solution = solution;
        made.reading.time = step;
      }
  const bool is_told_by_files =
      arguments.at == "file" || (arguments.at.empty() && steps.size() > 1);
  for (StepToRead& step : steps) step.has_own_time = is_told_by_files;
  if (is_told_by_files || arguments.at.empty()) return steps;
  const std::vector<std::string> times = split(arguments.at);
  if (times.size() != steps.size())
    return fail("--at: expected {} times, one for each step, got {}", steps.size(), times.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    LODE_TRY(steps[i].time, parse_number("--at", times[i]));
  }
  return steps;
}

Result<void> check_attach(const AttachArguments& arguments) {
  if (arguments.files.size() < 3)
    return fail("expected a model, meshes and an output, got {} files", arguments.files.size());
  if (is_lode_path(arguments.model())) LODE_CHECK(check_lode_opens(arguments.model()));
  if (!is_lode_path(arguments.model()) || !holds_tetrahedra(arguments.model()))
    return fail("{}: expected a .lode file made from a mesh of cells", arguments.model());
  LODE_CHECK(check_extension(arguments.output(), ".lode"));
  if (arguments.reading.field.empty())
    return fail("--field: expected the name of the field to attach, got none");
  LODE_TRY(const auto steps, steps_of(arguments));
  std::vector<std::string> inputs;
  for (const StepToRead& step : steps) {
    if (!is_cells_path(step.path)) return fail("{}: expected a mesh of cells", step.path);
    LODE_CHECK(check_tetra_reading(step.reading, step.path));
    inputs.push_back(step.path);
    if (!step.reading.solution.empty()) inputs.push_back(step.reading.solution);
  }
  return check_paths_differ(inputs, {arguments.output()});
}

/// Names of the model's fields that have times.
Result<std::set<std::string>> timed_fields(const std::string& path) {
  LODE_TRY(const TetraDataset model, TetraDataset::open(path));
  std::set<std::string> names;
  for (const TetraFieldInfo& field : model.describe().fields)
    if (field.time) names.insert(field.name);
  return names;
}

/// A step of a field that has others takes the time that its file says, if it is told none.
Result<std::optional<double>> time_of(const StepToRead& step, std::size_t n_steps,
                                      const TetrahedraOutcome& made,
                                      const std::set<std::string>& timed) {
  if (step.time) return step.time;
  if (step.has_own_time && !made.report.time)
    return fail(
        "--at: expected the times of {} steps as T,T,..., as {} does not say its own, got none",
        n_steps, step.path);
  const auto other = std::ranges::find_if(
      made.mesh.fields, [&](const MeshField& field) { return timed.contains(field.name); });
  if (!step.has_own_time && other == made.mesh.fields.end()) return std::optional<double>();
  if (made.report.time) return made.report.time;
  return fail(
      "--at: expected a time, as the model has {} at others and {} does not say its own, "
      "got none",
      other->name, step.path);
}

Result<Outcome> run_attach(const AttachArguments& arguments, Session& session) {
  LODE_CHECK(check_writable(arguments.output()));
  LODE_TRY(const std::vector<StepToRead> steps, steps_of(arguments));
  LODE_TRY(const std::set<std::string> timed, timed_fields(arguments.model()));
  std::size_t at = 0;
  std::vector<TetraBuildRecord::Note> notes;
  const auto next = [&]() -> Result<std::optional<TetraStep>> {
    if (at == steps.size()) return std::optional<TetraStep>();
    const StepToRead& step = steps[at++];
    LODE_TRY(TetrahedraOutcome made, read_tetra_mesh(step.path, step.reading, session));
    const std::string& solution = step.reading.solution;
    LODE_TRY(const std::optional<double> time, time_of(step, steps.size(), made, timed));
    TetraStep read{.mesh = std::move(made.mesh),
                   .time = time,
                   .source = solution.empty() ? step.path : step.path + ", " + solution,
                   .notes = notes_of_fields(made.report)};
    for (auto& [name, text] : read.notes)
      if (time) text += fmt::format(", at {}", *time);
    notes.insert(notes.end(), read.notes.begin(), read.notes.end());
    return std::optional(std::move(read));
  };
  LODE_TRY(const TetraAttachReport report,
           attach_fields(arguments.model(), arguments.output(), next, session.threads(),
                         session.progress()));
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "attach-field";
  json["inputs"] = std::vector<std::string>(arguments.files.begin(), arguments.files.end() - 1);
  json["output"] = arguments.output();
  json["attached"] = report.n_attached;
  Table table;
  add_fields(report.info, table, json);
  json["notes"] = Json::array();
  for (const auto& [name, text] : notes) {
    json["notes"].push_back({{"about", name}, {"note", text}});
    table.add({name, text});
  }
  json["file_bytes"] = report.file_bytes;
  json["seconds"] = {{"total", report.seconds}};
  json["warnings"] = session.warnings();
  table.add({"attached", format_count(report.n_attached)});
  table.add({"file size", format_bytes(report.file_bytes)});
  table.add({"time", format_seconds(report.seconds)});
  table.add({"output", arguments.output()});
  outcome.text = table.to_string();
  return outcome;
}

}  // namespace

Command add_attach_command(CLI::App& program) {
  auto arguments = std::make_shared<AttachArguments>();
  CLI::App* app = program.add_subcommand(
      "attach-field", "Add fields, or time steps, to the .lode file of a mesh of cells");
  app->footer(
      "Each MESH must be the one that MODEL was built from, read with the same options: its\n"
      "field is measured in one pass, and the hierarchy stays, of half edges or midpoints.\n"
      "Errors of fields so attached hold at the mesh's own vertices.\n\n"
      "Examples:\n  lode attach-field wing.lode wing.vtu two.lode --field Pressure\n"
      "  lode attach-field wing.lode s1.vtu s2.vtu all.lode --field Density --at 0.1,0.2\n"
      "  lode attach-field run.lode run.e all.lode --field T --time 1,2,3 --at 10,20,30\n"
      "  lode attach-field run.lode run.msh all.lode --field T --time 0,1,2\n"
      "  lode attach-field run.lode run.mesh all.lode --field solution --solution 1.sol,2.sol --at "
      "1,2\n"
      "  lode extract all.lode t2.vtu --mesh --field Density --time 2");
  app->add_option("files", arguments->files, "MODEL.lode, meshes, and the OUT.lode to make")
      ->type_name("MODEL MESH... OUT")
      ->required();
  app->add_option("--at", arguments->at,
                  "The time of each step, in any unit, as T,T,...; or 'file', as the files say it "
                  "(default of several steps, and of a field that the model has at others)")
      ->type_name("T");
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_attach(*arguments); },
          [arguments](Session& session) { return run_attach(*arguments, session); }};
}

}  // namespace lode::cli
