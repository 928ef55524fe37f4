#include "terrain_answer.h"

#include <fmt/format.h>

#include <cmath>

#include "parse.h"
#include "terrain_clip.h"
#include "terrain_facts.h"
#include "terrain_query.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

/// Whether max_error holds somewhere: there may be pixels of a view alone.
bool has_tolerance(const std::optional<TerrainFocus>& focus) {
  return !focus || focus->has_place() || focus->view->has_tolerance;
}

/// Pixels, if there are some that can be told.
Json pixels_json(const std::optional<double>& pixels) {
  return pixels && std::isfinite(*pixels) ? Json(*pixels) : Json(nullptr);
}

}  // namespace

Json answer_json(const TerrainAnswer& answer, Table& table, const Session& session) {
  const TerrainReport& report = answer.report;
  Json json;
  json["command"] = "extract";
  json["input"] = answer.job.input;
  json["outputs"] = Json::array({answer.job.output});
  if (!answer.job.raster.difference.empty())
    json["outputs"].push_back(answer.job.raster.difference);
  json["model"] = name_of(answer.opened.model);
  if (!is_on_squares(answer.opened.model) && !is_hierarchy(answer.opened.model) &&
      !is_pyramid_of_levels(answer.opened.model))
    json["insertion"] = name_of(answer.order);
  json["is_uniform"] = report.is_uniform;
  const auto& focus = answer.options.focus;
  json["focus"] = focus_json(focus, report.view);
  json["clip"] = clip_json(answer.clip);
  json["max_error"] = has_tolerance(focus) ? Json(report.max_error) : Json(nullptr);
  json["max_error_is_default"] = answer.job.max_error.empty();
  json["max_error_px"] = pixels_json(report.view ? report.view->max_error_px : std::nullopt);
  json["achieved_px"] =
      pixels_json(report.view ? std::optional(report.view->achieved_px) : std::nullopt);
  json["achieved_error"] = report.achieved_error;
  json["error_kind"] = "at samples";
  json["error_met"] = report.is_within_error;
  json["budget_met"] = report.budget_met;
  const bool has_one = report.is_uniform && has_tolerance(focus) &&
                       (!answer.job.max_error.empty() || answer.job.query.max_cells.empty());
  json["to_crs"] =
      mapped_json(answer.mapped, has_one ? std::optional(report.max_error) : std::nullopt);
  json["triangles"] = report.triangles;
  json["vertices"] = report.vertices;
  add_facts(answer.opened.facts, json, table);
  add_lines(answer.opened, json, table);
  json["samples"] = report.n_samples;
  json["left_out_samples"] = report.n_left_out;
  if (answer.raster) {
    add_raster(*answer.raster, answer.opened.facts.form, json, table);
  } else {
    json["height_slack"] = report.height_slack;
    json["position_slack"] = report.position_slack;
    json["turned_triangles"] = report.n_turned;
    if (answer.job.terrain.wrap) json["one_sided_vertices"] = report.n_one_sided;
  }
  const double map_seconds = answer.mapped ? answer.mapped->seconds : 0;
  json["seconds"] = {
      {"total", answer.read_seconds + report.seconds + map_seconds + answer.write_seconds},
      {"read", answer.read_seconds},
      {"select", report.seconds},
      {"write", answer.write_seconds}};
  json["warnings"] = session.warnings();
  return json;
}

void add_rows(const TerrainAnswer& answer, Table& table) {
  const TerrainReport& report = answer.report;
  if (report.n_left_out > 0)
    table.add({"left out",
               fmt::format("{} {}", format_count(report.n_left_out),
                           answer.opened.facts.points ? "points outside of the domain"
                                                      : "samples in no cell with four heights")});
  table.add({"model", name_of(answer.opened.model)});
  if (has_tolerance(answer.options.focus)) {
    const bool is_given = !answer.job.max_error.empty();
    const bool is_budget = !is_given && !answer.job.query.max_cells.empty();
    std::string said = is_budget
                           ? "as small as --max-cells allows"
                           : fmt::format("{} ({})", format_number(report.max_error),
                                         is_given ? "as asked" : "default: 0.5 % of the range");
    if (!report.is_uniform) said += ", in the focus";
    table.add({"max error", std::move(said)});
  }
  if (answer.options.focus) add_focus_rows(*answer.options.focus, table);
  if (report.view) add_view_rows(*answer.options.focus, *report.view, table);
  table.add({"achieved error", fmt::format("{} at samples{}", format_number(report.achieved_error),
                                           answer.mapped ? ", in the CRS of the file" : "")});
  if (answer.mapped) add_mapped_rows(*answer.mapped, table);
  add_clip_row(answer.clip, table);
  table.add({"triangles", format_count(report.triangles)});
  table.add({"vertices", format_count(report.vertices)});
  table.add({"read", format_seconds(answer.read_seconds)});
  table.add({"select", format_seconds(report.seconds)});
  table.add({"write", format_seconds(answer.write_seconds)});
  table.add({"output", answer.job.output});
  if (!answer.job.raster.difference.empty()) table.add({"output", answer.job.raster.difference});
}

