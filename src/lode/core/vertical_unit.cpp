#include "lode/core/vertical_unit.h"

#include <array>
#include <string>

namespace lode {

std::optional<double> metres_of_unit(std::string_view name) {
  struct Unit {
    std::string_view name;  ///< In small letters.
    double metres;
  };
  constexpr double kFoot = 0.3048;
  constexpr double kSurveyFoot = 1200.0 / 3937;
  constexpr std::array<Unit, 16> kUnits{{{"m", 1},
                                         {"metre", 1},
                                         {"metres", 1},
                                         {"meter", 1},
                                         {"meters", 1},
                                         {"ft", kFoot},
                                         {"foot", kFoot},
                                         {"feet", kFoot},
                                         {"international foot", kFoot},
                                         {"us-ft", kSurveyFoot},
                                         {"ftus", kSurveyFoot},
                                         {"us survey foot", kSurveyFoot},
                                         {"us_foot", kSurveyFoot},
                                         {"foot_us", kSurveyFoot},
                                         {"cm", 0.01},
                                         {"km", 1000}}};
  std::string small(name);
  for (char& c : small)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  for (const Unit& known : kUnits)
    if (known.name == small) return known.metres;
  return std::nullopt;
}

}  // namespace lode
