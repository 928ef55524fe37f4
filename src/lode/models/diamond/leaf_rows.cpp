#include "lode/models/diamond/leaf_rows.h"

// Each target is another copy of this file to compile: the baseline and AVX2 will do.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/leaf_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <limits>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Tag of the vectors used for C: no longer than the padding of a row.
template <typename C>
using RowTag = hn::CappedTag<C, kRowPadding>;

template <typename Tag, typename V>
V mean_of(Tag d, V a, V b) {
  if constexpr (std::is_floating_point_v<hn::TFromD<Tag>>)
    return hn::Mul(hn::Add(a, b), hn::Set(d, hn::TFromD<Tag>(0.5)));
  else
    return hn::AverageRound(a, b);
}

/// |a - b|; 0 where one is NaN.
template <typename Tag, typename V>
V difference(Tag d, V a, V b) {
  if constexpr (std::is_floating_point_v<hn::TFromD<Tag>>) {
    const auto e = hn::Abs(hn::Sub(a, b));
    return hn::IfThenElseZero(hn::Ge(e, hn::Zero(d)), e);
  } else {
    return hn::Sub(hn::Max(a, b), hn::Min(a, b));
  }
}

template <typename C>
void midpoint_errors(const C* v, std::ptrdiff_t across, std::size_t n, C* error) {
  const RowTag<C> d;
  const hn::RebindToUnsigned<RowTag<C>> du;
  using U = hn::TFromD<decltype(du)>;
  const C* to_first = v + across;
  const C* to_second = v - across;
  for (std::size_t x = 0; x < n; x += hn::Lanes(d)) {
    const auto number = hn::And(hn::Iota(du, static_cast<U>(x)), hn::Set(du, U{3}));
    const auto is_first = hn::RebindMask(d, hn::Eq(number, hn::Set(du, U{1})));
    const auto is_second = hn::RebindMask(d, hn::Eq(number, hn::Set(du, U{3})));
    const auto mean_at = [&](std::ptrdiff_t along) {
      const C* a = to_first + static_cast<std::ptrdiff_t>(x) + along;
      const C* b = to_second + static_cast<std::ptrdiff_t>(x) - along;
      return mean_of(d, hn::LoadU(d, a), hn::LoadU(d, b));
    };
    auto mean = hn::IfThenElse(is_first, mean_at(-1), mean_at(0));
    mean = hn::IfThenElse(is_second, mean_at(1), mean);
    hn::StoreU(difference(d, hn::LoadU(d, v + x), mean), d, error + x);
  }
}

template <typename C>
void largest_of(std::span<const C* const> rows, std::size_t n, C* largest) {
  const RowTag<C> d;
  for (std::size_t x = 0; x < n; x += hn::Lanes(d)) {
    auto m = hn::Zero(d);
    for (const C* row : rows) m = hn::Max(m, hn::LoadU(d, row + x));
    hn::StoreU(m, d, largest + x);
  }
}

/// Smallest and largest sample so far, of as many points as a vector has lanes.
template <typename C, bool kHasNan>
struct Extremes {
  using Tag = RowTag<C>;
  hn::Vec<Tag> low;
  hn::Vec<Tag> high;

  /// An initializer in place would be compiled for no target.
  static Extremes none() {
    using Limits = std::numeric_limits<C>;
    if constexpr (Limits::has_infinity)
      return {hn::Set(Tag(), Limits::infinity()), hn::Set(Tag(), -Limits::infinity())};
    else
      return {hn::Set(Tag(), Limits::max()), hn::Set(Tag(), Limits::lowest())};
  }

  void join(const C* from_low, const C* from_high) {
    const Tag d;
    const auto l = hn::LoadU(d, from_low);
    const auto h = hn::LoadU(d, from_high);
    if constexpr (kHasNan) {
      low = hn::IfThenElse(hn::Lt(l, low), l, low);  // comparisons with NaN are false
      high = hn::IfThenElse(hn::Gt(h, high), h, high);
    } else {
      low = hn::Min(l, low);
      high = hn::Max(h, high);
    }
  }
};

