#include "lode/models/diamond/world_rows.h"

// Each target is another copy of this file to compile.
#define HWY_DISABLED_TARGETS (HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/world_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

#include "lode/models/diamond/error_code.h"

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <typename C>
using WorldTag = hn::CappedTag<C, 16>;

/// Nodes side by side. Every sum of squares is first + rest, along a path of neighbours; the
/// smallest is taken among numbers alone, as comparisons with NaN are false.
template <std::size_t kOdd, std::size_t kAxes, typename C>
class WorldNodes {
 public:
  using Tag = WorldTag<C>;
  using V = hn::Vec<Tag>;

  WorldNodes(const WorldKind<C>& kind, const C* values) : kind_(kind), values_(values) {}

  /// The smallest squared gradient of the nodes from place `at` on.
  HWY_INLINE V smallest_squared(std::ptrdiff_t at) const {
    if constexpr (kOdd == 1) return round_edge(at);
    if constexpr (kOdd == 2) return round_face(at);
    if constexpr (kOdd == 3) return in_cube(at);
  }

 private:
  static constexpr std::array<std::ptrdiff_t, 3> kSteps{1, 3, 9};

  HWY_INLINE V load(std::ptrdiff_t at, std::ptrdiff_t step) const {
    return hn::LoadU(Tag(), values_ + at + kind_.near[static_cast<std::size_t>(13 + step)]);
  }
  [[nodiscard]] std::ptrdiff_t step(std::size_t i) const { return kSteps[kind_.axes[i]]; }
  HWY_INLINE V face(V a, V b, std::size_t i) const {
    return square(a, b, kind_.face[kind_.axes[i]]);
  }
  HWY_INLINE V outward(V a, V b, std::size_t i) const {
    return square(a, b, kind_.outward[kind_.axes[i]]);
  }
  static HWY_INLINE V square(V a, V b, C factor) {
    const V difference = hn::Sub(b, a);
    return hn::Mul(hn::Mul(difference, difference), hn::Set(Tag(), factor));
  }
  static HWY_INLINE V smaller(V sum, V smallest) {
    return hn::IfThenElse(hn::Lt(sum, smallest), sum, smallest);
  }
  static HWY_INLINE V endless() { return hn::Set(Tag(), std::numeric_limits<C>::infinity()); }
  static HWY_INLINE V mean(V a, V b) { return hn::Mul(hn::Set(Tag(), C(0.5)), hn::Add(a, b)); }

  /// Swaps a and b where nodes are mirrored along the odd axis number `i` of the kind.
  HWY_INLINE void mirror(std::ptrdiff_t at, std::size_t i, V& a, V& b) const {
    const hn::RebindToUnsigned<Tag> du;
    const auto* bits = static_cast<const hn::TFromD<decltype(du)>*>(kind_.is_mirrored[i - 1]);
    const auto is_mirrored =
        hn::MaskFromVec(hn::BitCast(Tag(), hn::LoadU(du, bits + (at - kind_.origin))));
    const V first = a;
    a = hn::IfThenElse(is_mirrored, b, a);
    b = hn::IfThenElse(is_mirrored, first, b);
  }

  HWY_INLINE V round_edge(std::ptrdiff_t at) const {
    const V a = load(at, -step(0));
    const V b = load(at, step(0));
    const V middle = mean(a, b);
    V out = endless();
    if constexpr (kAxes == 2) {
      for (const std::ptrdiff_t s : {-step(1), step(1)})
        out = smaller(outward(middle, load(at, s), 1), out);
      return hn::Add(face(a, b, 0), out);
    }
    for (const std::size_t first : {std::size_t{1}, std::size_t{2}})
      for (const std::ptrdiff_t s : {-step(first), step(first)}) {
        const std::size_t second = 3 - first;
        const V q = load(at, s);
        V rest = endless();
        for (const std::ptrdiff_t t : {-step(second), step(second)})
          rest = smaller(outward(q, load(at, s + t), second), rest);
        out = smaller(hn::Add(outward(middle, q, first), rest), out);
      }
    return hn::Add(face(a, b, 0), out);
  }

