#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/quantized_mesh.h"
#include "lode/models/terrain/tile_pyramid/tile_scheme.h"

namespace lode {

/// What a layer.json says.
struct TileLayer {
  struct Level {
    std::vector<tile_pyramid::TileRange> ranges;  ///< Columns are called what they are.
    std::optional<double> error{};  ///< That no sample is beyond; not all files state it.
  };
  std::vector<Level> levels;
};

/// Fails, naming the file, on what is no layer.json of quantized-mesh tiles in degrees, and on
/// levels and tiles that there cannot be.
[[nodiscard]] Result<TileLayer> read_layer(const std::string& folder);

/// Z/X/Y.terrain of such a folder. Fails, naming the file, where it is not there or damaged.
[[nodiscard]] Result<io::QuantizedMesh> read_tile(const std::string& folder,
                                                  const tile_pyramid::TileId& tile);

}  // namespace lode
