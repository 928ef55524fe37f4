#include "comparison_page.h"

#include <fmt/format.h>

#include <array>
#include <functional>

#include "log_plot.h"

namespace lode::cli {
namespace {

constexpr std::array kLineColors{"#2f6db3", "#d9822b", "#2f8f5b", "#8a8a8a", "#8e5bb5", "#b8433f",
                                 "#1f9e9e", "#b59a2f", "#d06fb0", "#5f7a2a", "#3d4f8f", "#7a4a2a"};

constexpr const char* kPageStyle =
    "body{font:15px/1.5 system-ui,sans-serif;color:#222;max-width:1180px;margin:2em auto;padding:0 "
    "1em}"
    "h1{font-size:1.5em}h2{font-size:1.15em;margin-top:2em}"
    "table{border-collapse:collapse;font-variant-numeric:tabular-nums;margin:.6em 0}"
    "th,td{padding:.25em .7em;text-align:right;border-bottom:1px solid #ddd}"
    "th{font-weight:600;border-bottom:2px solid #999;vertical-align:bottom}"
    "td:first-child,th:first-child{text-align:left}"
    ".note{color:#666}.no{color:#b8433f}"
    "svg text{font:12px system-ui,sans-serif;fill:#333}svg .title{font-weight:600;font-size:14px}"
    "svg .grid{stroke:#e4e4e4}";

/// A column of the tables: its heading, and a mesh's text in it.
struct Column {
  const char* heading;
  std::function<std::string(const ComparedMesh&)> text;
};

std::string milliseconds(double seconds) { return fmt::format("{:.3g}", 1e3 * seconds); }

std::vector<Column> columns() {
  const auto number = [](double value) { return format_number(value); };
  return {
      {"triangles", [](const ComparedMesh& m) { return format_count(m.triangles); }},
      {"vertices", [](const ComparedMesh& m) { return format_count(m.vertices); }},
      {"true error",
       [number](const ComparedMesh& m) {
         const std::string text = number(m.quality.worst_error);
         return m.is_met() ? text : "<span class=\"no\">" + text + "</span>";
       }},
      {"RMS", [number](const ComparedMesh& m) { return number(m.quality.rms_error); }},
      {"left out", [](const ComparedMesh& m) { return format_count(m.quality.n_uncovered); }},
      {"gaps",
       [number](const ComparedMesh& m) {
         return m.gaps.n_hanging == 0 ? std::string("none")
                                      : fmt::format("{}, up to {}", format_count(m.gaps.n_hanging),
                                                    number(m.gaps.largest));
       }},
      {"smallest angle, median",
       [](const ComparedMesh& m) {
         return fmt::format("{:.1f}°, {:.1f}°", m.quality.angles.smallest, m.quality.angles.median);
       }},
      {"MB",
       [](const ComparedMesh& m) {
         return fmt::format("{:.2f}", static_cast<double>(m.memory_bytes) / 1e6);
       }},
      {"extract ms", [](const ComparedMesh& m) { return milliseconds(m.extract_seconds); }},
      {"variable ms",
       [](const ComparedMesh& m) {
         return m.variable_seconds ? milliseconds(*m.variable_seconds) : "–";
       }},
      {"zoom ms",
       [](const ComparedMesh& m) { return m.zoom_seconds ? milliseconds(*m.zoom_seconds) : "–"; }},
      {"M found/s",
       [](const ComparedMesh& m) {
         return m.located_per_second ? fmt::format("{:.2f}", *m.located_per_second / 1e6) : "–";
       }},
      {"M steps/s",
       [](const ComparedMesh& m) {
         return m.crossed_per_second ? fmt::format("{:.1f}", *m.crossed_per_second / 1e6) : "–";
       }},
      {"contours ms",
       [](const ComparedMesh& m) {
         return m.contour_seconds ? milliseconds(*m.contour_seconds) : "–";
       }},
      {"locator ms", [](const ComparedMesh& m) { return milliseconds(m.locator_seconds); }},
      {"M heights/s",
       [](const ComparedMesh& m) { return fmt::format("{:.2f}", m.places_per_second / 1e6); }},
      {"profile ms",
       [](const ComparedMesh& m) {
         return m.profile_seconds ? milliseconds(*m.profile_seconds) : "–";
       }},
  };
}

std::string table_for(const TerrainComparison& comparison, std::size_t place) {
  std::string html = "<table><tr><th>model</th>";
  const std::vector<Column> all = columns();
  for (const Column& column : all) html += fmt::format("<th>{}</th>", column.heading);
  html += "</tr>\n";
  for (const ComparedModel& model : comparison.models) {
    if (!model.refusal.empty()) continue;
    html += fmt::format("<tr><td>{}</td>", escaped(model.name));
    for (const Column& column : all)
      html += fmt::format("<td>{}</td>", column.text(model.meshes[place]));
    html += "</tr>\n";
  }
  return html + "</table>\n";
}

/// Why there is no value for what it lacks.
std::string missing_text(const ComparedModel& model) {
  if (model.missing.empty()) return {};
  std::string html = "<br><span class=\"note\">–: ";
  for (std::size_t i = 0; i < model.missing.size(); ++i) {
    // One reason of several that follow each other is said once.
    const bool goes_on =
        i + 1 < model.missing.size() && model.missing[i + 1].why == model.missing[i].why;
    html += escaped(model.missing[i].what);
    html += goes_on ? ", " : fmt::format(" ({})", escaped(model.missing[i].why));
    if (!goes_on && i + 1 < model.missing.size()) html += "; ";
  }
  return html + "</span>";
}

std::string models_list(const TerrainComparison& comparison) {
  std::string html = "<ul>\n";
  for (const ComparedModel& model : comparison.models) {
    html += fmt::format("<li><b>{}</b>: {}", escaped(model.name), escaped(model.what));
    if (model.build_seconds)
      html += fmt::format("; {} in {}", model.is_made_anew ? "all meshes made" : "built",
                          format_seconds(*model.build_seconds));
    if (model.n_levels > 0)
      html += fmt::format("; {} levels: {}", model.n_levels, escaped(model.levels_are));
    if (model.memory_bytes)
      html += fmt::format("; {} of memory", format_bytes(*model.memory_bytes));
    if (model.peak_bytes)
      html += fmt::format("; {} took {} at most",
                          model.is_made_anew ? "making the finest mesh" : "building",
                          format_bytes(*model.peak_bytes));
    if (model.file_bytes) html += fmt::format("; file of {}", format_bytes(*model.file_bytes));
    if (model.n_links) html += fmt::format("; {} links", format_count(*model.n_links));
    html += fmt::format("; neighbours: {}", escaped(model.neighbours));
    html += missing_text(model);
    if (!model.refusal.empty())
      html += fmt::format("; <span class=\"no\">not run: {}</span>", escaped(model.refusal));
    html += "</li>\n";
  }
  return html + "</ul>\n";
}

/// Of each model that was run a line, its points by `of`.
std::string plot_of(const TerrainComparison& comparison, const std::string& title,
                    const std::string& x_name, const std::string& y_name,
                    const std::function<PlotLine::Point(const ComparedMesh&)>& of) {
  std::vector<PlotLine> lines;
  for (const ComparedModel& model : comparison.models) {
    if (!model.refusal.empty()) continue;
    PlotLine line{model.name, kLineColors[lines.size() % kLineColors.size()], {}};
    for (const ComparedMesh& mesh : model.meshes) line.points.push_back(of(mesh));
    lines.push_back(std::move(line));
  }
  return log_plot(title, x_name, y_name, lines);
}

std::string plots(const TerrainComparison& comparison, const std::string& unit) {
  const std::string of_unit = unit.empty() ? "" : " (" + unit + ")";
  std::string html =
      plot_of(comparison, "Triangles", "true largest error" + of_unit, "triangles",
              [](const ComparedMesh& m) {
                return PlotLine::Point{m.quality.worst_error, static_cast<double>(m.triangles)};
              });
  html += plot_of(comparison, "RMS error", "triangles", "RMS error" + of_unit,
                  [](const ComparedMesh& m) {
                    return PlotLine::Point{static_cast<double>(m.triangles), m.quality.rms_error};
                  });
  html += plot_of(comparison, "Extraction", "tolerance" + of_unit, "ms", [](const ComparedMesh& m) {
    return PlotLine::Point{m.tolerance, 1e3 * m.extract_seconds};
  });
  html += plot_of(comparison, "Contours", "triangles", "ms", [](const ComparedMesh& m) {
    return PlotLine::Point{static_cast<double>(m.triangles), 1e3 * m.contour_seconds.value_or(0)};
  });
  return html;
}

std::string angles_table(const TerrainComparison& comparison) {
  std::string html = "<table><tr><th>model, tolerance</th>";
  for (int i = 0; i < 12; ++i) html += fmt::format("<th>{}–{}°</th>", 5 * i, 5 * i + 5);
  html += "</tr>\n";
  for (const ComparedModel& model : comparison.models)
    for (const ComparedMesh& mesh : model.meshes) {
      html +=
          fmt::format("<tr><td>{}, {}</td>", escaped(model.name), format_number(mesh.tolerance));
      for (const std::uint64_t n : mesh.quality.angles.counts)
        html += fmt::format("<td>{:.1f}</td>", mesh.triangles == 0
                                                   ? 0.0
                                                   : 100 * static_cast<double>(n) /
                                                         static_cast<double>(mesh.triangles));
      html += "</tr>\n";
    }
  return html + "</table>\n";
}

/// Nothing in it may begin a tag or a comment; and whatever is no UTF-8 is replaced.
std::string script_text(const Json& json) {
  const std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string safe;
  for (const char c : text) safe += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return safe;
}

Json mesh_json(const ComparedMesh& mesh) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  const TinQuality& quality = mesh.quality;
  Json json;
  json["tolerance"] = mesh.tolerance;
  json["is_met"] = mesh.is_met();
  json["triangles"] = mesh.triangles;
  json["vertices"] = mesh.vertices;
  json["memory_bytes"] = mesh.memory_bytes;
  json["true_error"] = quality.worst_error;
  json["rms_error"] = quality.rms_error;
  json["stated_error"] = or_null(mesh.stated_error);
  json["uncovered_samples"] = quality.n_uncovered;
  json["hanging_vertices"] = mesh.gaps.n_hanging;
  json["largest_gap"] = mesh.gaps.largest;
  json["smallest_angle"] = quality.angles.smallest;
  json["median_angle"] = quality.angles.median;
  json["angles_by_5_degrees"] = quality.angles.counts;
  json["contour_points"] = mesh.contour_points;
  json["profile_points"] = mesh.profile_points;
  json["heights_per_second"] = mesh.places_per_second;
  json["variable_triangles"] =
      mesh.variable_seconds ? Json(mesh.variable_triangles) : Json(nullptr);
  json["zoom_triangles"] = mesh.zoom_seconds ? Json(mesh.zoom_triangles) : Json(nullptr);
  json["located_per_second"] = or_null(mesh.located_per_second);
  json["crossed_per_second"] = or_null(mesh.crossed_per_second);
  json["seconds"] = {{"extract", mesh.extract_seconds},
                     {"zoom", or_null(mesh.zoom_seconds)},
                     {"variable", or_null(mesh.variable_seconds)},
                     {"contours", or_null(mesh.contour_seconds)},
                     {"twins", or_null(mesh.twins_seconds)},
                     {"locator", mesh.locator_seconds},
                     {"profile", or_null(mesh.profile_seconds)}};
  return json;
}

}  // namespace

