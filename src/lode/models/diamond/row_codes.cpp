#include "lode/models/diamond/row_codes.h"

// Each target is another copy of this file to compile.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/row_codes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Rows are short: wider vectors would find no whole one in many.
using Floats = hn::CappedTag<float, 8>;
using Ints = hn::Rebind<std::int32_t, Floats>;
using Bits = hn::Rebind<std::uint32_t, Floats>;

/// As encode_error, of numbers >= 0.
HWY_INLINE hn::Vec<Bits> code_of(hn::Vec<Floats> error) {
  const Bits bits;
  return hn::ShiftRight<16>(hn::Add(hn::BitCast(bits, error), hn::Set(bits, 0xFFFFU)));
}

void encode_row_of_errors(std::span<const float> errors, ErrorCode* codes) {
  const Floats d;
  const std::size_t n_lanes = hn::Lanes(d);
  const std::size_t n = errors.size();
  const hn::Rebind<ErrorCode, Floats> to;
  std::size_t i = 0;
  const auto encode = [&](std::size_t at) HWY_ATTR {
    // Of -1 the sign goes, and 0 stays.
    const auto error = hn::Max(hn::LoadU(d, errors.data() + at), hn::Zero(d));
    hn::StoreU(hn::DemoteTo(to, hn::BitCast(Ints(), code_of(error))), to, codes + at);
  };
  for (; i + n_lanes <= n; i += n_lanes) encode(i);
  if (i == n) return;
  if (n >= n_lanes) return encode(n - n_lanes);
  for (; i < n; ++i) codes[i] = errors[i] >= 0 ? encode_error(errors[i]) : ErrorCode{0};
}

void raise_row_of_errors(const ErrorCode* codes, std::size_t n, ErrorCode* to) {
  for (std::size_t i = 0; i < n; ++i) to[i] = std::max(to[i], codes[i]);
}

/// n values of rows a and b, `kStride` apart, each pair through convert: one(a, b) and of(a, b) of
/// vectors.
template <std::size_t kStride, typename R, typename Convert>
HWY_INLINE void convert_row(const float* a, const float* b, std::size_t n, const Convert& convert,
                            R* out) {
  const Floats d;
  const std::size_t n_lanes = hn::Lanes(d);
  const hn::Rebind<R, Floats> to;
  if (n < n_lanes) {
    for (std::size_t i = 0; i < n; ++i) out[i] = convert.one(a[kStride * i], b[kStride * i]);
    return;
  }
  const auto convert_at = [&](std::size_t i, auto load) HWY_ATTR {
    hn::StoreU(hn::DemoteTo(to, convert.of(load(a), load(b))), to, out + i);
  };
  std::size_t i = 0;
  if constexpr (kStride == 1) {
    for (; i + n_lanes < n; i += n_lanes)
      convert_at(i, [&](const float* row) HWY_ATTR { return hn::LoadU(d, row + i); });
    i = n - n_lanes;
    convert_at(i, [&](const float* row) HWY_ATTR { return hn::LoadU(d, row + i); });
  } else {
    // What lies between the values is read, what is behind them is not.
    for (; i + n_lanes < n; i += n_lanes)
      convert_at(i, [&](const float* row) HWY_ATTR {
        const float* const at = row + 2 * i;
        return hn::ConcatEven(d, hn::LoadU(d, at + n_lanes), hn::LoadU(d, at));
      });
    if (n > n_lanes) {
      i = n - n_lanes;
      return convert_at(i, [&](const float* row) HWY_ATTR {
        const float* const at = row + 2 * i - 1;
        return hn::ConcatOdd(d, hn::LoadU(d, at + n_lanes), hn::LoadU(d, at));
      });
    }
    for (; i < n; ++i) out[i] = convert.one(a[2 * i], b[2 * i]);
  }
}

