#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lode/api/mapped_errors.h"
#include "lode/api/terrain.h"
#include "lode/core/place_map.h"

namespace lode {

/// What errors in another CRS are measured at. kept_vertices: those of the finest mesh that a file
/// keeps, where not all samples are at hand.
enum class MeasuredAt : std::uint8_t { samples, kept_vertices };

struct TerrainMapOptions {
  const PlaceMap& map;
  std::string name;  ///< Of the other CRS, for messages.
  std::optional<PlaceBox> clip{};
  /// In the CRS of the terrain; nothing: vertices of its finest mesh.
  std::optional<MeasuredSamples> samples{};
};

struct MappedTerrain {
  TerrainSurface terrain;  ///< With places, always: floats would move them.
  MappedErrors errors;
  MeasuredAt measured_at = MeasuredAt::samples;
  double seconds = 0;  ///< Of mapping and measuring.
};

/// The TIN that extract_terrain() makes, with its vertices in another CRS: the triangles are the
/// same, but a sample lies elsewhere in them, so that errors are measured again. Its report says
/// errors in the CRS of the terrain. Fails as extract_terrain() and measure_mapped() do, where a
/// vertex has no place in the other CRS, and where a triangle turns over there, or gets flat.
[[nodiscard]] Result<MappedTerrain> extract_mapped_terrain(const Terrain& terrain,
                                                           const TerrainOptions& options,
                                                           const TerrainMapOptions& mapping,
                                                           Progress& progress);

}  // namespace lode
