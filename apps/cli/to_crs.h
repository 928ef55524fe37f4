#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "terrain_query.h"

namespace lode::cli {

/// --to-crs.
void add_to_crs(CLI::App& app, TerrainArguments& arguments, const char* help);

/// Looks at the arguments alone: refuses what is no CRS to put places in.
[[nodiscard]] Result<void> check_to_crs(const TerrainArguments& arguments);
/// Where coordinates are written: refuses --wrap with it, and GeoJSON, which has a CRS of its own.
[[nodiscard]] Result<void> check_to_crs_output(const TerrainArguments& arguments,
                                               const std::string& output);

/// Of the terrain of a file, where it is asked for.
[[nodiscard]] Result<std::optional<TargetCrs>> open_to_crs(const std::string& path,
                                                           const TerrainArguments& arguments,
                                                           const HeightFrame& frame,
                                                           Session& session);

/// The way back from it, which is asked for.
[[nodiscard]] Result<SourceCrs> open_from_crs(const std::string& path,
                                              const TerrainArguments& arguments,
                                              const HeightFrame& frame);

/// A mesh in another CRS, and how far samples are from it there.
struct MappedAnswer {
  TargetCrs target;
  MappedErrors errors;
  MeasuredAt measured_at = MeasuredAt::samples;
  double seconds = 0;
};

/// Null where there is none. `tolerance`: that is to hold everywhere, if there is one.
[[nodiscard]] Json mapped_json(const std::optional<MappedAnswer>& mapped,
                               const std::optional<double>& tolerance);
void add_mapped_rows(const MappedAnswer& mapped, Table& table);
/// Says where errors are larger than in the CRS of the file, and what is not known of them.
void warn_of_mapped(const MappedAnswer& mapped, const TerrainReport& report, Session& session);

/// Of what is written: of the target, where there is one, or of the file.
[[nodiscard]] const std::string& written_crs(const OpenedTerrain& opened,
                                             const std::optional<TargetCrs>& target);

/// Puts lines in the target, where there is one, and says so. Fails as map_lines() does, naming
/// the file.
[[nodiscard]] Result<void> map_to_crs(const std::string& path,
                                      const std::optional<TargetCrs>& target,
                                      std::vector<std::span<Place>>& lines, Session& session,
                                      Json& json, Table& table);

/// Round a surface in another CRS, whose places are the corners of a lattice.
[[nodiscard]] HeightFrame frame_round(const TerrainSurface& terrain, const HeightFrame& own,
                                      const std::string& crs);

}  // namespace lode::cli