std::string summary_of(const TerrainReport& report, const OpenedTerrain& opened,
                       InsertionOrder order) {
  const std::string& unit = opened.facts.frame.vertical_unit;
  const std::string tolerance =
      report.view && report.view->max_error_px
          ? fmt::format("max_error_px {} in view", *report.view->max_error_px)
          : fmt::format("max_error {}", report.max_error);
  return fmt::format("Lode {}: {}{}, {}, achieved_error {}{} at samples", LODE_VERSION,
                     name_of(opened.model),
                     order == InsertionOrder::tiles ? ", insertion tiles" : "", tolerance,
                     report.achieved_error, unit.empty() ? "" : " " + unit);
}

/// Of surfaces, whose files have no other place for a CRS.
std::string comment_of(const TerrainReport& report, const OpenedTerrain& opened,
                       InsertionOrder order, const std::optional<MappedAnswer>& mapped) {
  const std::string& own = opened.facts.frame.crs;
  const std::string summary = summary_of(report, opened, order);
  if (!mapped) return summary + (own.empty() ? "" : ", CRS " + own);
  return fmt::format(
      "{} of its source, {} in this CRS at {}, CRS {}", summary, mapped->errors.error,
      mapped->measured_at == MeasuredAt::samples ? "samples" : "kept vertices", mapped->target.crs);
}

/// Where they are larger than what was asked.
void warn_of_errors(const TerrainReport& report, const OpenedTerrain& opened, const TerrainJob& job,
                    Session& session) {
  if (report.n_beyond > 0 && (!report.view || report.view->is_within_error()))
    session.warn(
        fmt::format("the tolerances hold for bilinear squares; at {} samples their triangles err "
                    "by more than is asked there, by up to {}",
                    format_count(report.n_beyond), format_number(report.worst_beyond)));
  if (report.view) {
    warn_of_view(*report.view, opened.model, opened.terrain.origin().finest_error(), session);
    if (const auto metric = read_metric(opened.facts.frame.crs))
      warn_of_unit(report.view->is_vertical_unit_known, opened.facts.frame, *metric, job.input,
                   session);
  } else if (report.is_uniform && opened.model == TerrainModel::surface_quadtree &&
             !(job.max_error.empty() && !job.query.max_cells.empty()) && !report.is_within_error)
    session.warn(
        fmt::format("the tolerance{} holds for bilinear squares; their triangles err by up to {}",
                    job.query.max_cells.empty() ? "" : ", as far as --max-cells allows it,",
                    format_number(report.achieved_error)));
  else if (report.is_uniform && !job.max_error.empty() && !report.is_within_error)
    session.warn(fmt::format("--max-error is not met: --max-cells allows {} only",
                             format_number(report.achieved_error)));
}

void warn_of(const TerrainReport& report, const OpenedTerrain& opened, const TerrainJob& job,
             const std::optional<TerrainFocus>& focus, const std::optional<TerrainClip>& clip,
             Session& session) {
  constexpr double kMuch = 1e-3;
  if (report.height_slack > kMuch * report.max_error)
    session.warn(fmt::format(
        "coordinates are floats: heights of vertices in {} are off by up to {}{}; .ply, .obj and "
        ".vtp hold them in float64",
        job.output, format_number(report.height_slack),
        opened.facts.frame.vertical_unit.empty() ? "" : " " + opened.facts.frame.vertical_unit));
  if (report.n_turned > 0)
    session.warn(
        fmt::format("coordinates are floats: {} triangles in {}, thinner than these tell, "
                    "are turned over or flat",
                    format_count(report.n_turned), job.output));
  if (report.n_one_sided > 0)
    session.warn(fmt::format(
        "--wrap: {} promises nothing where its first and last column meet: {} vertices of {} there "
        "lie in an edge of the other side, with cracks as high as its error; the delaunay_selector "
        "has the same vertices on both sides",
        name_of(opened.model), format_count(report.n_one_sided), job.output));
  const std::uint64_t n_triangles = clip ? clip->n_triangles : report.triangles;
  const std::uint64_t full = n_full_triangles(opened.facts, report.n_samples);
  if (is_hierarchy(opened.model) && n_triangles > full)
    session.warn(
        fmt::format("{} triangles are more than the {} of all samples, which "
                    "--max-error 0 of the delaunay_selector has at most",
                    format_count(n_triangles), format_count(full)));
  if (!report.budget_met)
    session.warn(fmt::format("--max-cells is not met: {} has {} triangles",
                             is_hierarchy(opened.model) || is_pyramid_of_levels(opened.model)
                                 ? "the coarsest level"
                             : opened.lines.has_value() ? "the outline with its lines"
                                                        : "the outline alone",
                             report.triangles));
  warn_of_errors(report, opened, job, session);
  if (!report.is_uniform && report.is_focus_empty && !report.view)
    session.warn("the focus meets no triangle of the terrain: is it in its CRS?");
  else if (focus)
    warn_of_boxes(*focus, opened.facts.frame, session);
}

}  // namespace lode::cli
