#pragma once

#include "lode/models/terrain/triangle_hierarchy/fine_grid.h"

namespace lode::triangle_hierarchy {

/// ReferenceSurface::worst_crossing() of a raster: the profile is read where the edge crosses
/// columns and rows, linear between the two samples there; a crossing moves along its column or
/// row. Of equal errors the first counts, along columns and then rows, from the end that is first
/// in rows. O(crossings).
[[nodiscard]] EdgeSplit worst_crossing(const FineGrid& grid, Place a, Place b,
                                       Crossings crossings = Crossings::all);

}  // namespace lode::triangle_hierarchy
