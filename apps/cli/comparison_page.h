#pragma once

#include <string>

#include "lode/api/terrain_comparison.h"
#include "text.h"

namespace lode::cli {

/// What a comparison is of.
struct ComparedRaster {
  std::string path;
  std::string size;  ///< "4320 x 2161, int16"
  std::string unit;  ///< Of heights; empty: not known.
  std::string machine;
  bool is_in_angles = false;  ///< Columns and rows are of longitudes and latitudes.
};

/// All that was measured.
[[nodiscard]] Json comparison_json(const TerrainComparison& comparison);

/// One page without anything outside it: tables, and plots as SVG. `json`: kept in it.
[[nodiscard]] std::string comparison_page(const TerrainComparison& comparison,
                                          const ComparedRaster& raster, const Json& json);

}  // namespace lode::cli
