#pragma once

#include "lode/api/terrain.h"
#include "lode/models/terrain/delaunay_selector/selector.h"

namespace lode {

/// A TIN of a grid, and what is to be said of it but for slacks of coordinates.
struct SelectedTerrain {
  delaunay_selector::Selection selection;
  TerrainReport report;
};

/// With the tolerance and order that the options mean; with links at tolerance 0: of all samples.
/// Fails as select_samples() does.
[[nodiscard]] Result<SelectedTerrain> select_terrain(const HeightGrid& grid,
                                                     const TerrainOptions& options,
                                                     delaunay::TinLinks links, Progress& progress);

}  // namespace lode
