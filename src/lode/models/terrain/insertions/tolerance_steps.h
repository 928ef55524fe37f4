#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/terrain/insertions/history.h"

namespace lode::insertions {

/// The first time when no triangle errs by more, and the mesh then.
struct ToleranceStep {
  float error = 0;
  std::uint32_t time = 0;
  std::uint32_t n_triangles = 0;
  float largest = 0;  ///< The largest error of its triangles.
};

/// Of a history that is worst first one for each time that time_within() has, for its errors are
/// few floats; ascending by time, and strictly falling by error. The last is after all nodes; of
/// other histories the only one.
[[nodiscard]] std::vector<ToleranceStep> find_tolerance_steps(const History& history);

/// At the time that time_within() has.
[[nodiscard]] const ToleranceStep& step_within(std::span<const ToleranceStep> steps,
                                               double tolerance);

}  // namespace lode::insertions