/// An end of a range; kIsLow says which.
template <bool kIsLow, typename R>
struct RangeEnd {
  static constexpr auto kLowest = static_cast<float>(std::numeric_limits<R>::lowest());
  static constexpr auto kHighest = static_cast<float>(std::numeric_limits<R>::max());
  static constexpr R kEmpty =
      kIsLow ? std::numeric_limits<R>::max() : std::numeric_limits<R>::lowest();

  [[nodiscard]] R one(float low, float high) const {
    if (low > high) return kEmpty;
    return static_cast<R>(std::clamp(kIsLow ? low : high, kLowest, kHighest));
  }
  [[nodiscard]] HWY_INLINE hn::Vec<Ints> of(hn::Vec<Floats> low, hn::Vec<Floats> high) const {
    const Floats d;
    const auto end =
        hn::Min(hn::Max(kIsLow ? low : high, hn::Set(d, kLowest)), hn::Set(d, kHighest));
    const auto value =
        hn::IfThenElse(hn::Gt(low, high), hn::Set(d, static_cast<float>(kEmpty)), end);
    return hn::ConvertTo(Ints(), value);
  }
};

template <bool kIsLow, typename R>
HWY_INLINE void encode_ends(const float* low, const float* high, std::size_t n, std::size_t stride,
                            R* out) {
  if (stride == 1)
    convert_row<1>(low, high, n, RangeEnd<kIsLow, R>(), out);
  else
    convert_row<2>(low, high, n, RangeEnd<kIsLow, R>(), out);
}

// Highway exports functions, not templates.
#define LODE_ENCODE_ENDS(name, R)                                                           \
  void lows_##name(const float* low, const float* high, std::size_t n, std::size_t stride,  \
                   R* out) {                                                                \
    encode_ends<true>(low, high, n, stride, out);                                           \
  }                                                                                         \
  void highs_##name(const float* low, const float* high, std::size_t n, std::size_t stride, \
                    R* out) {                                                               \
    encode_ends<false>(low, high, n, stride, out);                                          \
  }
LODE_ENCODE_ENDS(i8, std::int8_t)
LODE_ENCODE_ENDS(u8, std::uint8_t)
LODE_ENCODE_ENDS(i16, std::int16_t)
LODE_ENCODE_ENDS(u16, std::uint16_t)
#undef LODE_ENCODE_ENDS

/// Two neighbours of a row of 16-bit numbers are one 32-bit number.
HWY_INLINE hn::Vec<Bits> pairs_from(const std::uint16_t* row) {
  const hn::Repartition<std::uint16_t, Bits> d;
  return hn::BitCast(Bits(), hn::LoadU(d, row));
}
HWY_INLINE hn::Vec<Bits> firsts(hn::Vec<Bits> pairs) {
  return hn::And(pairs, hn::Set(Bits(), 0xFFFFU));
}
HWY_INLINE hn::Vec<Bits> seconds(hn::Vec<Bits> pairs) { return hn::ShiftRight<16>(pairs); }
HWY_INLINE hn::Vec<Floats> to_float(hn::Vec<Bits> v) {
  return hn::ConvertTo(Floats(), hn::BitCast(Ints(), v));
}

/// The largest of the points 2 x, 2 x + 1, 2 x + 2, in lanes x.
HWY_INLINE hn::Vec<Floats> largest_from(const std::uint16_t* row) {
  const auto pairs = pairs_from(row);
  return to_float(hn::Max(hn::Max(firsts(pairs), seconds(pairs)), firsts(pairs_from(row + 2))));
}
HWY_INLINE hn::Vec<Floats> seconds_from(const std::uint16_t* row) {
  return to_float(seconds(pairs_from(row)));
}
HWY_INLINE hn::Vec<Floats> every_other(const float* row) {
  const Floats d;
  return hn::ConcatEven(d, hn::LoadU(d, row + hn::Lanes(d)), hn::LoadU(d, row));
}
HWY_INLINE hn::Vec<Floats> largest_from(const float* row) {
  return hn::Max(hn::Max(every_other(row), every_other(row + 1)), every_other(row + 2));
}
HWY_INLINE hn::Vec<Floats> seconds_from(const float* row) { return every_other(row + 1); }

