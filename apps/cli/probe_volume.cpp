#include "probe_volume.h"

#include <fmt/format.h>

#include "describe.h"
#include "input.h"
#include "lode/api/opened_terrain.h"
#include "outputs.h"
#include "parse.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

/// What has no third axis has nothing that is probed.
Result<void> expect_three_axes(const VolumeInfo& volume) {
  const Index3& dims = volume.grid.dims;
  if (dims[0] > 1 && dims[1] > 1 && dims[2] > 1) return {};
  return fail("probe: expected 3D data, got {} x {} x {} samples", dims[0], dims[1], dims[2]);
}

Json head_json(const ProbeArguments& arguments, const Input& input, const ProbeAnswer& answer) {
  Json json = extract_head(arguments.input, input,
                           arguments.output.empty() ? std::vector<std::string>{}
                                                    : std::vector<std::string>{arguments.output});
  json["command"] = "probe";
  json["field"] = input.info.volume.field_name;
  json["max_error"] = answer.report.max_error;
  json["achieved_error"] = answer.report.achieved_error;
  json["error_kind"] = "everywhere";
  json["boundary_deviation"] = 0;
  json["memory_met"] = answer.report.memory_met;
  if (!input.was_built) json["bytes_read"] = input.dataset.reads().bytes;
  return json;
}

/// What holds for all rows.
Table head_table(const ProbeArguments& arguments, const Input& input, const ProbeAnswer& answer) {
  const std::string& name = input.info.volume.field_name;
  Table table;
  table.add({"field", (name.empty() ? "" : name + ", ") +
                          format_range(input.info.range_min, input.info.range_max)});
  add_units(table, input.info.volume.units);
  add_probe_rows(answer, table);
  table.add({input.was_built ? "read and build" : "open", format_seconds(input.open_seconds)});
  if (!input.was_built) table.add({"read", format_bytes(input.dataset.reads().bytes)});
  if (!arguments.output.empty()) table.add({"output", arguments.output});
  return table;
}

}  // namespace

Result<void> check_volume_probe(const ProbeArguments& arguments) {
  const std::string& path = arguments.input;
  if (holds_terrain(path))
    return fail(
        "{}: expected a volume or a mesh of cells, got terrain, whose heights lode height and lode "
        "profile show",
        path);
  if (is_lode_path(path)) LODE_CHECK(check_lode_opens(path));
  if (!is_lode_path(path) && !is_volume_path(path) && arguments.reading.dims.empty())
    return fail(
        "{}: expected a volume, a mesh of cells (.vtu, ...), or a .lode file made from one, got "
        "another file",
        path);
  return check_reading_options(arguments.reading, path);
}

Result<Outcome> run_volume_probe(const ProbeArguments& arguments, const ProbeJob& asked,
                                 Session& session) {
  LODE_TRY(const Input input,
           open_input(session, arguments.input, arguments.reading, expect_three_axes));
  warn_of_limit(session, arguments.memory_limit, input);
  ProbeJob job = asked;
  set_share(arguments.max_error, input.info.range_min, input.info.range_max, job.options.max_error);
  job.integral.max_error = job.options.max_error;
  LODE_TRY(const ProbeAnswer answer, answer_of(input.dataset, job, session.progress()));
  warn_of_answer(session, answer, input.info.n_holes > 0);
  if (!arguments.output.empty())
    LODE_CHECK(write_text(arguments.output, probe_csv(answer), session.progress()));
  Outcome outcome;
  outcome.json = head_json(arguments, input, answer);
  finish_probe(answer, head_table(arguments, input, answer), input.open_seconds, session, outcome);
  return outcome;
}

}  // namespace lode::cli
