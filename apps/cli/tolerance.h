#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lode/api/dataset.h"

namespace lode::cli {

/// A tolerance as typed, >= 0: in field units, or with '%' a share of the range of the field's
/// values. Of shares NaN, which no query takes: set_share() has the number when the field is there.
[[nodiscard]] Result<double> parse_tolerance(std::string_view option, const std::string& text);

/// Of terrain, whose models may be built for a tolerance as their raster is read: with '%' the
/// share itself, as a fraction; is_share() tells.
[[nodiscard]] Result<double> parse_tolerance_or_share(std::string_view option,
                                                      const std::string& text);
[[nodiscard]] bool is_share(const std::string& text);

/// Tolerances >= 0 as typed, separated by commas: all of them with '%', as fractions, or none.
struct ToleranceList {
  std::vector<double> values;
  bool are_shares = false;
};
[[nodiscard]] Result<ToleranceList> parse_tolerances(std::string_view option,
                                                     const std::string& text);

/// Of a share as typed the tolerance in a field with values from `low` to `high`; others stay.
void set_share(const std::string& text, double low, double high, double& tolerance);
void set_share(const std::string& text, double low, double high, std::optional<double>& tolerance);

}  // namespace lode::cli
