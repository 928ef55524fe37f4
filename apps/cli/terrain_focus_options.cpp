#include "terrain_focus_options.h"

#include "parse.h"

namespace lode::cli {
namespace {

Result<PlaceBox> parse_place_box(const std::string& text) {
  LODE_TRY(const std::vector<double> n, parse_numbers("--box", text));
  if (n.size() != 4)
    return fail("--box: expected four numbers as X0,X1,Y0,Y1 with terrain, got '{}'", text);
  if (n[0] > n[1] || n[2] > n[3])
    return fail("--box: expected X0 <= X1 and Y0 <= Y1, got '{}'", text);
  return PlaceBox{{{n[0], n[2]}}, {{n[1], n[3]}}};
}

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

}  // namespace

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
}

Result<std::optional<TerrainFocus>> to_terrain_focus(const QueryArguments& query,
                                                     const TerrainFocusArguments& arguments) {
  TerrainFocus focus;
  for (const std::string& text : query.boxes) {
    LODE_TRY(const PlaceBox box, parse_place_box(text));
    focus.boxes.push_back(box);
  }
  LODE_CHECK(add_point(arguments, focus));
  if (!query.max_error_outside.empty()) {
    LODE_TRY(const double outside, parse_number("--max-error-outside", query.max_error_outside));
    if (outside < 0)
      return fail("--max-error-outside: expected a number >= 0, got '{}'", query.max_error_outside);
    focus.max_error_outside = outside;
  }
  if (!focus.is_empty()) return std::optional(std::move(focus));
  if (focus.max_error_outside)
    return fail("--max-error-outside: expected --box or --focus-point with it");
  return std::optional<TerrainFocus>();
}

}  // namespace lode::cli