template <bool kHasNan, typename C>
void extremes_round_as(const C* row, const RowStencil& stencil, std::size_t n, C* low, C* high) {
  const RowTag<C> d;
  std::array<std::array<C, kMaxRow + kRowPadding + 2>, 3> lows;  // per reach; of the rows alone
  std::array<std::array<C, kMaxRow + kRowPadding + 2>, 3> highs;
  for (std::size_t reach = 0; reach < stencil.size(); ++reach)
    for (std::size_t x = 0; x < n; x += hn::Lanes(d)) {
      auto e = Extremes<C, kHasNan>::none();
      for (const std::ptrdiff_t offset : stencil[reach]) e.join(row + offset + x, row + offset + x);
      hn::StoreU(e.low, d, lows[reach].data() + x);
      hn::StoreU(e.high, d, highs[reach].data() + x);
    }
  for (std::size_t x = 2; x + 2 < n; x += hn::Lanes(d)) {
    auto e = Extremes<C, false>::none();
    for (std::size_t reach = 0; reach < stencil.size(); ++reach)
      for (std::size_t at = x - reach; at <= x + reach; ++at)
        e.join(lows[reach].data() + at, highs[reach].data() + at);
    hn::StoreU(e.low, d, low + x);
    hn::StoreU(e.high, d, high + x);
  }
}

template <typename C>
void extremes_round(const C* row, const RowStencil& stencil, std::size_t n, bool has_nan, C* low,
                    C* high) {
  if constexpr (std::numeric_limits<C>::has_quiet_NaN)
    if (has_nan) return extremes_round_as<true>(row, stencil, n, low, high);
  extremes_round_as<false>(row, stencil, n, low, high);
}

template <typename C>
void range_of(const C* values, std::size_t n, C& low, C& high) {
  const hn::ScalableTag<C> d;
  const std::size_t step = hn::Lanes(d);
  auto lows = hn::Set(d, values[0]);
  auto highs = lows;
  std::size_t i = 0;
  for (; i + step <= n; i += step) {
    const auto v = hn::LoadU(d, values + i);
    lows = hn::Min(lows, v);
    highs = hn::Max(highs, v);
  }
  low = hn::GetLane(hn::MinOfLanes(d, lows));
  high = hn::GetLane(hn::MaxOfLanes(d, highs));
  for (; i < n; ++i) {
    low = values[i] < low ? values[i] : low;
    high = values[i] > high ? values[i] : high;
  }
}

