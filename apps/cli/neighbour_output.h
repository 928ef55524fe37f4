#pragma once

#include <string>
#include <vector>

#include "terrain_query.h"

namespace lode {
struct TerrainNeighbours;
struct TerrainTriangle;
}  // namespace lode

namespace lode::cli {

/// What lies beside each edge of a triangle, "7:2" for edge 2 of triangle 7, several with blanks
/// between them, and "none" where the domain ends. Edges are counted from 1.
[[nodiscard]] std::array<std::string, 3> describe_beside(const TerrainTriangle& triangle);

/// Writes the triangles of places, in their order: .csv a row for each, and for each place that
/// has none; .gpkg and .geojson as polygons. Fails when cancelled.
[[nodiscard]] Result<void> write_neighbours(const std::string& path,
                                            const TerrainAnswerer& answerer,
                                            const std::vector<Place>& places,
                                            const std::vector<TerrainNeighbours>& answers,
                                            Progress& progress);

}  // namespace lode::cli
