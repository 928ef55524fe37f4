#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include "lode/core/result.h"
#include "lode/models/terrain/tile_pyramid/build.h"

namespace lode {

/// A folder of quantized-mesh tiles, Z/X/Y.terrain, with its layer.json.
class TileFolder {
 public:
  explicit TileFolder(std::string folder) : folder_(std::move(folder)) {}

  /// From any thread. Fails, naming the file, where it cannot be written.
  [[nodiscard]] Result<void> add(const tile_pyramid::FinishedTile& tile);
  /// Of the tiles added; `bounds`: of the raster.
  [[nodiscard]] Result<void> write_layer(std::span<const tile_pyramid::LevelReport> levels,
                                         const tile_pyramid::DegreeBox& bounds) const;
  /// Of the tiles added of a level.
  [[nodiscard]] std::uint64_t n_bytes(int level) const {
    return n_bytes_[static_cast<std::size_t>(level)];
  }

 private:
  std::string folder_;
  std::array<std::atomic<std::uint64_t>, tile_pyramid::kMaxLevel + 1> n_bytes_{};
};

}  // namespace lode
