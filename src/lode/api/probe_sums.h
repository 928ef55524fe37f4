#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "lode/api/probe.h"

/// What integrals over cells add up, with what rounding may have put sums off by.
namespace lode::probe_sums {

inline constexpr double kEndless = std::numeric_limits<double>::infinity();

/// A sum of doubles as exact as if it were rounded about once (Neumaier 1974).
class CompensatedSum {
 public:
  void add(double x) {
    const double sum = sum_ + x;
    rest_ += std::abs(sum_) >= std::abs(x) ? (sum_ - sum) + x : (x - sum) + sum_;
    sum_ = sum;
    size_ += std::abs(x);
  }
  void add(const CompensatedSum& other) {
    add(other.sum_);
    rest_ += other.rest_;
    size_ += other.size_;
  }
  [[nodiscard]] double value() const { return sum_ + rest_; }
  /// A bound of what value() is off by, of sums of up to 2^22 sums.
  [[nodiscard]] double rounding() const { return 0x1p-51 * std::abs(value()) + 0x1p-60 * size_; }

 private:
  double sum_ = 0;
  double rest_ = 0;
  double size_ = 0;  ///< Of all terms without their signs, about.
};

/// Numbers between two sums, each the term's other end.
struct SumOfBounds {
  CompensatedSum low;
  CompensatedSum high;

  void add(double below, double above) {
    low.add(below);
    high.add(above);
  }
  void add(const SumOfBounds& other) {
    low.add(other.low);
    high.add(other.high);
  }
  [[nodiscard]] BoundedNumber around(double value) const {
    return {value, low.value() - low.rounding(), high.value() + high.rounding()};
  }
};

/// Of an extreme: what is below, and above, what F has.
struct Extremes {
  double of_cut_low = kEndless;
  double of_cut_high = -kEndless;
  double lowest = kEndless;         ///< F is nowhere below;
  double highest = -kEndless;       ///< nor above.
  double reached_low = kEndless;    ///< F is somewhere as low,
  double reached_high = -kEndless;  ///< and as high.

  void add(const Extremes& other) {
    of_cut_low = std::min(of_cut_low, other.of_cut_low);
    of_cut_high = std::max(of_cut_high, other.of_cut_high);
    lowest = std::min(lowest, other.lowest);
    highest = std::max(highest, other.highest);
    reached_low = std::min(reached_low, other.reached_low);
    reached_high = std::max(reached_high, other.reached_high);
  }
};

/// Of some of the cells.
struct PartialIntegral {
  CompensatedSum volume;
  CompensatedSum integral;
  CompensatedSum estimate;
  double volume_rounding = 0;
  double integral_rounding = 0;
  SumOfBounds volume_bounds;
  SumOfBounds integral_bounds;
  Extremes extremes;
  std::uint64_t n_cells = 0;
  std::uint64_t n_whole = 0;

  void add(const PartialIntegral& other) {
    volume.add(other.volume);
    integral.add(other.integral);
    estimate.add(other.estimate);
    volume_rounding += other.volume_rounding;
    integral_rounding += other.integral_rounding;
    volume_bounds.add(other.volume_bounds);
    integral_bounds.add(other.integral_bounds);
    extremes.add(other.extremes);
    n_cells += other.n_cells;
    n_whole += other.n_whole;
  }
};

}  // namespace lode::probe_sums
