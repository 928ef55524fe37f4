#include <fmt/format.h>

#include <memory>

#include "command.h"
#include "outputs.h"
#include "probe_options.h"
#include "probe_output.h"
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
  if (!holds_cells(arguments.input)) {
    if (is_lode_path(arguments.input)) LODE_CHECK(check_lode_opens(arguments.input));
    return fail(
        "{}: expected a mesh of cells, or a .lode file made from one: volumes cannot be "
        "probed yet",
        arguments.input);
  }
  LODE_CHECK(check_tetra_reading(arguments.reading, arguments.input));
  std::vector<std::string> inputs{arguments.input};
  if (!arguments.points_file.empty()) inputs.push_back(arguments.points_file);
  return check_paths_differ(inputs, arguments.output.empty()
                                        ? std::vector<std::string>{}
                                        : std::vector<std::string>{arguments.output});
}

Result<ProbeAnswer> answer_of(const TetraDataset& dataset, const ProbeJob& job,
                              Progress& progress) {
  ProbeAnswer answer;
  answer.has_regions = dataset.describe().regions.size() > 1;
  switch (job.kind) {
    case ProbeKind::points: {
      LODE_TRY(answer.report, dataset.probe(job.points, job.options, answer.points, progress));
      break;
    }
    case ProbeKind::line: {
      LODE_TRY(answer.report, dataset.probe_line(job.line, job.options, answer.line, progress));
      break;
    }
    case ProbeKind::integral: {
      LODE_TRY(answer.integral, dataset.integrate(job.integral, progress));
      answer.report = answer.integral->probe;
    }
  }
  return answer;
}

void warn_of_inverted_cells(Session& session, const TetraInput& input, const ProbeAnswer& answer) {
  if (const std::uint64_t n = input.n_inverted(); n > 0 && answer.integral)
    session.warn(fmt::format(
        "the mesh has {} inverted cells, folded over others: they count with the opposite sign, so "
        "volumes are of what the boundary encloses; bounds of the integral leave out that the "
        "field has several values there",
        n));
}

