#pragma once

#include <span>
#include <variant>
#include <vector>

#include "lode/api/probe.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode {

// TetraDataset's, of its hierarchy.

using ProbedHierarchy =
    std::variant<const tetra_mt::PackedHierarchy*, const tetra_mt::midpoint::Forest*>;

[[nodiscard]] Result<ProbeReport> probe_hierarchy(const ProbedHierarchy& hierarchy,
                                                  std::span<const Vec3d> points,
                                                  const ProbeOptions& options,
                                                  std::vector<ProbedPoint>& found,
                                                  Progress& progress);
[[nodiscard]] Result<ProbeReport> probe_hierarchy(const ProbedHierarchy& hierarchy,
                                                  const ProbedLine& line,
                                                  const ProbeOptions& options,
                                                  std::vector<ProbedLinePoint>& found,
                                                  Progress& progress);
[[nodiscard]] Result<IntegralReport> integrate_hierarchy(const ProbedHierarchy& hierarchy,
                                                         const IntegralOptions& options,
                                                         Progress& progress);

}  // namespace lode
