#pragma once

#include <optional>
#include <string>

#include "extract_terrain.h"
#include "to_crs.h"

namespace lode::cli {

/// A terrain, the TIN of it, and how long things took.
struct TerrainAnswer {
  const TerrainJob& job;
  const OpenedTerrain& opened;
  const TerrainOptions& options;
  const TerrainReport& report;
  InsertionOrder order;
  double read_seconds;
  double write_seconds;
  std::optional<TerrainRasterReport> raster{};
  std::optional<TerrainClip> clip{};
  std::optional<MappedAnswer> mapped{};
};

/// What is reported of it, in JSON and in a table.
[[nodiscard]] Json answer_json(const TerrainAnswer& answer, Table& table, const Session& session);
void add_rows(const TerrainAnswer& answer, Table& table);

/// What a mesh is, and how accurate.
[[nodiscard]] std::string summary_of(const TerrainReport& report, const OpenedTerrain& opened,
                                     InsertionOrder order);
/// Of surfaces, whose files have no other place for a CRS.
[[nodiscard]] std::string comment_of(const TerrainReport& report, const OpenedTerrain& opened,
                                     InsertionOrder order,
                                     const std::optional<MappedAnswer>& mapped);

/// What may surprise whoever asked.
void warn_of(const TerrainReport& report, const OpenedTerrain& opened, const TerrainJob& job,
             const std::optional<TerrainFocus>& focus, const std::optional<TerrainClip>& clip,
             Session& session);

}  // namespace lode::cli
