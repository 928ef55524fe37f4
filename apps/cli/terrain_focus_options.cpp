#include "terrain_focus_options.h"

#include <cmath>
#include <utility>

#include "parse.h"
#include "render_tetra.h"
#include "terrain_query.h"
#include "tolerance.h"

namespace lode::cli {
namespace {

Result<void> add_point(const TerrainFocusArguments& arguments, TerrainFocus& focus) {
  if (arguments.point.empty()) {
    if (!arguments.growth.empty()) return fail("--growth: expected --focus-point with it");
    return {};
  }
  LODE_TRY(const std::vector<double> n, parse_numbers("--focus-point", arguments.point));
  if (n.size() != 2)
    return fail("--focus-point: expected two numbers as X,Y, got '{}'", arguments.point);
  focus.point = Place{{n[0], n[1]}};
  if (arguments.growth.empty()) return fail("--focus-point: expected --growth with it");
  LODE_TRY(focus.growth, parse_number("--growth", arguments.growth));
  if (focus.growth < 0) return fail("--growth: expected a number >= 0, got '{}'", arguments.growth);
  return {};
}

/// In the view hold pixels, and --max-error where that is not for places, or nothing else is said.
Result<void> add_view(const QueryArguments& query, const TerrainFocusArguments& arguments,
                      const std::string& max_error, TerrainFocus& focus) {
  if (query.view.empty()) {
    for (const auto& [name, is_set] : {std::pair{"--view-size", !query.view_size.empty()},
                                       {"--max-error-px", !query.max_error_px.empty()},
                                       {"--exaggeration", !arguments.exaggeration.empty()}})
      if (is_set) return fail("{}: expected --view with it", name);
    return {};
  }
  TerrainView& wanted = focus.view.emplace();
  LODE_TRY(wanted.view, to_view(query));
  if (!query.max_error_px.empty()) {
    LODE_TRY(wanted.max_error_px, parse_number("--max-error-px", query.max_error_px));
    if (*wanted.max_error_px < 0)
      return fail("--max-error-px: expected a number >= 0, got '{}'", query.max_error_px);
  }
  if (!arguments.exaggeration.empty()) {
    LODE_TRY(wanted.exaggeration, parse_number("--exaggeration", arguments.exaggeration));
    if (!(*wanted.exaggeration > 0))
      return fail("--exaggeration: expected a number > 0, got '{}'", arguments.exaggeration);
  }
  wanted.has_tolerance = !wanted.max_error_px || (!max_error.empty() && !focus.has_place());
  return {};
}

}  // namespace

Result<PlaceBox> parse_place_box(const char* option, const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers(option, text));
  if (n.size() != 4)
    return fail("{}: expected four numbers as X0,X1,Y0,Y1 with terrain, got '{}'", option, text);
  if (n[0] > n[1] || n[2] > n[3])
    return fail("{}: expected X0 <= X1 and Y0 <= Y1, got '{}'", option, text);
  return PlaceBox{{{n[0], n[2]}}, {{n[1], n[3]}}};
}

std::string describe_achieved(double pixels) {
  return std::isfinite(pixels) ? fmt::format("{} pixels", format_number(pixels))
                               : "any number of pixels, as triangles reach to the camera";
}

void add_terrain_focus_options(CLI::App& app, TerrainFocusArguments& arguments) {
  const char* group = "Focus and budget";
  app.add_option("--focus-point", arguments.point,
                 "Of terrain: accurate there, and less by --growth with distance")
      ->type_name("X,Y")
      ->group(group);
  app.add_option("--growth", arguments.growth,
                 "How much larger the tolerance gets with each unit of distance (metre, where "
                 "coordinates are angles)")
      ->type_name("G")
      ->group(group);
  app.add_option("--exaggeration", arguments.exaggeration,
                 "Of terrain: heights count so many times in the --view (default: as in lode "
                 "render)")
      ->type_name("X")
      ->group(group);
}

