#pragma once

#include <string>

#include "lode/api/files.h"
#include "lode/api/opened_terrain.h"

namespace lode::cli {

/// Whether lines become VTK PolyData: .vtp.
[[nodiscard]] bool is_vtp_path(const std::string& path);

/// Refuses what is neither .gpkg, .geojson nor .vtp.
[[nodiscard]] Result<void> check_line_output(const std::string& path);

/// Refuses terrain without a CRS for GeoJSON.
[[nodiscard]] Result<void> check_known_crs(const std::string& output, const std::string& input,
                                           const TerrainFacts& facts);

/// Calls add(i) for each of n features, says how far it is, and commits. Fails when cancelled.
template <typename Add>
Result<void> write_each(VectorWriter& writer, std::size_t n, Progress& progress, const Add& add) {
  constexpr std::size_t kPerReport = 256;
  for (std::size_t i = 0; i < n; ++i) {
    if (i % kPerReport == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("writing", static_cast<double>(i) / static_cast<double>(n));
    }
    LODE_CHECK(add(i));
  }
  return writer.commit(progress);
}

}  // namespace lode::cli
