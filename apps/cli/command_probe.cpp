#include <fmt/format.h>

#include <memory>

#include "command.h"
#include "outputs.h"
#include "probe_options.h"
#include "probe_output.h"
#include "probe_volume.h"
#include "stopwatch.h"
#include "tetra_input.h"
#include "tetra_query_options.h"
#include "text.h"
#include "tolerance.h"
#include "vtk_import.h"

namespace lode::cli {
namespace {

Result<void> check_probe_arguments(const ProbeArguments& arguments) {
  LODE_TRY(const ProbeJob job, to_probe_job(arguments, {}));
  if (!arguments.output.empty()) LODE_CHECK(check_extension(arguments.output, ".csv"));
  LODE_CHECK(holds_cells(arguments.input) ? check_tetra_reading(arguments.reading, arguments.input)
                                          : check_volume_probe(arguments));
  std::vector<std::string> inputs{arguments.input};
  if (!arguments.points_file.empty()) inputs.push_back(arguments.points_file);
  return check_paths_differ(inputs, arguments.output.empty()
                                        ? std::vector<std::string>{}
                                        : std::vector<std::string>{arguments.output});
}

void warn_of_inverted_cells(Session& session, const TetraInput& input, const ProbeAnswer& answer) {
  if (const std::uint64_t n = input.n_inverted(); n > 0 && answer.integral)
    session.warn(fmt::format(
        "the mesh has {} inverted cells, folded over others: they count with the opposite sign, so "
        "volumes are of what the boundary encloses; bounds of the integral leave out that the "
        "field has several values there",
        n));
}

Json head_json(const ProbeArguments& arguments, const TetraInput& input,
               const ProbeAnswer& answer) {
  const TetraInfo& info = input.dataset.describe();
  Json json;
  json["command"] = "probe";
  json["input"] = arguments.input;
  json["outputs"] = arguments.output.empty() ? Json::array() : Json::array({arguments.output});
  json["model"] = "tetra_mt";
  json["field"] = input.field().name;
  json["max_error"] = answer.report.max_error;
  json["achieved_error"] = answer.report.achieved_error;
  json["error_kind"] = name_of(input.field().error_place);
  json["boundary_deviation"] = info.boundary_deviation;
  return json;
}

/// What holds for all rows.
Table head_table(const ProbeArguments& arguments, const TetraInput& input,
                 const ProbeAnswer& answer, Json& json) {
  const TetraInfo& info = input.dataset.describe();
  Table table;
  table.add({"field", fmt::format("{}, {}", input.field().name,
                                  format_range(input.field().range_min, input.field().range_max))});
  add_reading(input, table, json);
  add_probe_rows(answer, table);
  if (answer.report.max_error > 0 && info.boundary_deviation > 0)
    table.add({"boundary", fmt::format("off by up to {}", format_number(info.boundary_deviation))});
  table.add({input.was_built() ? "read and build" : "open", format_seconds(input.seconds)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  return table;
}

/// Of a mesh of cells.
Result<Outcome> probe_mesh(const ProbeArguments& arguments, ProbeJob job, Session& session) {
  LODE_TRY(const TetraInput input, open_tetra_input(arguments.input, arguments.reading, session));
  auto regions = find_regions(input.dataset.describe(), arguments.regions);
  if (!regions) return naming_option("--region", arguments.input, regions.error());
  job.integral.regions = std::move(*regions);
  job.options.field = job.integral.field = input.fields.measured;
  job.options.along = job.integral.along = input.fields.along;
  const TetraFieldInfo& field = input.field();
  set_share(arguments.max_error, field.range_min, field.range_max, job.options.max_error);
  job.integral.max_error = job.options.max_error;
  LODE_TRY(ProbeAnswer answer, answer_of(input.dataset, job, session.progress()));
  answer.has_regions = input.dataset.describe().regions.size() > 1;
  for (const std::size_t place : input.fields.along)
    answer.with.push_back(input.dataset.describe().fields[place].name);
  warn_of_answer(session, answer, false);
  warn_of_inverted_cells(session, input, answer);
  if (!arguments.output.empty())
    LODE_CHECK(write_text(arguments.output, probe_csv(answer), session.progress()));
  Outcome outcome;
  outcome.json = head_json(arguments, input, answer);
  const Table head = head_table(arguments, input, answer, outcome.json);
  finish_probe(answer, head, input.seconds, session, outcome);
  return outcome;
}

Result<Outcome> run_probe(const ProbeArguments& arguments, Session& session) {
  LODE_TRY(ProbeJob job, to_probe_job(arguments, session.threads()));
  if (!arguments.output.empty()) LODE_CHECK(check_writable(arguments.output));
  if (!arguments.points_file.empty()) {
    LODE_TRY(const std::vector<Vec3d> more, read_points(arguments.points_file));
    job.points.insert(job.points.end(), more.begin(), more.end());
  }
  return holds_cells(arguments.input) ? probe_mesh(arguments, job, session)
                                      : run_volume_probe(arguments, job, session);
}

/// Of volumes, meshes and terrain.
constexpr HelpFooter kProbeFooter{{{
    {"Of a volume (build makes its .lode file; of others the hierarchy is built in memory first)\n"
     "`low` and `high` are proven bounds of the field that was read; at full resolution they are\n"
     "those of rounding. Between samples it is linear on the tetrahedra of the hierarchy, of "
     "which\n"
     "each cube of eight samples has six. `error` is the largest that F' is off by anywhere in "
     "the\n"
     "cell. Cubes that touch a hole (NaN, --nodata) are outside. Integrals come from all samples\n"
     "where that is faster than a cut within --max-error: then they are exact.\n",
     "  lode probe scan.lode --point 12.5,40,33 --point 0,0,0\n"
     "  lode probe scan.lode --line 0,0,0:100,80,60:200 -o profile.csv\n"
     "  lode probe scan.lode --integral --box 10,30,10,30,0,20\n"},
    {"Of a mesh of cells, or a .lode file made from one, `low` and `high` are proven bounds of "
     "the\n"
     "field that was read; at full resolution they are those of rounding. `error` is what the "
     "cell\n"
     "states: the largest difference at the mesh's own vertices, or, of files that were built "
     "with\n"
     "--everywhere, at any point, and bounds are much closer. `near boundary`: outside of the "
     "coarser\n"
     "mesh, but no farther than its boundary may be off (info says how far), so the field may be\n"
     "there, and then between the bounds. Fields of --with are of the same cells, whose tolerance\n"
     "is that of --field. Quadratic cells count as the tetrahedra between their nodes, on which "
     "the\n"
     "field is linear: how it curves between these is not in the bounds.\n",
     "  lode probe wing.lode --point 1,0.5,2 --point 3,0,0\n"
     "  lode probe wing.lode --points sensors.csv -o values.csv\n"
     "  lode probe wing.lode --line 0,0,0:10,0,0 --max-error 0.01\n"
     "  lode probe wing.lode --integral --box 0,1,0,1,0,2\n"
     "  lode probe wing.lode --integral --field Pressure --with Temp --with Velocity:xyz\n"
     "  lode probe wing.vtu --integral --region rotor --json\n"},
    {"Terrain is not probed: lode height and lode profile show its heights.\n",
     "  lode height dem.tif --at 500010,4000020 --max-error 1\n"},
}}};

}  // namespace

Command add_probe_command(CLI::App& program) {
  auto arguments = std::make_shared<ProbeArguments>();
  CLI::App* app = program.add_subcommand(
      "probe", "Show values at points and along lines, and integrals, with their bounds");
  app->add_option("file", arguments->input, ".lode file, or a volume or a mesh to build in memory")
      ->type_name("FILE")
      ->required();
  add_probe_options(*app, *arguments);
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_probe_arguments(*arguments); },
          [arguments](Session& session) { return run_probe(*arguments, session); }, kProbeFooter};
}

}  // namespace lode::cli
