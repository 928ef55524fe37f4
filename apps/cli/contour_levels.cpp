#include "contour_levels.h"

#include <algorithm>

#include "parse.h"

namespace lode::cli {

void add_level_options(CLI::App& app, LevelArguments& arguments) {
  app.add_option("--interval", arguments.interval, "Contours at all multiples of this height")
      ->type_name("DZ");
  app.add_option("--base", arguments.base, "With --interval: counted from here (default: 0)")
      ->type_name("Z");
  app.add_option("--isovalue", arguments.isovalues,
                 "Contours at these heights, with commas between; may be repeated")
      ->type_name("Z")
      ->allow_extra_args(false);
}

Result<ContourLevels> to_levels(const LevelArguments& arguments) {
  ContourLevels levels;
  if (arguments.interval.empty() == arguments.isovalues.empty())
    return fail("--interval: expected either it or --isovalue, got {}",
                arguments.interval.empty() ? "neither" : "both");
  if (!arguments.base.empty()) {
    if (arguments.interval.empty()) return fail("--base: expected --interval with it, got none");
    LODE_TRY(levels.base, parse_number("--base", arguments.base));
  }
  if (!arguments.interval.empty()) {
    LODE_TRY(levels.interval, parse_number("--interval", arguments.interval));
    if (levels.interval <= 0)
      return fail("--interval: expected a number > 0, got '{}'", arguments.interval);
    return levels;
  }
  for (const std::string& text : arguments.isovalues) {
    LODE_TRY(const std::vector<double> more, parse_numbers("--isovalue", text));
    levels.given.insert(levels.given.end(), more.begin(), more.end());
  }
  std::ranges::sort(levels.given);
  if (const auto twice = std::ranges::adjacent_find(levels.given); twice != levels.given.end())
    return fail("--isovalue: expected each value once, got {} twice", *twice);
  return levels;
}

Result<std::vector<double>> ContourLevels::within(double lowest, double highest) const {
  if (!given.empty()) return given;
  // At the lowest height and below it everything is above.
  auto levels = levels_between(base, interval, lowest, highest, LowestLevel::above);
  if (!levels) return fail("--interval: {}", levels.error().message);
  return levels;
}

}  // namespace lode::cli
