#pragma once

#include <string>

#include "lode/api/opened_terrain.h"
#include "lode/api/terrain.h"
#include "lode/core/place_map.h"
#include "lode/core/placed_surface.h"

namespace lode {

/// A CRS that a surface is in, and the ways between it and that of the terrain.
struct OtherCrs {
  const PlaceMap& there;  ///< From the terrain's.
  const PlaceMap& back;
  std::string name;
};

/// As verify_terrain(), of a surface that extract_mapped_terrain() made: its vertices have to be
/// where the other CRS has samples, within what rounding explains, and with these in their own
/// CRS all is checked that is of a surface there. Then errors are measured in the other CRS, at all
/// samples, as measure_mapped() does; how large they are is said, and fails nothing. Of a raster
/// or points whose samples are at hand.
[[nodiscard]] Result<VerifyReport> verify_mapped_terrain(const OpenedTerrain& opened,
                                                         const PlacedSurface& placed,
                                                         const TerrainVerifyOptions& options,
                                                         const OtherCrs& other, Progress& progress);

}  // namespace lode