void warn_of_answer(Session& session, const ProbeAnswer& answer) {
  if (answer.integral && answer.integral->is_empty)
    session.warn("the integral is empty: no cell of the region has a part in the box or ball");
  if (!answer.points.empty() && answer.report.n_outside > 0)
    session.warn(
        fmt::format("{} of {} points are outside", answer.report.n_outside, answer.points.size()));
  if (answer.report.n_near_boundary > 0)
    session.warn(fmt::format(
        "{} of the points are outside of the cut, but no farther than its boundary may be off: "
        "if the field is there, it is from low to high",
        answer.report.n_near_boundary));
  const auto n_snapped = std::ranges::count_if(
      answer.points, [](const ProbedPoint& point) { return point.snapped > 0; });
  if (n_snapped > 0)
    session.note(fmt::format(
        "{} of the points are outside, and have what the nearest of the mesh has", n_snapped));
  if (!answer.integral && answer.points.empty() && answer.line.empty())
    session.warn("the line meets no cell");
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
  const std::string suffix = std::string(" ") + name_of(answer.report.error_place);
  table.add({"max error", answer.report.max_error == 0 ? std::string("0: full resolution")
                                                       : format_number(answer.report.max_error)});
  if (answer.report.max_error > 0)
    table.add({"achieved error", format_number(answer.report.achieved_error) + suffix});
  for (std::size_t f = 0; f < answer.with.size(); ++f) {
    const ProbedField& more = answer.report.along[f];
    table.add(
        {"with", answer.report.max_error == 0
                     ? answer.with[f]
                     : fmt::format("{}, error {} {}", answer.with[f],
                                   format_number(more.achieved_error), name_of(more.error_place))});
  }
  if (answer.integral && !answer.integral->is_empty) {
    const IntegralReport& report = *answer.integral;
    table.add({"cells", fmt::format("{}, {} of them whole", format_count(report.n_cells),
                                    format_count(report.n_whole))});
    table.add({"rounding", fmt::format("at most {:.3g} of the volume, {:.3g} of the integral",
                                       report.volume_rounding, report.integral_rounding)});
    if (report.integral_estimate > 0)
      table.add({"integral off by", format_number(report.integral_estimate) +
                                        (answer.report.error_place == ErrorPlace::everywhere
                                             ? " at most"
                                             : " by errors at samples, an estimate")});
  }
  if (answer.report.max_error > 0 && info.boundary_deviation > 0)
    table.add({"boundary", fmt::format("off by up to {}", format_number(info.boundary_deviation))});
  table.add({"cells of the cut", format_count(answer.report.n_cut_cells)});
  table.add({"probe", format_seconds(answer.report.seconds)});
  table.add({input.was_built() ? "read and build" : "open", format_seconds(input.seconds)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  return table;
}

Result<Outcome> run_probe(const ProbeArguments& arguments, Session& session) {
  LODE_TRY(ProbeJob job, to_probe_job(arguments, session.threads()));
  if (!arguments.output.empty()) LODE_CHECK(check_writable(arguments.output));
  if (!arguments.points_file.empty()) {
    LODE_TRY(const std::vector<Vec3d> more, read_points(arguments.points_file));
    job.points.insert(job.points.end(), more.begin(), more.end());
  }
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
  for (const std::size_t place : input.fields.along)
    answer.with.push_back(input.dataset.describe().fields[place].name);
  warn_of_answer(session, answer);
  warn_of_inverted_cells(session, input, answer);
  if (!arguments.output.empty())
    LODE_CHECK(write_text(arguments.output, probe_csv(answer), session.progress()));
  Outcome outcome;
  outcome.json = head_json(arguments, input, answer);
  const Table head = head_table(arguments, input, answer, outcome.json);
  outcome.json.update(probe_json(answer));
  outcome.json["cut_cells"] = answer.report.n_cut_cells;
  outcome.json["outside"] = answer.report.n_outside;
  outcome.json["near_boundary"] = answer.report.n_near_boundary;
  outcome.json["seconds"] = {{"total", answer.report.seconds}, {"open", input.seconds}};
  outcome.json["warnings"] = session.warnings();
  const std::string rows = probe_table(answer);
  outcome.text = head.to_string() + (rows.empty() ? "" : '\n' + rows);
  return outcome;
}

}  // namespace

Command add_probe_command(CLI::App& program) {
  auto arguments = std::make_shared<ProbeArguments>();
  CLI::App* app = program.add_subcommand(
      "probe", "Show values at points and along lines, and integrals, with their bounds");
  app->footer(
      "Of a mesh of cells, or a .lode file made from one. `low` and `high` are proven bounds of "
      "the\n"
      "field that was read; at full resolution they are those of rounding. `error` is what the\n"
      "cell states: the largest difference at the mesh's own vertices, or, of files that were "
      "built\n"
      "with --everywhere, at any point, and bounds are much closer. `near boundary`: outside of "
      "the\n"
      "coarser mesh, but no farther than its boundary may be off (info says how far), so the field "
      "may\n"
      "be there, and then between the bounds. Fields of --with are of the same cells, whose "
      "tolerance\n"
      "is that of --field. Quadratic cells count as the tetrahedra between their nodes, on which "
      "the\n"
      "field is linear: how it curves between these is not in the bounds.\n\n"
      "Examples:\n  lode probe wing.lode --point 1,0.5,2 --point 3,0,0\n"
      "  lode probe wing.lode --points sensors.csv -o values.csv\n"
      "  lode probe wing.lode --line 0,0,0:10,0,0 --max-error 0.01\n"
      "  lode probe wing.lode --integral --box 0,1,0,1,0,2\n"
      "  lode probe wing.lode --integral --field Pressure --with Temp --with Velocity:xyz\n"
      "  lode probe wing.vtu --integral --region rotor --json");
  app->add_option("file", arguments->input, ".lode file, or a mesh to build in memory")
      ->type_name("FILE")
      ->required();
  add_probe_options(*app, *arguments);
  add_reading_options(*app, arguments->reading);
  return {app, [arguments] { return check_probe_arguments(*arguments); },
          [arguments](Session& session) { return run_probe(*arguments, session); }};
}

}  // namespace lode::cli