Json comparison_json(const TerrainComparison& comparison) {
  Json models = Json::array();
  for (const ComparedModel& model : comparison.models) {
    Json json{{"name", model.name}, {"what", model.what}};
    json["refusal"] = model.refusal.empty() ? Json(nullptr) : Json(model.refusal);
    json["build_seconds"] = model.build_seconds ? Json(*model.build_seconds) : Json(nullptr);
    json["is_made_anew"] = model.is_made_anew;
    json["neighbours"] = model.neighbours;
    json["levels"] = model.n_levels > 0 ? Json(model.n_levels) : Json(nullptr);
    json["levels_are"] = model.levels_are.empty() ? Json(nullptr) : Json(model.levels_are);
    json["memory_bytes"] = model.memory_bytes ? Json(*model.memory_bytes) : Json(nullptr);
    json["peak_build_bytes"] = model.peak_bytes ? Json(*model.peak_bytes) : Json(nullptr);
    json["file_bytes"] = model.file_bytes ? Json(*model.file_bytes) : Json(nullptr);
    json["links"] = model.n_links ? Json(*model.n_links) : Json(nullptr);
    Json& missing = json["missing"] = Json::object();
    for (const auto& [what, why] : model.missing) missing[what] = why;
    json["meshes"] = Json::array();
    for (const ComparedMesh& mesh : model.meshes) json["meshes"].push_back(mesh_json(mesh));
    models.push_back(std::move(json));
  }
  return models;
}