// Highway exports functions, not templates.
void range_of_float(const float* values, std::size_t n, float& low, float& high) {
  range_of(values, n, low, high);
}
void range_of_double(const double* values, std::size_t n, double& low, double& high) {
  range_of(values, n, low, high);
}
void range_of_step(const std::uint16_t* values, std::size_t n, std::uint16_t& low,
                   std::uint16_t& high) {
  range_of(values, n, low, high);
}
void midpoint_errors_step(const std::uint16_t* v, std::ptrdiff_t across, std::size_t n,
                          std::uint16_t* error) {
  midpoint_errors(v, across, n, error);
}
void largest_of_step(std::span<const std::uint16_t* const> rows, std::size_t n,
                     std::uint16_t* largest) {
  largest_of(rows, n, largest);
}
void extremes_round_step(const std::uint16_t* row, const RowStencil& stencil, std::size_t n,
                         bool has_nan, std::uint16_t* low, std::uint16_t* high) {
  extremes_round(row, stencil, n, has_nan, low, high);
}
void midpoint_errors_float(const float* v, std::ptrdiff_t across, std::size_t n, float* error) {
  midpoint_errors(v, across, n, error);
}
void midpoint_errors_double(const double* v, std::ptrdiff_t across, std::size_t n, double* error) {
  midpoint_errors(v, across, n, error);
}
void largest_of_float(std::span<const float* const> rows, std::size_t n, float* largest) {
  largest_of(rows, n, largest);
}
void largest_of_double(std::span<const double* const> rows, std::size_t n, double* largest) {
  largest_of(rows, n, largest);
}
void extremes_round_float(const float* row, const RowStencil& stencil, std::size_t n, bool has_nan,
                          float* low, float* high) {
  extremes_round(row, stencil, n, has_nan, low, high);
}
void extremes_round_double(const double* row, const RowStencil& stencil, std::size_t n,
                           bool has_nan, double* low, double* high) {
  extremes_round(row, stencil, n, has_nan, low, high);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(range_of_step);
HWY_EXPORT(midpoint_errors_step);
HWY_EXPORT(largest_of_step);
HWY_EXPORT(extremes_round_step);
HWY_EXPORT(range_of_float);
HWY_EXPORT(range_of_double);
HWY_EXPORT(midpoint_errors_float);
HWY_EXPORT(midpoint_errors_double);
HWY_EXPORT(largest_of_float);
HWY_EXPORT(largest_of_double);
HWY_EXPORT(extremes_round_float);
HWY_EXPORT(extremes_round_double);

void midpoint_errors(const std::uint16_t* v, std::ptrdiff_t across, std::size_t n,
                     std::uint16_t* error) {
  HWY_DYNAMIC_DISPATCH(midpoint_errors_step)(v, across, n, error);
}
void largest_of(std::span<const std::uint16_t* const> rows, std::size_t n, std::uint16_t* largest) {
  HWY_DYNAMIC_DISPATCH(largest_of_step)(rows, n, largest);
}
void range_of(const std::uint16_t* values, std::size_t n, std::uint16_t& low, std::uint16_t& high) {
  HWY_DYNAMIC_DISPATCH(range_of_step)(values, n, low, high);
}
void extremes_round(const std::uint16_t* row, const RowStencil& stencil, std::size_t n,
                    bool has_nan, std::uint16_t* low, std::uint16_t* high) {
  HWY_DYNAMIC_DISPATCH(extremes_round_step)(row, stencil, n, has_nan, low, high);
}
void midpoint_errors(const float* v, std::ptrdiff_t across, std::size_t n, float* error) {
  HWY_DYNAMIC_DISPATCH(midpoint_errors_float)(v, across, n, error);
}
void midpoint_errors(const double* v, std::ptrdiff_t across, std::size_t n, double* error) {
  HWY_DYNAMIC_DISPATCH(midpoint_errors_double)(v, across, n, error);
}
void largest_of(std::span<const float* const> rows, std::size_t n, float* largest) {
  HWY_DYNAMIC_DISPATCH(largest_of_float)(rows, n, largest);
}
void range_of(const float* values, std::size_t n, float& low, float& high) {
  HWY_DYNAMIC_DISPATCH(range_of_float)(values, n, low, high);
}
void range_of(const double* values, std::size_t n, double& low, double& high) {
  HWY_DYNAMIC_DISPATCH(range_of_double)(values, n, low, high);
}
void largest_of(std::span<const double* const> rows, std::size_t n, double* largest) {
  HWY_DYNAMIC_DISPATCH(largest_of_double)(rows, n, largest);
}
void extremes_round(const float* row, const RowStencil& stencil, std::size_t n, bool has_nan,
                    float* low, float* high) {
  HWY_DYNAMIC_DISPATCH(extremes_round_float)(row, stencil, n, has_nan, low, high);
}
void extremes_round(const double* row, const RowStencil& stencil, std::size_t n, bool has_nan,
                    double* low, double* high) {
  HWY_DYNAMIC_DISPATCH(extremes_round_double)(row, stencil, n, has_nan, low, high);
}

}  // namespace lode::diamond
#endif