Result<std::optional<TerrainFocus>> to_terrain_focus(const QueryArguments& query,
                                                     const TerrainFocusArguments& arguments,
                                                     const std::string& max_error) {
  TerrainFocus focus;
  for (const std::string& text : query.boxes) {
    LODE_TRY(const PlaceBox box, parse_place_box("--box", text));
    focus.boxes.push_back(box);
  }
  LODE_CHECK(add_point(arguments, focus));
  LODE_CHECK(add_view(query, arguments, max_error, focus));
  if (!query.max_error_outside.empty()) {
    LODE_TRY(focus.max_error_outside,
             parse_tolerance_or_share("--max-error-outside", query.max_error_outside));
  }
  if (!focus.is_empty()) return std::optional(std::move(focus));
  if (focus.max_error_outside)
    return fail("--max-error-outside: expected --box, --focus-point or --view with it");
  return std::optional<TerrainFocus>();
}

void warn_of_boxes(const TerrainFocus& focus, const HeightFrame& frame, Session& session) {
  constexpr double kLittle = 1e-4;
  for (const PlaceBox& box : focus.boxes)
    if (const double share = share_outside(near_terrain(box, focus.metric, frame), frame);
        share > kLittle)
      session.warn(fmt::format(
          "--box {},{},{},{}: {:.3g} % of it lie outside of the terrain's columns and rows, and "
          "count for nothing",
          format_number(box.lower[0]), format_number(box.upper[0]), format_number(box.lower[1]),
          format_number(box.upper[1]), 100 * share));
}

Json focus_json(const std::optional<TerrainFocus>& focus,
                const std::optional<TerrainViewReport>& report) {
  if (!focus) return nullptr;
  Json json;
  json["boxes"] = Json::array();
  for (const PlaceBox& box : focus->boxes)
    json["boxes"].push_back({box.lower[0], box.upper[0], box.lower[1], box.upper[1]});
  json["point"] = nullptr;
  json["growth"] = nullptr;
  if (focus->point) {
    json["point"] = {(*focus->point)[0], (*focus->point)[1]};
    json["growth"] = focus->growth;
    add_metric(focus->metric, json);
  }
  json["view"] = nullptr;
  if (focus->view && report)
    json["view"] = {
        {"camera", camera_json(focus->view->view.camera)},
        {"size", fmt::format("{}x{}", focus->view->view.width, focus->view->view.height)},
        {"exaggeration", report->exaggeration},
        {"exaggeration_is_default", !focus->view->exaggeration.has_value()},
        {"height_unit_is_known", report->is_vertical_unit_known},
        {"shown_triangles", report->n_shown}};
  json["max_error_outside"] =
      focus->max_error_outside ? Json(*focus->max_error_outside) : Json(nullptr);
  return json;
}

void add_focus_rows(const TerrainFocus& focus, Table& table) {
  if (!focus.point) return;
  table.add({"growth", fmt::format("{}, distances in {}", format_number(focus.growth),
                                   describe_metric(focus.metric))});
}

void add_view_rows(const TerrainFocus& focus, const TerrainViewReport& report, Table& table) {
  if (report.max_error_px)
    table.add({"max error in view", format_number(*report.max_error_px) + " pixels"});
  table.add({"achieved in view", describe_achieved(report.achieved_px)});
  table.add({"heights in view", fmt::format("{} times{}", format_number(report.exaggeration),
                                            focus.view->exaggeration ? "" : " (default)")});
  table.add({"in view", fmt::format("{} triangles", format_count(report.n_shown))});
}

void warn_of_view(const TerrainViewReport& report, TerrainModel model, double finest_error,
                  Session& session) {
  if (report.n_shown == 0)
    session.warn(
        "the view shows no terrain: cameras are in metres from the raster's middle, as lode render "
        "--save-camera writes them");
  if (report.is_within_error()) return;
  session.warn(fmt::format(
      "--max-error-px is not met: {}, of up to {}",
      model == TerrainModel::surface_quadtree
          ? "it holds for bilinear squares; their triangles show errors"
          : fmt::format("the model, built within {}, shows errors", format_number(finest_error)),
      describe_achieved(report.achieved_px)));
}

}  // namespace lode::cli
