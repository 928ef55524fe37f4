#include "asked_places.h"

#include "place_file.h"
#include "places_crs.h"
#include "terrain_query.h"

namespace lode::cli {
namespace {

Result<std::vector<Place>> typed_places(const AskedPlaces& arguments) {
  std::vector<Place> places;
  for (const std::string& text : arguments.typed) {
    LODE_TRY(const Place place, parse_place("--at", text));
    places.push_back(place);
  }
  return places;
}

}  // namespace

void add_asked_places(CLI::App& app, AskedPlaces& arguments) {
  app.add_option("points", arguments.file, "Places: x and y a line")->type_name("POINTS.csv");
  app.add_option("--at", arguments.typed, "A place; may be repeated")
      ->type_name("X,Y")
      ->allow_extra_args(false);
  add_places_crs(app, arguments.crs, "the places");
}

Result<void> check_asked_places(const AskedPlaces& arguments, const std::string& input) {
  if (auto places = typed_places(arguments); !places) return places.error();
  if (arguments.typed.empty() && arguments.file.empty())
    return fail("{}: expected POINTS.csv or --at X,Y, got neither", input);
  return check_places_crs(arguments.crs);
}

Result<std::vector<Place>> read_asked_places(const AskedPlaces& arguments) {
  LODE_TRY(std::vector<Place> places, typed_places(arguments));
  if (arguments.file.empty()) return places;
  LODE_TRY(const std::vector<Place> more, read_places(arguments.file));
  places.insert(places.end(), more.begin(), more.end());
  return places;
}

std::vector<std::string> asked_inputs(const AskedPlaces& arguments, const std::string& input) {
  std::vector<std::string> inputs{input};
  if (!arguments.file.empty()) inputs.push_back(arguments.file);
  return inputs;
}

const char* status_name(TerrainHeight::Where where) {
  if (where == TerrainHeight::Where::inside) return "inside";
  return where == TerrainHeight::Where::gap ? "gap" : "outside";
}

}  // namespace lode::cli