template <typename V>
HWY_INLINE void encode_leaves(const LeafPoints<V>& from, std::size_t n, ErrorCode* error,
                              float* low, float* high) {
  const Floats d;
  const std::size_t n_lanes = hn::Lanes(d);
  const hn::Rebind<ErrorCode, Floats> codes;
  const auto first = hn::Set(d, from.first);
  const auto step = hn::Set(d, from.step);
  std::size_t x = 0;
  for (; x + n_lanes <= n; x += n_lanes) {
    const auto code = code_of(hn::Mul(largest_from(from.error + 2 * x), step));
    hn::StoreU(hn::DemoteTo(codes, hn::BitCast(Ints(), code)), codes, error + x);
    hn::StoreU(hn::Add(first, hn::Mul(step, seconds_from(from.low + 2 * x))), d, low + x);
    hn::StoreU(hn::Add(first, hn::Mul(step, seconds_from(from.high + 2 * x))), d, high + x);
  }
  for (; x < n; ++x) {
    const V largest = std::max({from.error[2 * x], from.error[2 * x + 1], from.error[2 * x + 2]});
    error[x] = encode_error(static_cast<float>(largest) * from.step);
    low[x] = from.first + from.step * static_cast<float>(from.low[2 * x + 1]);
    high[x] = from.first + from.step * static_cast<float>(from.high[2 * x + 1]);
  }
}

void encode_leaves_of_steps(const LeafPoints<std::uint16_t>& from, std::size_t n, ErrorCode* error,
                            float* low, float* high) {
  encode_leaves(from, n, error, low, high);
}
void encode_leaves_of_floats(const LeafPoints<float>& from, std::size_t n, ErrorCode* error,
                             float* low, float* high) {
  encode_leaves(from, n, error, low, high);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(encode_row_of_errors);
HWY_EXPORT(raise_row_of_errors);
HWY_EXPORT(encode_leaves_of_steps);
HWY_EXPORT(encode_leaves_of_floats);

void encode_errors(std::span<const float> errors, ErrorCode* codes) {
  HWY_DYNAMIC_DISPATCH(encode_row_of_errors)(errors, codes);
}
void raise_errors(const ErrorCode* codes, std::size_t n, ErrorCode* to) {
  HWY_DYNAMIC_DISPATCH(raise_row_of_errors)(codes, n, to);
}
void encode_leaf_row(const LeafPoints<std::uint16_t>& from, std::size_t n, ErrorCode* error,
                     float* low, float* high) {
  HWY_DYNAMIC_DISPATCH(encode_leaves_of_steps)(from, n, error, low, high);
}
void encode_leaf_row(const LeafPoints<float>& from, std::size_t n, ErrorCode* error, float* low,
                     float* high) {
  HWY_DYNAMIC_DISPATCH(encode_leaves_of_floats)(from, n, error, low, high);
}

#define LODE_ENCODE_ENDS(name, R)                                                              \
  HWY_EXPORT(lows_##name);                                                                     \
  HWY_EXPORT(highs_##name);                                                                    \
  template <>                                                                                  \
  void encode_lows<R>(const float* low, const float* high, std::size_t n, std::size_t stride,  \
                      R* out) {                                                                \
    HWY_DYNAMIC_DISPATCH(lows_##name)(low, high, n, stride, out);                              \
  }                                                                                            \
  template <>                                                                                  \
  void encode_highs<R>(const float* low, const float* high, std::size_t n, std::size_t stride, \
                       R* out) {                                                               \
    HWY_DYNAMIC_DISPATCH(highs_##name)(low, high, n, stride, out);                             \
  }
LODE_ENCODE_ENDS(i8, std::int8_t)
LODE_ENCODE_ENDS(u8, std::uint8_t)
LODE_ENCODE_ENDS(i16, std::int16_t)
LODE_ENCODE_ENDS(u16, std::uint16_t)
#undef LODE_ENCODE_ENDS

}  // namespace lode::diamond
#endif
