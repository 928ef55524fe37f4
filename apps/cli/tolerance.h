#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "lode/api/dataset.h"

namespace lode::cli {

/// A tolerance as typed, >= 0: in field units, or with '%' a share of the range of the field's
/// values. Of shares NaN, which no query takes: set_share() has the number when the field is there.
[[nodiscard]] Result<double> parse_tolerance(std::string_view option, const std::string& text);

/// Of a share as typed the tolerance in a field with values from `low` to `high`; others stay.
void set_share(const std::string& text, double low, double high, double& tolerance);
void set_share(const std::string& text, double low, double high, std::optional<double>& tolerance);

}  // namespace lode::cli
