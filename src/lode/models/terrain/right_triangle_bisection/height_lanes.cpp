// Included again by Highway for each instruction set.
#include "lode/models/terrain/right_triangle_bisection/height_lanes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "lode/delaunay/triangle_error.h"

#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/terrain/right_triangle_bisection/height_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::bisection::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Added and taken away again, it leaves the nearest whole number.
constexpr double kWhole = 0x1.8p52;

template <typename T>
HeightRange range_of(const T* row, std::int32_t n) {
  const hn::ScalableTag<T> d;
  const auto step = static_cast<std::int32_t>(hn::Lanes(d));
  T lower = row[0];
  T upper = row[0];
  std::int32_t x = 0;
  if (n >= step) {
    auto low = hn::LoadU(d, row);
    auto high = low;
    for (x = step; x + step <= n; x += step) {
      const auto z = hn::LoadU(d, row + x);
      low = hn::Min(low, z);
      high = hn::Max(high, z);
    }
    lower = hn::GetLane(hn::MinOfLanes(d, low));
    upper = hn::GetLane(hn::MaxOfLanes(d, high));
  }
  for (; x < n; ++x) {
    lower = std::min(lower, row[x]);
    upper = std::max(upper, row[x]);
  }
  return {static_cast<double>(lower), static_cast<double>(upper)};
}
HeightRange range_of_doubles(const double* row, std::int32_t n) { return range_of(row, n); }
HeightRange range_of_floats(const float* row, std::int32_t n) { return range_of(row, n); }

HWY_INLINE hn::Vec<hn::ScalableTag<double>> heights_at(const double* row) {
  return hn::LoadU(hn::ScalableTag<double>(), row);
}
HWY_INLINE hn::Vec<hn::ScalableTag<double>> heights_at(const float* row) {
  const hn::ScalableTag<double> d;
  return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, decltype(d)>(), row));
}

/// Of one height, as the lanes do it.
template <typename T>
bool count_one(T height, const HeightLanes::Steps& steps, std::uint16_t& out) {
  const double exact = static_cast<double>(height) * steps.per_unit;
  const double whole = (exact + kWhole) - kWhole;
  out = static_cast<std::uint16_t>(static_cast<std::int32_t>(whole - steps.lowest));
  return !(std::abs(exact - whole) > steps.slack);
}

template <typename T>
bool count_steps_of(const T* row, std::int32_t n, const HeightLanes::Steps& steps,
                    std::uint16_t* out) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<std::int32_t, decltype(d)> as_int;
  const hn::Rebind<std::uint16_t, decltype(d)> as_word;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  const auto per_unit = hn::Set(d, steps.per_unit);
  const auto magic = hn::Set(d, kWhole);
  const auto lowest = hn::Set(d, steps.lowest);
  auto farthest = hn::Zero(d);
  std::int32_t x = 0;
  for (; x + lanes <= n; x += lanes) {
    const auto exact = hn::Mul(heights_at(row + x), per_unit);
    const auto whole = hn::Sub(hn::Add(exact, magic), magic);
    farthest = hn::Max(farthest, hn::Abs(hn::Sub(exact, whole)));
    // Where these are no numbers of 16 bits they are not asked for.
    hn::StoreU(hn::DemoteTo(as_word, hn::DemoteTo(as_int, hn::Sub(whole, lowest))), as_word,
               out + x);
  }
  bool are_whole = hn::GetLane(hn::MaxOfLanes(d, farthest)) <= steps.slack;
  for (; x < n; ++x) are_whole = count_one(row[x], steps, out[x]) && are_whole;
  return are_whole;
}
bool count_steps_of_doubles(const double* row, std::int32_t n, const HeightLanes::Steps& steps,
                            std::uint16_t* out) {
  return count_steps_of(row, n, steps, out);
}
bool count_steps_of_floats(const float* row, std::int32_t n, const HeightLanes::Steps& steps,
                           std::uint16_t* out) {
  return count_steps_of(row, n, steps, out);
}

void to_units(float* errors, std::int32_t n, double unit, double slack, std::uint64_t* zeros) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<float, decltype(d)> of_float;
  const hn::Rebind<std::uint32_t, decltype(d)> of_bits;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  const auto scale = hn::Set(d, unit);
  const auto added = hn::Set(d, slack);
  std::fill_n(zeros, (n + 63) / 64, std::uint64_t{0});
  std::int32_t x = 0;
  for (; x + lanes <= n; x += lanes) {
    const auto error = hn::LoadU(of_float, errors + x);
    const auto is_zero = hn::Eq(error, hn::Zero(of_float));
    if (HWY_UNLIKELY(!hn::AllFalse(of_float, is_zero)))
      for (std::int32_t i = 0; i < lanes; ++i)
        if (errors[x + i] == 0)
          zeros[static_cast<std::size_t>(x + i) / 64] |= std::uint64_t{1} << ((x + i) % 64);
    const auto exact = hn::Add(hn::Mul(hn::PromoteTo(d, error), scale), added);
    const auto nearest = hn::DemoteTo(of_float, exact);
    // One more where that was rounded down: numbers >= 0 follow each other as their bits do.
    const auto lost = hn::DemoteTo(of_float, hn::Sub(exact, hn::PromoteTo(d, nearest)));
    const auto is_below = hn::RebindMask(of_bits, hn::Gt(lost, hn::Zero(of_float)));
    const auto up = hn::IfThenElseZero(is_below, hn::Set(of_bits, 1U));
    hn::StoreU(hn::BitCast(of_float, hn::Add(hn::BitCast(of_bits, nearest), up)), of_float,
               errors + x);
  }
  for (; x < n; ++x) {
    if (errors[x] == 0) zeros[static_cast<std::size_t>(x) / 64] |= std::uint64_t{1} << (x % 64);
    errors[x] = delaunay::to_float_above(static_cast<double>(errors[x]) * unit + slack);
  }
}

HeightLanes lanes_of_this() {
  return {.range_of_doubles = &range_of_doubles,
          .range_of_floats = &range_of_floats,
          .count_steps_of_doubles = &count_steps_of_doubles,
          .count_steps_of_floats = &count_steps_of_floats,
          .to_units = &to_units};
}

}  // namespace lode::bisection::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::bisection {

HWY_EXPORT(lanes_of_this);

HeightLanes height_lanes() { return HWY_DYNAMIC_DISPATCH(lanes_of_this)(); }

}  // namespace lode::bisection
#endif
