#pragma once

#include <cstdint>
#include <string>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/io/height_reader.h"

namespace lode::io {

/// How far a file's own samples are, vertically, from what was resampled of them, in units of the
/// heights.
struct ResamplingError {
  std::uint64_t n_measured = 0;
  std::uint64_t n_outside =
      0;  ///< Of the file's samples, with a height, that are in no cell of it.
  double largest = 0;
  double rms = 0;
};

/// Of a raster read with options.to_degrees, which is read once as it is and once resampled: at
/// each sample of the file against the bilinear patch between the four samples round its place.
/// Fails as reading does, and on cancel.
[[nodiscard]] Result<ResamplingError> measure_resampling(const std::string& path,
                                                         const HeightReadOptions& options,
                                                         Threads threads, Progress& progress);

}  // namespace lode::io
