#pragma once

#include <optional>
#include <string>

#include "command.h"
#include "lode/api/terrain.h"
#include "text.h"

namespace lode::cli {

/// Of --clip with terrain; empty: none.
[[nodiscard]] Result<std::optional<PlaceBox>> to_terrain_clip(const std::string& clip,
                                                              const std::string& output);

/// null where there is none.
[[nodiscard]] Json clip_json(const std::optional<TerrainClip>& clip);
void add_clip_row(const std::optional<TerrainClip>& clip, Table& table);

}  // namespace lode::cli