  HWY_INLINE V round_face(std::ptrdiff_t at) const {
    V c00 = load(at, -step(0) - step(1));
    V c10 = load(at, step(0) - step(1));
    V c01 = load(at, -step(0) + step(1));
    V c11 = load(at, step(0) + step(1));
    mirror(at, 1, c00, c01);
    mirror(at, 1, c10, c11);
    V along = smaller(hn::Add(face(c00, c10, 0), face(c10, c11, 1)), endless());
    along = smaller(hn::Add(face(c00, c01, 1), face(c01, c11, 0)), along);
    if constexpr (kAxes == 2) return along;
    const V middle = mean(c00, c11);
    V out = endless();
    for (const std::ptrdiff_t s : {-step(2), step(2)})
      out = smaller(outward(middle, load(at, s), 2), out);
    return hn::Add(along, out);
  }

  HWY_INLINE V in_cube(std::ptrdiff_t at) const {
    const auto corner = [&](int x, int y, int z) HWY_ATTR {
      return load(at, (x != 0 ? step(0) : -step(0)) + (y != 0 ? step(1) : -step(1)) +
                          (z != 0 ? step(2) : -step(2)));
    };
    V c000 = corner(0, 0, 0);
    V c100 = corner(1, 0, 0);
    V c010 = corner(0, 1, 0);
    V c110 = corner(1, 1, 0);
    V c001 = corner(0, 0, 1);
    V c101 = corner(1, 0, 1);
    V c011 = corner(0, 1, 1);
    V c111 = corner(1, 1, 1);
    mirror(at, 1, c000, c010);
    mirror(at, 1, c100, c110);
    mirror(at, 1, c001, c011);
    mirror(at, 1, c101, c111);
    mirror(at, 2, c000, c001);
    mirror(at, 2, c100, c101);
    mirror(at, 2, c010, c011);
    mirror(at, 2, c110, c111);
    const auto two = [&](V a, V b, V c, V d, std::size_t i, std::size_t j) HWY_ATTR {
      // From a to d over b, along i and then j, or over c.
      const V over_b = hn::Add(face(a, b, i), face(b, d, j));
      const V over_c = hn::Add(face(a, c, j), face(c, d, i));
      return smaller(over_c, smaller(over_b, endless()));
    };
    V along = endless();
    along = smaller(hn::Add(face(c000, c100, 0), two(c100, c110, c101, c111, 1, 2)), along);
    along = smaller(hn::Add(face(c000, c010, 1), two(c010, c110, c011, c111, 0, 2)), along);
    return smaller(hn::Add(face(c000, c001, 2), two(c001, c101, c011, c111, 0, 1)), along);
  }

  const WorldKind<C>& kind_;
  const C* values_;
};

template <std::size_t kOdd, typename C>
HWY_INLINE hn::Vec<WorldTag<C>> largest_beside(const WorldKind<C>& kind, const C* of,
                                               std::ptrdiff_t at) {
  const WorldTag<C> d;
  auto largest = hn::LoadU(d, of + at);
  constexpr std::array<std::size_t, 3> kSteps{1, 3, 9};
  for (std::size_t i = 0; i < kOdd; ++i) {
    const std::size_t step = kSteps[kind.axes[i]];
    largest = hn::Max(largest, hn::LoadU(d, of + at + kind.near[13 - step]));
    largest = hn::Max(largest, hn::LoadU(d, of + at + kind.near[13 + step]));
  }
  return largest;
}

