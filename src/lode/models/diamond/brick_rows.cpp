#include "lode/models/diamond/brick_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/brick_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr auto kRow = as_size(kBrickSamples<3>);
constexpr auto kEdge = as_size(kBrickEdge<3>);

template <typename D>
HWY_INLINE std::uint64_t bits_of(D d, hn::Mask<D> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  std::uint64_t bits;
  std::memcpy(&bits, bytes, sizeof(bits));
  return bits & ((std::uint64_t{1} << hn::Lanes(d)) - 1);
}

/// What twice a midpoint error is computed in: exact for short integers.
template <typename T>
using Real = std::conditional_t<sizeof(T) <= 2, float, double>;

template <typename D, typename T>
HWY_INLINE hn::Vec<D> load(D d, const T* from) {
  if constexpr (std::is_same_v<T, hn::TFromD<D>>) {
    return hn::LoadU(d, from);
  } else if constexpr (std::is_same_v<T, float>) {
    return hn::PromoteTo(d, hn::LoadU(hn::Rebind<float, D>(), from));
  } else {
    const hn::RebindToSigned<D> di;
    return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(hn::Rebind<T, D>(), from)));
  }
}

/// The rows at both sides of a row (y, z), along those of y and z that are odd: the first where
/// these are 0 modulo 4, the second where they are 2.
template <typename T>
struct RowEnds {
  RowEnds(const T* brick, std::size_t y, std::size_t z) {
    const auto zero_side = [](std::size_t c) {
      return (c & 1) == 0 ? c : (c & 3) == 1 ? c - 1 : c + 1;
    };
    const std::size_t y0 = zero_side(y);
    const std::size_t z0 = zero_side(z);
    first = brick + brick_row(y0, z0) * kRow;
    second = brick + brick_row(2 * y - y0, 2 * z - z0) * kRow;
  }
  const T* first;
  const T* second;
};

template <typename D>
HWY_INLINE hn::Mask<D> exceeds(D d, hn::Vec<D> error, hn::Vec<D> slack, hn::Vec<D> limit) {
  if constexpr (sizeof(hn::TFromD<D>) == 4) {
    (void)d;
    (void)slack;
    return hn::Gt(error, limit);
  } else {
    return hn::Gt(hn::Add(error, slack), limit);
  }
}

template <typename T>
HWY_INLINE std::uint64_t rough_row(const T* row, const RowEnds<T>& ends, const ErrorLimit& limit) {
  using R = Real<T>;
  const hn::CappedTag<R, kEdge / 2> d;
  const auto largest = hn::Set(d, static_cast<R>(limit.limit));
  const auto slack = hn::Set(d, static_cast<R>(limit.slack));
  const auto half = hn::Set(d, static_cast<R>(0.5));
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto lanes_like = [&](auto mask) HWY_ATTR {
    return hn::MaskFromVec(hn::BitCast(d, hn::VecFromMask(du, mask)));
  };
  const auto three = hn::Set(du, 3);
  const auto is_odd = lanes_like(hn::Ne(hn::And(hn::Iota(du, 0), hn::Set(du, 1)), hn::Zero(du)));
  std::uint64_t bits = 0;
  for (std::size_t x = 0; x < kEdge; x += hn::Lanes(d)) {
    const auto a = load(d, ends.first + x);
    const auto b = load(d, ends.second + x);
    const auto modulo = hn::And(hn::Iota(du, static_cast<hn::TFromD<decltype(du)>>(x)), three);
    const auto is_three = lanes_like(hn::Eq(modulo, three));
    // Odd samples lie between one at x - 1 and one at x + 1, of different rows.
    const auto before = hn::IfThenElse(is_three, hn::DupEven(b), hn::DupEven(a));
    const auto a_next = load(d, ends.first + x + 1);
    const auto b_next = load(d, ends.second + x + 1);
    const auto next = hn::IfThenElse(is_three, a_next, b_next);
    const auto sum = hn::IfThenElse(is_odd, hn::Add(before, next), hn::Add(a, b));
    const auto error = hn::Abs(hn::Sub(load(d, row + x), hn::Mul(half, sum)));
    bits |= bits_of(d, exceeds(d, error, slack, largest)) << x;
  }
  const double last =
      std::abs(static_cast<double>(row[kEdge]) - 0.5 * (static_cast<double>(ends.first[kEdge]) +
                                                        static_cast<double>(ends.second[kEdge])));
  if (last + limit.slack > static_cast<double>(limit.limit)) bits |= std::uint64_t{1} << kEdge;
  return bits;
}

