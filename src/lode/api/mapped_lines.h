#pragma once

#include <span>
#include <string>
#include <vector>

#include "lode/core/place_map.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// Puts the vertices of lines, or of rings, into another CRS, where their pieces are straight
/// again. Returns how far the middle of a piece, mapped, is from that of its chord at most, in
/// units of the other CRS. Fails where a vertex or middle has no place there, where a piece
/// bends by more than a quarter of its length, as those do that cross a seam, and when
/// cancelled. `name`: of the other CRS, for messages.
[[nodiscard]] Result<double> map_lines(std::span<const std::span<Vec<double, 2>>> lines,
                                       const PlaceMap& map, const std::string& name,
                                       Progress& progress);

}  // namespace lode
