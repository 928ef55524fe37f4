#pragma once

#include <optional>
#include <string_view>

namespace lode {

/// Metres of a unit of heights, as rasters name them, in letters of any case: m, metre, ft, foot,
/// us-ft and the like. Nothing for other names.
[[nodiscard]] std::optional<double> metres_of_unit(std::string_view name);

}  // namespace lode
