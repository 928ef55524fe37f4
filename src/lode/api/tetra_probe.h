#pragma once

#include <span>
#include <vector>

#include "lode/api/probe.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"

namespace lode {

// TetraDataset's, of its hierarchy.

[[nodiscard]] Result<ProbeReport> probe_hierarchy(const tetra_mt::PackedHierarchy& hierarchy,
                                                  std::span<const Vec3d> points,
                                                  const ProbeOptions& options,
                                                  std::vector<ProbedPoint>& found,
                                                  Progress& progress);
[[nodiscard]] Result<ProbeReport> probe_hierarchy(const tetra_mt::PackedHierarchy& hierarchy,
                                                  const ProbedLine& line,
                                                  const ProbeOptions& options,
                                                  std::vector<ProbedLinePoint>& found,
                                                  Progress& progress);
[[nodiscard]] Result<IntegralReport> integrate_hierarchy(const tetra_mt::PackedHierarchy& hierarchy,
                                                         const IntegralOptions& options,
                                                         Progress& progress);

}  // namespace lode