template <typename T>
HWY_INLINE void rough_of(const T* brick, const ErrorLimit& limit, const BrickRows& rows,
                         BrickBits& rough) {
  constexpr std::uint64_t kOdd = 0xAAAAAAAAAAAAAAAAU;
  for (std::size_t z = 0; z < kRow; ++z)
    for (std::size_t y = 0; y < kRow; ++y) {
      std::uint64_t& bits = rough[brick_row(y, z)];
      bits = 0;
      if (((rows[z] >> y) & 1) == 0) continue;
      bits = rough_row(brick + brick_row(y, z) * kRow, RowEnds<T>(brick, y, z), limit);
      if (((y | z) & 1) == 0) bits &= kOdd;
    }
}

std::uint32_t refined_row(const StoredNodes& row, const NodeLimits& limits, std::uint32_t forced) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::Rebind<ErrorCode, decltype(d)> d16;
  const auto error = hn::Set(du, std::uint32_t{limits.error});
  const auto above = hn::Set(d, limits.above);
  const auto below = hn::Set(d, limits.below);
  std::uint32_t active = 0;
  std::uint32_t rough = 0;
  std::size_t x = 0;
  for (; x + hn::Lanes(d) <= row.n; x += hn::Lanes(d)) {
    const auto is_active = hn::And(hn::Lt(hn::LoadU(d, row.low + x), above),
                                   hn::Ge(hn::LoadU(d, row.high + x), below));
    active |= static_cast<std::uint32_t>(bits_of(d, is_active) << x);
    const auto errors = hn::PromoteTo(du, hn::LoadU(d16, row.error + x));
    rough |= static_cast<std::uint32_t>(bits_of(du, hn::Gt(errors, error)) << x);
  }
  for (; x < row.n; ++x) {
    const bool is_active = row.low[x] < limits.above && row.high[x] >= limits.below;
    active |= (is_active ? std::uint32_t{1} : 0) << x;
    rough |= (row.error[x] > limits.error ? std::uint32_t{1} : 0) << x;
  }
  return active & (rough | forced);
}

void rough_u8(const std::uint8_t* b, const ErrorLimit& l, const BrickRows& r, BrickBits& out) {
  rough_of(b, l, r, out);
}
void rough_u16(const std::uint16_t* b, const ErrorLimit& l, const BrickRows& r, BrickBits& out) {
  rough_of(b, l, r, out);
}
void rough_i16(const std::int16_t* b, const ErrorLimit& l, const BrickRows& r, BrickBits& out) {
  rough_of(b, l, r, out);
}
void rough_f32(const float* b, const ErrorLimit& l, const BrickRows& r, BrickBits& out) {
  rough_of(b, l, r, out);
}
void rough_f64(const double* b, const ErrorLimit& l, const BrickRows& r, BrickBits& out) {
  rough_of(b, l, r, out);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(refined_row);
HWY_EXPORT(rough_u8);
HWY_EXPORT(rough_u16);
HWY_EXPORT(rough_i16);
HWY_EXPORT(rough_f32);
HWY_EXPORT(rough_f64);

std::uint32_t find_refined(const StoredNodes& row, const NodeLimits& limits, std::uint32_t forced) {
  return HWY_DYNAMIC_DISPATCH(refined_row)(row, limits, forced);
}

void find_rough(const std::uint8_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough) {
  HWY_DYNAMIC_DISPATCH(rough_u8)(brick, limit, rows, rough);
}
void find_rough(const std::uint16_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough) {
  HWY_DYNAMIC_DISPATCH(rough_u16)(brick, limit, rows, rough);
}
void find_rough(const std::int16_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough) {
  HWY_DYNAMIC_DISPATCH(rough_i16)(brick, limit, rows, rough);
}
void find_rough(const float* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough) {
  HWY_DYNAMIC_DISPATCH(rough_f32)(brick, limit, rows, rough);
}
void find_rough(const double* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough) {
  HWY_DYNAMIC_DISPATCH(rough_f64)(brick, limit, rows, rough);
}

}  // namespace lode::diamond
#endif
