#pragma once

#include <string>

#include "terrain_input.h"

namespace lode::cli {

/// A surface to hold against the raster of heights that it was made from, or a .lode file against
/// what it was built of.
struct TerrainVerifyJob {
  std::string input;
  std::string original;
  std::string surface;
  std::string max_error;
  TerrainArguments terrain;
  ReadingArguments reading;
};

[[nodiscard]] Result<void> check_terrain_verify(const TerrainVerifyJob& job, const CLI::App& app);
[[nodiscard]] Result<VerifyReport> verify_terrain_input(const TerrainVerifyJob& job,
                                                        Session& session);

/// The same of a folder of tiles.
[[nodiscard]] Result<void> check_tile_verify(const TerrainVerifyJob& job, const CLI::App& app);
[[nodiscard]] Result<VerifyReport> verify_tile_folder(const TerrainVerifyJob& job,
                                                      Session& session);

}  // namespace lode::cli