std::string comparison_page(const TerrainComparison& comparison, const ComparedRaster& raster,
                            const Json& json) {
  std::string html = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}: models of "
      "terrain</title>\n<style>{1}</style></head><body>\n<h1>{0}: models of terrain</h1>\n",
      escaped(raster.path), kPageStyle);
  html += fmt::format("<p>{}; {} samples with heights from {} to {}{}. Lode {}, {}.</p>\n",
                      escaped(raster.size), format_count(comparison.n_samples),
                      format_number(comparison.range.lower), format_number(comparison.range.upper),
                      raster.unit.empty() ? "" : " " + escaped(raster.unit), LODE_VERSION,
                      escaped(raster.machine));
  html += models_list(comparison);
  html +=
      "<p class=\"note\">True errors are vertical, at all samples or points, measured on each mesh "
      "by the same means; in red where beyond the tolerance. Left out: samples in no triangle. "
      "Variable: within the tolerance in the middle, from 3/8 to 5/8 of columns and rows, a "
      "sixteenth of the area, ten times outside. Zoom: the triangles that meet the same part, from "
      "the model, without a mesh. Found: samples located in the model, one thread, without a mesh. "
      "Contours: 20 levels. Heights: random places, one thread. Steps: a random walk from triangle "
      "to triangle, over edges, one thread. Profile: near the diagonal. MB: triangles, what is "
      "beside them, errors and vertices. Times are medians. – stands for what a model has not; "
      "the list above says why.</p>\n";
  if (raster.is_in_angles)
    html +=
        "<p class=\"note\">Angles of triangles are those in the plane of longitudes and latitudes, "
        "where a degree east is as long as one north.</p>\n";
  html += plots(comparison, raster.unit);
  // The selector is never refused.
  const std::size_t n = comparison.models.front().meshes.size();
  for (std::size_t i = 0; i < n; ++i)
    html += fmt::format("<h2>Tolerance {}</h2>\n{}",
                        format_number(comparison.models.front().meshes[i].tolerance),
                        table_for(comparison, i));
  html += "<h2>Triangles by their smallest angle, per cent</h2>\n" + angles_table(comparison);
  return html + "<script type=\"application/json\" id=\"comparison\">" + script_text(json) +
         "</script>\n</body></html>\n";
}

}  // namespace lode::cli
