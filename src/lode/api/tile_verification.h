#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "lode/api/verify_report.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/height_reader.h"

namespace lode {

/// Whether a path is a folder with a layer.json.
[[nodiscard]] bool holds_tiles(const std::string& path);

struct TileVerifyOptions {
  std::string original{};  ///< The raster that the tiles are of; empty: none.
  io::HeightReadOptions reading{};
  std::uint64_t most_bytes = std::uint64_t{512} << 20;  ///< See open_tile_raster().
  Threads threads{};
};

struct TileVerification {
  VerifyReport report;
  io::VerticalOutcome vertical{};  ///< Of the original.
};

/// Decodes all tiles that a folder's layer.json says there are, and looks whether each covers its
/// square once, without cracks; bounding spheres
/// hold vertices; each level has tiles, and each tile a parent; tiles of a level meet;
/// vertices on sides of a coarser level are on those of the finer one; and, with the original,
/// whether there are tiles of every level wherever it has samples, and all of these are within the
/// errors that layer.json states. Fails on a layer.json that is none of quantized-mesh tiles in
/// degrees, and where the original cannot be read.
[[nodiscard]] Result<TileVerification> verify_tiles(const std::string& folder,
                                                    const TileVerifyOptions& options,
                                                    Progress& progress);

}  // namespace lode
