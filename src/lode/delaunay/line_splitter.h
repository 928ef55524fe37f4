#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <type_traits>
#include <vector>

#include "lode/delaunay/triangle_error.h"

namespace lode::delaunay {

/// Splits lines of samples at the worst one, again and again, until none is farther than a
/// tolerance from the chord between the two that are kept beside it (U. Ramer, 1972; D. Douglas, T.
/// Peucker, 1973). What a line is found to err by, triangles that have its chords for edges are
/// found to err by there: of integers exactly (divided_up()); of others it is a bound that holds
/// whatever rounding does.
template <typename T>
class LineSplitter {
 public:
  /// Of heights in a range that wide.
  LineSplitter(double range, double max_error)
      : max_error_(max_error), rounding_(16 * 0x1p-53 * range + 0x1p-1040) {}

  /// Appends numbers of samples strictly between the first and the last that are to be kept, in
  /// order. Returns a bound of the errors of all others, at most the tolerance.
  double split(const T* samples, std::int32_t first, std::int32_t last,
               std::vector<std::int32_t>& kept) {
    double largest = 0;
    ends_.assign(1, last);
    while (!ends_.empty()) {
      const Worst worst = find_worst(samples, first, ends_.back());
      if (worst.error > max_error_) {
        ends_.push_back(worst.at);
        continue;
      }
      largest = largest < worst.error ? worst.error : largest;
      first = ends_.back();
      ends_.pop_back();
      if (!ends_.empty()) kept.push_back(first);
    }
    return largest;
  }

 private:
  struct Worst {
    double error = 0;
    std::int32_t at = 0;
  };
  [[nodiscard]] Worst find_worst(const T* samples, std::int32_t first, std::int32_t last) const {
    if (last - first < 2) return {};
    if constexpr (std::is_integral_v<T>) return find_in_integers(samples, first, last);
    return find_in_reals(samples, first, last);
  }
  [[nodiscard]] static Worst find_in_integers(const T* samples, std::int32_t first,
                                              std::int32_t last) {
    const std::int64_t n = last - first;
    const std::int64_t start = samples[first];
    const std::int64_t rise = samples[last] - start;
    std::int64_t worst = -1;
    std::int32_t at = first;
    for (std::int32_t i = first + 1; i < last; ++i) {
      const std::int64_t error = std::abs((samples[i] - start) * n - rise * (i - first));
      if (error <= worst) continue;
      worst = error;
      at = i;
    }
    return {divided_up(worst, n), at};
  }
  /// Seven roundings of numbers up to twice the range, but of a level chord only that of a
  /// difference.
  [[nodiscard]] Worst find_in_reals(const T* samples, std::int32_t first, std::int32_t last) const {
    const auto n = static_cast<double>(last - first);
    const auto start = static_cast<double>(samples[first]);
    const double rise = static_cast<double>(samples[last]) - start;
    double worst = -1;
    std::int32_t at = first;
    for (std::int32_t i = first + 1; i < last; ++i) {
      const double error = std::abs((static_cast<double>(samples[i]) - start) -
                                    rise * static_cast<double>(i - first) / n);
      if (error <= worst) continue;
      worst = error;
      at = i;
    }
    const double rounding = rise == 0 ? worst * 0x1p-52 : rounding_;
    return {worst + rounding, at};
  }

  double max_error_;
  double rounding_;
  std::vector<std::int32_t> ends_;
};

}  // namespace lode::delaunay
