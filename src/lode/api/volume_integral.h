#pragma once

#include "lode/api/dataset_impl.h"
#include "lode/api/probe.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode {

/// About how many unit cells a volume has in a box, or in all.
[[nodiscard]] std::uint64_t n_unit_cells(const Dataset::Impl& impl,
                                         const std::optional<Box3d>& box);

/// The integral of F over a volume at full resolution, or over what is of it in a box, cut exactly:
/// from its samples, box by box, whether they are in memory or in a file. Unit cells that touch a
/// hole are left out. Whatever tolerance there is, it is exact but for rounding. The same for any
/// number of threads. O(unit cells in the box).
[[nodiscard]] Result<IntegralReport> integrate_samples(const Dataset::Impl& impl,
                                                       const IntegralOptions& options,
                                                       Progress& progress);

}  // namespace lode