template <std::size_t kOdd, std::size_t kAxes, bool kIsJoined, typename C>
void find_worlds_of(const WorldKind<C>& kind, const C* values, C* errors, C* worlds) {
  const WorldTag<C> d;
  const WorldNodes<kOdd, kAxes, C> nodes(kind, values);
  const auto n = static_cast<std::ptrdiff_t>(hn::Lanes(d));
  const auto endless = hn::Set(d, std::numeric_limits<C>::infinity());
  const auto longest = hn::Set(d, kind.longest);
  for (std::ptrdiff_t at = kind.begin; at < kind.end; at += n) {
    auto error = hn::LoadU(d, errors + at);
    if constexpr (kIsJoined) {
      error = largest_beside<kOdd>(kind, errors, at);
      hn::StoreU(error, d, errors + at);
    }
    auto squared = nodes.smallest_squared(at);
    squared = hn::IfThenElseZero(hn::Lt(squared, endless), squared);
    auto share = hn::Div(error, hn::Sqrt(squared));
    share = hn::IfThenElse(hn::Lt(share, longest), share, longest);
    share = hn::IfThenElseZero(hn::Gt(error, hn::Zero(d)), share);
    hn::StoreU(share, d, worlds + at);
    if constexpr (kIsJoined) hn::StoreU(largest_beside<kOdd>(kind, worlds, at), d, worlds + at);
  }
}

/// Another name than that of the functions outside, which the argument's namespace would add.
template <typename C>
void find_worlds_as(const WorldKind<C>& kind, const C* values, C* errors, C* worlds,
                    bool is_nested) {
  if (kind.n_axes == 2) {
    if (kind.n_odd == 1) return find_worlds_of<1, 2, false>(kind, values, errors, worlds);
    if (is_nested) return find_worlds_of<2, 2, true>(kind, values, errors, worlds);
    return find_worlds_of<2, 2, false>(kind, values, errors, worlds);
  }
  if (kind.n_odd == 1) return find_worlds_of<1, 3, false>(kind, values, errors, worlds);
  if (kind.n_odd == 2 && is_nested) return find_worlds_of<2, 3, true>(kind, values, errors, worlds);
  if (kind.n_odd == 2) return find_worlds_of<2, 3, false>(kind, values, errors, worlds);
  if (is_nested) return find_worlds_of<3, 3, true>(kind, values, errors, worlds);
  find_worlds_of<3, 3, false>(kind, values, errors, worlds);
}

/// Of pairs that are read at once no more than a row is padded with.
template <typename C>
using ApartTag = hn::CappedTag<C, 8>;

template <typename C>
HWY_INLINE void take_row_apart(const C* from, std::size_t n, C* even, C* odd) {
  const ApartTag<C> d;
  for (std::size_t i = 0; 2 * i < n; i += hn::Lanes(d)) {
    hn::Vec<decltype(d)> a;
    hn::Vec<decltype(d)> b;
    hn::LoadInterleaved2(d, from + 2 * i, a, b);
    hn::StoreU(a, d, even + i);
    hn::StoreU(b, d, odd + i);
  }
}

/// Two 16-bit numbers as one of 32 bits: the lower one is the first.
HWY_INLINE void take_row_apart(const std::uint16_t* from, std::size_t n, float* even, float* odd) {
  const ApartTag<float> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Repartition<std::uint16_t, decltype(du)> dh;
  for (std::size_t i = 0; 2 * i < n; i += hn::Lanes(d)) {
    const auto both = hn::BitCast(du, hn::LoadU(dh, from + 2 * i));
    const auto first = hn::And(both, hn::Set(du, 0xFFFFU));
    const auto second = hn::ShiftRight<16>(both);
    hn::StoreU(hn::ConvertTo(d, hn::BitCast(di, first)), d, even + i);
    hn::StoreU(hn::ConvertTo(d, hn::BitCast(di, second)), d, odd + i);
  }
}

/// Ascending: what a row writes beyond its end, the next one puts right.
template <typename V, typename C>
void take_rows_apart(const V* from, std::size_t n, std::size_t n_rows, ApartRows<C> rows) {
  for (std::size_t r = 0; r < n_rows; ++r, from += n) {
    auto& [even, odd] = rows.to[r & 1U];
    take_row_apart(from, n, even, odd);
    even += rows.stride;
    odd += rows.stride;
  }
}

