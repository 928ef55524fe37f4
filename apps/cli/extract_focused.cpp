#include "extract_focused.h"

#include "outputs.h"
#include "parse.h"
#include "salvage.h"
#include "stopwatch.h"
#include "text.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

std::string_view what_ended(const Standing& standing) {
  if (!standing.is_settled) return "the deadline";
  return standing.memory_met ? "the end of --max-cells" : "the memory limit";
}

/// Where the error bound holds. Outside of a focus anything may be left, unless that has a
/// tolerance.
const char* place_of_bound(const Query& query) {
  if (query.max_error_outside) return "everywhere";
  const bool has_regions =
      !query.boxes.empty() || !query.balls.empty() || !query.half_spaces.empty();
  if (query.view) return has_regions ? "in the focus, as far as it is in view" : "in view";
  return has_regions ? "in the focus" : "everywhere";
}

Json focused_json(const MeshJob& job, const Input& input, const FocusedReport& report,
                  const Surface& surface, const Query& query) {
  Json json = extract_head(job.input, input, {job.output});
  json["isovalues"] = query.isovalues;
  json["max_error"] = report.max_error ? Json(*report.max_error) : Json();
  json["max_error_px"] = report.max_error_px ? Json(*report.max_error_px) : Json();
  json["error_bound"] = report.standing.error_bound;
  json["error_bound_holds"] = place_of_bound(query);
  json["coordinate_slack"] = report.coordinate_slack;
  json["achieved_px"] = report.max_error_px ? Json(report.achieved_px) : Json();
  json["is_settled"] = report.standing.is_settled;
  json["budget_met"] = report.standing.budget_met;
  json["memory_met"] = report.standing.memory_met;
  json["steps"] = report.standing.n_steps;
  json["nodes"] = report.standing.n_applied;
  json["cells"] = report.standing.n_cells;
  json["was_clipped"] = report.was_clipped;
  json["triangles"] = surface.triangles.size();
  json["lines"] = surface.lines.size();
  json["vertices"] = surface.positions.size();
  json["components_dropped"] = report.components_dropped;
  json["triangles_dropped"] = report.triangles_dropped;
  json["seconds"]["total"] = report.seconds;
  json["seconds"]["world_errors"] = report.world_error_seconds;
  json["seconds"]["open"] = input.open_seconds + report.open_seconds;
  add_salvage(json, input.dataset.salvaged(), report.standing.error_bound);
  return json;
}

std::string focused_text(const MeshJob& job, const Input& input, const FocusedReport& report,
                         const Surface& surface, const Query& query, const ExtractOptions& plain) {
  Table table;
  if (report.max_error)
    table.add({"max error", *report.max_error == 0 && job.extraction.max_error.empty()
                                ? "as small as the limit allows"
                                : format_number(*report.max_error)});
  table.add(
      {"error bound", format_number(report.standing.error_bound) + ' ' + place_of_bound(query)});
  table.add({"coordinate slack", "at most " + format_number(report.coordinate_slack)});
  add_units(table, input.info.volume.units);
  add_salvage(table, input.dataset.salvaged(), report.standing.error_bound);
  if (report.max_error_px) {
    table.add({"max error in view", format_number(*report.max_error_px) + " pixels"});
    table.add({"achieved", format_number(report.achieved_px) + " pixels (estimate)"});
  }
  if (!report.standing.is_settled)
    table.add(
        {"deadline", fmt::format("reached after {} steps", format_count(report.standing.n_steps))});
  const bool is_lines = input.info.model == "diamond2d";
  table.add({is_lines ? "lines" : "triangles",
             format_count(is_lines ? surface.lines.size() : surface.triangles.size())});
  table.add({"vertices", format_count(surface.positions.size())});
  add_dropped(plain, report.components_dropped, report.triangles_dropped, is_lines, table);
  table.add({"simplices", format_count(report.standing.n_cells)});
  table.add({"extract", format_seconds(report.seconds)});
  if (report.max_error_px) table.add({"world errors", format_seconds(report.world_error_seconds)});
  table.add({input.was_built ? "read and build" : "open",
             format_seconds(input.open_seconds + report.open_seconds)});
  table.add({"output", job.output});
  return table.to_string();
}

