#pragma once

#include <optional>
#include <string>
#include <vector>

#include "terrain_query.h"

namespace lode::cli {

/// --places-crs. `which`: of what places.
void add_places_crs(CLI::App& app, std::string& places_crs, const char* which);
/// Looks at the argument alone.
[[nodiscard]] Result<void> check_places_crs(const std::string& places_crs);

/// Into the CRS of a terrain, where another one is named; warns where datums are taken for one.
[[nodiscard]] Result<std::optional<SourceCrs>> open_places_crs(const std::string& places_crs,
                                                               const std::string& input,
                                                               const HeightFrame& frame,
                                                               Session& session);

/// Places of the terrain's CRS. Fails where it has no such place; `names` say of which.
[[nodiscard]] Result<std::vector<Place>> places_of_terrain(
    const std::vector<Place>& given, const std::optional<SourceCrs>& source,
    const std::vector<std::string>& names = {});

/// The ends of a way.
struct TerrainWay {
  Place from;
  Place to;
};
/// In the terrain's CRS: where it goes round the earth without a gap, on the shorter way, else as
/// many whole turns on or back as bring its middle near to the terrain. Fails as above.
[[nodiscard]] Result<TerrainWay> way_on(const OpenedTerrain& opened, const HorizontalMetric& metric,
                                        const std::optional<SourceCrs>& source,
                                        const TerrainWay& given);

}  // namespace lode::cli