template <typename C>
void raise_codes_as(const C* shares, std::size_t n, std::size_t step, WorldCode* codes) {
  const auto code_of = [&](std::size_t i) {
    if constexpr (sizeof(C) == 4) return encode_world(shares[i]);
    return encode_world(float_up(static_cast<double>(shares[i])));
  };
  if (step == 1)
    for (std::size_t i = 0; i < n; ++i) codes[i] = std::max(codes[i], code_of(i));
  else
    for (std::size_t i = 0; i < n; ++i) codes[i * step] = std::max(codes[i * step], code_of(i));
}

// Highway exports functions, not templates.
void find_worlds_float(const WorldKind<float>& kind, const float* values, float* errors,
                       float* worlds, bool is_nested) {
  find_worlds_as(kind, values, errors, worlds, is_nested);
}
void find_worlds_double(const WorldKind<double>& kind, const double* values, double* errors,
                        double* worlds, bool is_nested) {
  find_worlds_as(kind, values, errors, worlds, is_nested);
}
void take_apart_floats(const float* from, std::size_t n, std::size_t n_rows,
                       ApartRows<float> rows) {
  take_rows_apart(from, n, n_rows, rows);
}
void take_apart_doubles(const double* from, std::size_t n, std::size_t n_rows,
                        ApartRows<double> rows) {
  take_rows_apart(from, n, n_rows, rows);
}
void take_apart_steps(const std::uint16_t* from, std::size_t n, std::size_t n_rows,
                      ApartRows<float> rows) {
  take_rows_apart(from, n, n_rows, rows);
}
void raise_codes_float(const float* shares, std::size_t n, std::size_t step, WorldCode* codes) {
  raise_codes_as(shares, n, step, codes);
}
void raise_codes_double(const double* shares, std::size_t n, std::size_t step, WorldCode* codes) {
  raise_codes_as(shares, n, step, codes);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(find_worlds_float);
HWY_EXPORT(find_worlds_double);
HWY_EXPORT(take_apart_floats);
HWY_EXPORT(take_apart_doubles);
HWY_EXPORT(take_apart_steps);
HWY_EXPORT(raise_codes_float);
HWY_EXPORT(raise_codes_double);

void find_worlds(const WorldKind<float>& kind, const float* values, float* errors, float* worlds,
                 bool is_nested) {
  HWY_DYNAMIC_DISPATCH(find_worlds_float)(kind, values, errors, worlds, is_nested);
}
void find_worlds(const WorldKind<double>& kind, const double* values, double* errors,
                 double* worlds, bool is_nested) {
  HWY_DYNAMIC_DISPATCH(find_worlds_double)(kind, values, errors, worlds, is_nested);
}
void take_apart(const float* from, std::size_t n, std::size_t n_rows, ApartRows<float> rows) {
  HWY_DYNAMIC_DISPATCH(take_apart_floats)(from, n, n_rows, rows);
}
void take_apart(const double* from, std::size_t n, std::size_t n_rows, ApartRows<double> rows) {
  HWY_DYNAMIC_DISPATCH(take_apart_doubles)(from, n, n_rows, rows);
}
void take_apart(const std::uint16_t* from, std::size_t n, std::size_t n_rows,
                ApartRows<float> rows) {
  HWY_DYNAMIC_DISPATCH(take_apart_steps)(from, n, n_rows, rows);
}
void raise_codes(const float* shares, std::size_t n, std::size_t step, WorldCode* codes) {
  HWY_DYNAMIC_DISPATCH(raise_codes_float)(shares, n, step, codes);
}
void raise_codes(const double* shares, std::size_t n, std::size_t step, WorldCode* codes) {
  HWY_DYNAMIC_DISPATCH(raise_codes_double)(shares, n, step, codes);
}

}  // namespace lode::diamond
#endif
