#pragma once

#include <cstdint>

#include "lode/api/dataset.h"

namespace lode::cli {

struct SampleRange {
  double lower = 0;  ///< Of the samples that are no holes; both 0 when there are none.
  double upper = 0;
  std::uint64_t n_holes = 0;  ///< Non-finite samples and those equal to nodata.
};

/// Reads every sample once, a few slices at a time.
[[nodiscard]] Result<SampleRange> find_sample_range(VolumeSource& source, Progress& progress);

}  // namespace lode::cli
