#include "lode/models/terrain/right_triangle_bisection/whole_heights.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <type_traits>
#include <vector>

#include "lode/models/terrain/right_triangle_bisection/height_lanes.h"

namespace lode::bisection {
namespace {

/// Added and taken away again, it leaves the nearest whole number.
constexpr double kWhole = 0x1.8p52;
constexpr double kNearly = 0x1p-49;

/// How many a unit, and whether those numbers are held exactly; coarse ones first.
struct Steps {
  double per_unit;
  bool is_exact;
};
constexpr std::array<Steps, 4> kSteps{{{1, true}, {10, false}, {100, false}, {256, true}}};

}  // namespace

template <typename T>
std::optional<WholeHeights> find_whole_heights(const RasterRows<T>& rows, LatticePoint last,
                                               const HeightRange& range, Threads threads) {
  const double largest = std::max(std::abs(range.lower), std::abs(range.upper));
  const std::int32_t n = last.x + 1;
  const HeightLanes lanes = height_lanes();
  WholeHeights whole;
  whole.stride = padded_stride(n);
  for (const Steps& steps : kSteps) {
    if (!(largest * steps.per_unit < 0x1p31) ||
        (range.upper - range.lower) * steps.per_unit > 65534)
      break;
    if (std::is_same_v<T, float> && !steps.is_exact) continue;  // Its own rounding is larger.
    const double lowest = (range.lower * steps.per_unit + kWhole) - kWhole;
    const double slack = steps.is_exact ? 0 : kNearly * largest * steps.per_unit;
    const auto put = [&](std::int32_t y, std::uint16_t* out) {
      return lanes.count_steps(rows.row(y), n, {steps.per_unit, lowest, slack}, out);
    };
    std::vector<std::uint16_t> first(static_cast<std::size_t>(n));
    if (!put(last.y / 2, first.data())) continue;
    whole.samples.resize(
        static_cast<std::size_t>(whole.stride * (std::int64_t{last.y} + 1) + HeightGrid::kPadding));
    std::atomic<bool> has_others = false;
    parallel_for(static_cast<std::size_t>(last.y) + 1, threads, 64, [&](std::size_t row, int) {
      const auto y = static_cast<std::int32_t>(row);
      if (!put(y, whole.samples.data() + y * whole.stride)) has_others = true;
    });
    if (has_others) continue;
    whole.per_unit = steps.per_unit;
    whole.is_exact = steps.is_exact;
    whole.largest = (range.upper * steps.per_unit + kWhole) - kWhole - lowest;
    return whole;
  }
  return std::nullopt;
}

template std::optional<WholeHeights> find_whole_heights<float>(const RasterRows<float>&,
                                                               LatticePoint, const HeightRange&,
                                                               Threads);
template std::optional<WholeHeights> find_whole_heights<double>(const RasterRows<double>&,
                                                                LatticePoint, const HeightRange&,
                                                                Threads);

}  // namespace lode::bisection
