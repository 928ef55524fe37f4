#pragma once

#include <span>
#include <vector>

#include "lode/models/terrain/tile_pyramid/border_chain.h"
#include "lode/models/terrain/tile_pyramid/border_lines.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode::tile_pyramid {

/// By level: tolerances, gaps as most_gap() has them, and the largest steps of heights that are at
/// most an eighth of them; but no less than what fits the heights of each tile into kLastNode
/// steps, and all heights into what float32 has exactly, and than a millionth of a millimetre.
/// Heights, and the fill, are at most kMostHeight.
[[nodiscard]] std::vector<LevelForm> level_forms(const BorderLines& lines,
                                                 std::span<const TileRange> ranges, double fill,
                                                 double max_error);

}  // namespace lode::tile_pyramid
