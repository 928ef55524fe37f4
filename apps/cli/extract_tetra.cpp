#include "extract_tetra.h"

#include <array>
#include <utility>

#include "outputs.h"
#include "parse.h"
#include "stopwatch.h"
#include "text.h"

namespace lode::cli {
namespace {

Result<TetraOptions> to_tetra_options(const ReadingArguments& reading) {
  if (reading.field.empty()) {
    if (reading.component.empty()) return TetraOptions();
    return fail("--component: expected --field with it, got none");
  }
  std::string field = reading.field;
  if (!reading.component.empty() && reading.component != "magnitude")
    field += ":" + reading.component;
  return TetraOptions{.fields = {std::move(field)}};
}

/// What was made of the file's cells, as far as a user may wonder at it.
void add_counts(const TetraReport& report, Table& table, Json& json) {
  struct Count {
    const char* key;
    const char* name;
    std::uint64_t n;
  };
  const std::array<Count, 12> counts{
      {{"ghost_cells", "ghost cells left out", report.n_ghost_cells},
       {"hidden_cells", "hidden cells left out", report.n_hidden_cells},
       {"lower_cells", "points, lines and faces left out", report.n_lower_cells},
       {"unused_points", "unused points left out", report.n_unused_points},
       {"coincident_points", "points at another's place", report.n_coincident_points},
       {"new_points", "centres of polyhedra", report.n_new_points},
       {"repeating", "cells with a corner twice left out", report.n_repeating},
       {"zero_volume", "cells without volume", report.n_zero_volume},
       {"left_handed", "left-handed cells turned", report.n_left_handed},
       {"turned_wedges", "wedges turned", report.n_turned_wedges},
       {"inverted", "inverted cells", report.n_inverted},
       {"components", "components", report.n_components}}};
  for (const Count& count : counts) {
    json[count.key] = count.n;
    const std::uint64_t usual = std::string_view(count.key) == "components" ? 1 : 0;
    if (count.n > usual) table.add({count.name, format_count(count.n)});
  }
}

/// A dataset, and what came of the file's cells.
struct TetraInput {
  TetraDataset dataset;
  TetraReport report;
  double seconds = 0;
};

Result<TetraInput> build_input(const MeshJob& job, Session& session) {
  const Stopwatch watch;
  LODE_TRY(const TetraOptions options, to_tetra_options(job.reading));
  LODE_TRY(CellMesh cells, read_cell_mesh(job.input, {}));
  session.note(fmt::format("{}: not a .lode file; building its hierarchy in memory", job.input));
  LODE_TRY(TetrahedraOutcome made, to_tetrahedra(std::move(cells), options));
  if (made.mesh.fields.size() != 1) {
    std::string names;
    for (const MeshField& field : made.mesh.fields)
      names += (names.empty() ? "" : ", ") + field.name;
    return fail("{}: expected --field to name one of its fields ({}), got none", job.input,
                names.empty() ? "there are none" : names);
  }
  TetraReport report = made.report;
  auto built = TetraDataset::build(made.mesh, {.threads = session.threads()}, session.progress());
  if (!built) {
    if (session.progress().is_cancelled()) return built.error();
    return fail("{}: {}", job.input, built.error().message);
  }
  return TetraInput{std::move(*built), std::move(report), watch.seconds()};
}

Outcome report_outcome(const MeshJob& job, const TetraInput& input, const MeshReport& report,
                       bool is_default, double write_seconds, const Session& session) {
  const TetraInfo& info = input.dataset.describe();
  Outcome outcome;
  Json& json = outcome.json;
  json["command"] = "extract";
  json["input"] = job.input;
  json["outputs"] = Json::array({job.output});
  json["model"] = "tetra_mt";
  json["built_in_memory"] = true;
  json["field"] = info.field;
  json["max_error"] = report.max_error;
  json["max_error_is_default"] = is_default;
  json["achieved_error"] = report.achieved_error;
  json["largest_error"] = report.largest_error;
  json["error_kind"] = "at samples";
  json["cells"] = report.n_cells;
  json["vertices"] = report.n_vertices;
  json["reference_cells"] = info.n_cells;
  json["reference_vertices"] = info.n_vertices;
  json["base_cells"] = info.n_base_cells;
  json["budget_met"] = report.budget_met;
  json["seconds"] = {{"total", report.seconds}, {"open", input.seconds}, {"write", write_seconds}};
  Table table;
  table.add({"field", fmt::format("{}, {} to {}", info.field, format_number(info.range_min),
                                  format_number(info.range_max))});
  table.add({"reference", fmt::format("{} cells, {} vertices", format_count(info.n_cells),
                                      format_count(info.n_vertices))});
  add_counts(input.report, table, json["reading"]);
  table.add({"base", fmt::format("{} cells, error {} at samples", format_count(info.n_base_cells),
                                 format_number(info.base_error))});
  table.add(
      {"max error",
       format_number(report.max_error) +
           (is_default && report.max_error > 0 ? " (default: 0.5 % of the value range)" : "")});
  table.add({"achieved error", format_number(report.achieved_error) + " at samples"});
  table.add({"error anywhere", format_number(report.largest_error) + " at samples"});
  table.add({"cells", format_count(report.n_cells)});
  table.add({"vertices", format_count(report.n_vertices)});
  table.add({"extract", format_seconds(report.seconds)});
  table.add({"read and build", format_seconds(input.seconds)});
  table.add({"write", format_seconds(write_seconds)});
  table.add({"output", job.output});
  outcome.text = table.to_string();
  json["warnings"] = session.warnings();
  return outcome;
}

}  // namespace

Result<void> check_tetra_job(const MeshJob& job) {
  if (!job.query.is_mesh)
    return fail(
        "{}: expected --mesh, as of a mesh of cells neither surfaces nor sections are made yet",
        job.input);
  LODE_CHECK(to_mesh_options(job.query, job.extraction));
  LODE_CHECK(check_mesh_path(job.output));
  LODE_CHECK(to_tetra_options(job.reading));
  ReadingArguments others = job.reading;
  others.field.clear();
  others.component.clear();
  if (!others.is_empty() || others.salvage)
    return fail("{}: expected no options of reading but --field and --component, got others",
                job.input);
  if (!job.memory_limit.empty())
    return fail("--memory-limit: expected none with a mesh of cells, which is built in memory");
  return check_paths_differ({job.input}, {job.output});
}

Result<Outcome> run_tetra_job(const MeshJob& job, Session& session) {
  LODE_CHECK(check_writable(job.output));
  LODE_TRY(const MeshOptions options, to_mesh_options(job.query, job.extraction));
  LODE_TRY(const TetraInput input, build_input(job, session));
  SimplexMesh mesh;
  LODE_TRY(const MeshReport report, input.dataset.extract_mesh(options, mesh, session.progress()));
  if (!report.budget_met)
    session.warn(fmt::format("--max-cells is not met: the coarsest mesh has {} simplices",
                             report.n_cut_cells));
  const Stopwatch watch;
  LODE_CHECK(
      write_vtu(job.output, mesh,
                {.comment = fmt::format("Lode {}: mesh, max_error {}, achieved_error {} at samples",
                                        LODE_VERSION, report.max_error, report.achieved_error),
                 .value_name = input.dataset.describe().field},
                session.progress()));
  return report_outcome(job, input, report, !options.query.max_error, watch.seconds(), session);
}

}  // namespace lode::cli