void warn_of_focused(Session& session, const FocusedReport& report, const Surface& surface,
                     const ExtractOptions& options, const DatasetInfo& info, bool has_budget) {
  const double isovalue = options.isovalues.front();
  if (!report.standing.budget_met)
    session.warn(fmt::format("--max-cells is not met: the coarsest mesh has {} simplices",
                             report.standing.n_cells));
  if (!report.standing.memory_met)
    session.warn(
        fmt::format("the memory limit is too small for the tolerance everywhere: raise it, or "
                    "narrow the focus (error bound {})",
                    format_number(report.standing.error_bound)));
  if (report.max_error && *report.max_error > 0 && report.standing.budget_met &&
      report.standing.budget_ended && report.standing.error_bound > *report.max_error)
    session.warn(fmt::format("--max-error {} takes more than --max-cells: error bound {}",
                             format_number(*report.max_error),
                             format_number(report.standing.error_bound)));
  if (!surface.is_empty()) return;
  const bool is_limited = !report.standing.is_settled || !report.standing.memory_met || has_budget;
  if (report.components_dropped > 0) {
    session.warn(fmt::format("no surface at isovalue {}: all {} pieces are below --min-component",
                             isovalue, report.components_dropped));
  } else if (!is_limited || report.standing.error_bound == 0) {
    ExtractReport unmet;
    unmet.unmet = {isovalue};
    warn_of_unmet(session, unmet, options, info);
  } else {
    session.warn(fmt::format("no surface at isovalue {} yet: {} came too soon", isovalue,
                             what_ended(report.standing)));
  }
}

}  // namespace

Result<void> check_focused_job(const MeshJob& job) {
  LODE_CHECK(to_focused_options(job.query, job.extraction));
  LODE_CHECK(to_view(job.query));
  LODE_CHECK(check_surface_extension(job.output));
  LODE_CHECK(check_reading_options(job.reading, job.input));
  if (job.query.view.empty()) return check_paths_differ({job.input}, {job.output});
  return check_paths_differ({job.input, job.query.view}, {job.output});
}

Result<Outcome> run_focused_job(const MeshJob& job, Session& session) {
  LODE_TRY(FocusedOptions options, to_focused_options(job.query, job.extraction));
  options.threads = session.threads();
  if (!job.memory_limit.empty()) {
    LODE_TRY(options.memory_limit, parse_bytes("--memory-limit", job.memory_limit));
  }
  if (!job.query.view.empty()) {
    LODE_TRY(options.query.view, read_view(job.query));
  }
  LODE_CHECK(check_writable(job.output));
  const auto accept = [&](const VolumeInfo& volume) { return check_holds(job.output, volume); };
  LODE_TRY(const Input input, open_input(session, job.input, job.reading, accept));
  set_share(job.extraction.max_error, input.info.range_min, input.info.range_max,
            options.query.max_error);
  set_share(job.query.max_error_outside, input.info.range_min, input.info.range_max,
            options.query.max_error_outside);
  Surface surface;
  LODE_TRY(const FocusedReport report,
           extract_focused(input.dataset, options, surface, session.progress()));
  LODE_TRY(const ExtractOptions plain, to_extract_options(job.extraction));
  warn_of_coordinates(session, input.info.volume.grid);
  warn_of_limit(session, job.memory_limit, input);
  warn_of_boxes(options.query.boxes, input.info.volume.grid.world_bounds(), session);
  warn_of_focused(session, report, surface, plain, input.info, options.query.budget.is_limited());
  LODE_CHECK(write_surface(
      job.output, surface,
      {.comment = fmt::format("Lode {}: isovalue {}, error_bound {} {}{}{}", LODE_VERSION,
                              options.query.isovalues.front(), report.standing.error_bound,
                              place_of_bound(options.query), units_comment(input),
                              salvage_comment(input.dataset.salvaged())),
       .frame = input.info.volume.grid.frame,
       .threads = session.threads()},
      session.progress()));
  Outcome outcome;
  outcome.json = focused_json(job, input, report, surface, options.query);
  outcome.json["warnings"] = session.warnings();
  outcome.text = focused_text(job, input, report, surface, options.query, plain);
  return outcome;
}

}  // namespace lode::cli
