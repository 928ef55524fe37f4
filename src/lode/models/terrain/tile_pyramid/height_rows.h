#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "lode/core/height_frame.h"
#include "lode/core/result.h"

namespace lode::tile_pyramid {

/// Metres: farther from the ellipsoid there is no terrain, but numbers that stand for missing
/// samples, which nobody declared.
inline constexpr double kMostHeight = 1e7;

/// A raster of heights that is read in rows, as often as need be; it may be larger than memory.
class HeightRows {
 public:
  virtual ~HeightRows() = default;
  [[nodiscard]] virtual const HeightFrame& frame() const = 0;
  /// What errors call it.
  [[nodiscard]] virtual std::string name() const { return "raster"; }
  /// Fills `out` with n_rows whole rows from `first` on; NaN where a sample is missing. One call at
  /// a time.
  [[nodiscard]] virtual Result<void> read(std::int32_t first, std::int32_t n_rows,
                                          std::span<double> out) = 0;
};

}  // namespace lode::tile_pyramid
