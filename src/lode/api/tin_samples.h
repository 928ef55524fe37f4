#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include "lode/core/height_grid.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/io/raster_file.h"
#include "lode/mappers/tin_raster.h"

namespace lode {

/// The lowest float32: no height, as those beyond 1e30 are refused.
inline constexpr double kLowestFloat = -3.4028234663852886e+38;

/// What storing the heights of a TIN in a type makes of them.
struct TinSampleFacts {
  std::uint64_t n_heights = 0;
  double error = 0;          ///< The largest |z - z'|; where there are samples.
  double rounding = 0;       ///< From the planes, as far as floats tell these.
  bool meets_value = false;  ///< Whether a height equals the value that was looked for.
};

/// The heights of a TIN at the samples of its raster as numbers of a type: the nearest ones, or,
/// where these would be farther than `limit` from the sample, those beside them that are not.
class StoredHeights {
 public:
  /// All must outlive it. `samples`: null where they are not at hand; `limit`: the TIN's error.
  StoredHeights(const TinRaster& tin, const HeightGrid* samples, double limit)
      : tin_(tin), samples_(samples), limit_(limit) {}

  /// Fills a strip: NaN where there is no height.
  void fill(std::int32_t strip, io::RasterType type, std::span<double> heights) const;
  /// The same less the samples, in the type and not beyond the limit; of what fill() gave.
  void subtract_samples(std::int32_t strip, io::RasterType type, std::span<const double> heights,
                        std::span<double> differences) const;

  /// Goes through all strips. Fails when cancelled.
  [[nodiscard]] Result<TinSampleFacts> measure(io::RasterType type, double looked_for,
                                               Threads threads, Progress& progress) const;

 private:
  [[nodiscard]] TinSampleFacts store(std::int32_t strip, io::RasterType type, double looked_for,
                                     std::span<double> heights) const;
  [[nodiscard]] double stored(io::RasterType type, double z, double sample) const;

  const TinRaster& tin_;
  const HeightGrid* samples_;
  double limit_;
};

}  // namespace lode
