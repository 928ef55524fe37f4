#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"

namespace lode::bisection {

/// Passes over rows that do little with each sample, in vectors as wide as this processor has: the
/// same results with any.
struct HeightLanes {
  /// Of n > 0 finite heights.
  HeightRange (*range_of_doubles)(const double* row, std::int32_t n);
  HeightRange (*range_of_floats)(const float* row, std::int32_t n);

  /// What turns heights into whole numbers of steps.
  struct Steps {
    double per_unit = 1;
    double lowest = 0;  ///< Number of the lowest height: others are counted from there.
    double slack = 0;   ///< How far a height may be from its number, in steps.
  };
  /// Numbers of steps of n heights; whether all are such numbers of up to 16 bits.
  bool (*count_steps_of_doubles)(const double* row, std::int32_t n, const Steps& steps,
                                 std::uint16_t* out);
  bool (*count_steps_of_floats)(const float* row, std::int32_t n, const Steps& steps,
                                std::uint16_t* out);

  /// Turns n errors >= 0 in steps into units * error + slack, rounded up; bit i of `zeros` (of a
  /// word for each 64 errors): the i-th was 0.
  void (*to_units)(float* errors, std::int32_t n, double unit, double slack, std::uint64_t* zeros);

  [[nodiscard]] HeightRange range(const double* row, std::int32_t n) const {
    return range_of_doubles(row, n);
  }
  [[nodiscard]] HeightRange range(const float* row, std::int32_t n) const {
    return range_of_floats(row, n);
  }
  [[nodiscard]] bool count_steps(const double* row, std::int32_t n, const Steps& steps,
                                 std::uint16_t* out) const {
    return count_steps_of_doubles(row, n, steps, out);
  }
  [[nodiscard]] bool count_steps(const float* row, std::int32_t n, const Steps& steps,
                                 std::uint16_t* out) const {
    return count_steps_of_floats(row, n, steps, out);
  }
};

/// Those for this processor.
[[nodiscard]] HeightLanes height_lanes();

}  // namespace lode::bisection
