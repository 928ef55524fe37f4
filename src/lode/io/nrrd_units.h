#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lode/io/nrrd_axes.h"

namespace lode::io {

/// Of a list of texts in quotes, in which a backslash stands before quotes and backslashes, all of
/// them; nothing where it is no such list.
[[nodiscard]] std::optional<std::vector<std::string>> split_quoted(std::string_view list);

/// The unit that "space units" name, or "units" for the axes of space, which are marked: where all
/// that have one have the same. `note`: gets those that differ.
[[nodiscard]] std::string nrrd_length_unit(const NrrdFields& fields,
                                           const std::vector<bool>& is_spatial, std::string& note);

/// What "sample units" say, with or without quotes; empty: nothing.
[[nodiscard]] std::string nrrd_value_unit(const NrrdFields& fields);

}  // namespace lode::io
