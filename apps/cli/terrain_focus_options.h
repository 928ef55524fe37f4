#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "input.h"
#include "query_options.h"

namespace lode::cli {

/// The options of foci that only terrain has, as typed; the others are QueryArguments'.
struct TerrainFocusArguments {
  std::string point;
  std::string growth;

  [[nodiscard]] bool is_empty() const { return point.empty() && growth.empty(); }
};

void add_terrain_focus_options(CLI::App& app, TerrainFocusArguments& arguments);

/// Where the tolerance holds; nothing where it does everywhere. The metric is left to the caller.
[[nodiscard]] Result<std::optional<TerrainFocus>> to_terrain_focus(
    const QueryArguments& query, const TerrainFocusArguments& arguments);

}  // namespace lode::cli
