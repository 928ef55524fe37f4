#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/models/diamond/distance_cut.h"

namespace lode {

/// Refuses what would break the distance, or is not proven to keep it.
[[nodiscard]] Result<void> check_max_distance(const ExtractOptions& options);

/// Adds how one surface's distance was kept to report.distance, which is there.
void add_distance(const diamond::DistanceCutReport& found, ExtractReport& report);

}  // namespace lode
