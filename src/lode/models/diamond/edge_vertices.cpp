#include "lode/models/diamond/edge_vertices.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/edge_vertices.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Double = hn::CappedTag<double, 8>;
using Float = hn::Rebind<float, Double>;
using Int = hn::Rebind<std::int32_t, Double>;
using DoubleV = hn::Vec<Double>;

/// Samples at the ends of edges.
template <typename T>
class EndValues {
 public:
  EndValues(const T* first, const T* second) {
    const auto a = hn::LoadU(hn::Rebind<T, Double>(), first);
    const auto b = hn::LoadU(hn::Rebind<T, Double>(), second);
    const Double d;
    if constexpr (kIsShort) {
      const auto low = hn::PromoteTo(Int(), a);
      steps_ = hn::Sub(hn::PromoteTo(Int(), b), low);
      first_ = hn::PromoteTo(d, low);
    } else if constexpr (sizeof(T) == 4) {
      first_ = hn::PromoteTo(d, a);
      steps_ = hn::Sub(hn::PromoteTo(d, b), first_);
    } else {
      first_ = a;
      steps_ = hn::Sub(b, a);
    }
  }
  [[nodiscard]] HWY_INLINE DoubleV first() const { return first_; }
  [[nodiscard]] HWY_INLINE DoubleV difference() const {
    if constexpr (kIsShort)
      return hn::PromoteTo(Double(), steps_);
    else
      return steps_;
  }

  /// Differences of integers of 16 bits are integers.
  static constexpr bool kIsShort = sizeof(T) <= 2;
  using Step = std::conditional_t<kIsShort, Int, Double>;
  using StepV = hn::Vec<Step>;
  /// Raises `largest` to the first n differences' sizes.
  HWY_INLINE void raise(StepV& largest, std::size_t n) const {
    const Step d;
    const auto size = hn::Abs(steps_);
    largest =
        hn::Max(largest, n == hn::Lanes(d) ? size : hn::IfThenElseZero(hn::FirstN(d, n), size));
  }

 private:
  DoubleV first_;
  StepV steps_;
};

/// Points of the lattice, coordinate by coordinate.
struct LatticePoint {
  DoubleV x, y, z;
};

#if HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL

/// Whether the edges have this bit.
HWY_INLINE __mmask8 has_bit(hn::Vec<Int> edge, int bit) {
  return _mm256_test_epi32_mask(edge.raw, _mm256_set1_epi32(static_cast<int>(1U << bit)));
}

/// p, or p + t, or p - t, as p + t (q - p) is.
template <int kAxis>
HWY_INLINE DoubleV along(DoubleV p, hn::Vec<Int> edge, DoubleV t) {
  constexpr int kShift = PackedEdge::kStepShift + 2 * kAxis;
  const __m512d up = _mm512_mask_add_pd(p.raw, has_bit(edge, kShift), p.raw, t.raw);
  return DoubleV{_mm512_mask_sub_pd(up, has_bit(edge, kShift + 1), p.raw, t.raw)};
}

/// z, or the next one.
HWY_INLINE DoubleV height_of(hn::Vec<Int> edge, std::int32_t z) {
  const __m512d low = _mm512_set1_pd(z);
  return DoubleV{
      _mm512_mask_add_pd(low, has_bit(edge, PackedEdge::kUpShift), low, _mm512_set1_pd(1))};
}

/// Eight points, one after the other.
HWY_INLINE void store_points(hn::Vec<Float> x, hn::Vec<Float> y, hn::Vec<Float> z, float* out) {
  const __m512 xy = _mm512_insertf32x8(_mm512_castps256_ps512(x.raw), y.raw, 1);
  const __m512 only_z = _mm512_castps256_ps512(z.raw);
  const __m512i first = _mm512_set_epi32(5, 20, 12, 4, 19, 11, 3, 18, 10, 2, 17, 9, 1, 16, 8, 0);
  const __m512i last = _mm512_castsi256_si512(_mm256_set_epi32(23, 15, 7, 22, 14, 6, 21, 13));
  _mm512_storeu_ps(out, _mm512_permutex2var_ps(xy, first, only_z));
  _mm256_storeu_ps(out + 16, _mm512_castps512_ps256(_mm512_permutex2var_ps(xy, last, only_z)));
}

#else

/// p + t (q - p): the product is exact.
template <int kAxis>
HWY_INLINE DoubleV along(DoubleV p, hn::Vec<Int> edge, DoubleV t) {
  constexpr int kShift = PackedEdge::kStepShift + 2 * kAxis;
  const auto step = hn::ShiftRight<30>(hn::ShiftLeft<30 - kShift>(edge));
  return hn::Add(p, hn::Mul(t, hn::PromoteTo(Double(), step)));
}

HWY_INLINE DoubleV height_of(hn::Vec<Int> edge, std::int32_t z) {
  const auto up = hn::And(hn::ShiftRight<PackedEdge::kUpShift>(edge), hn::Set(Int(), 1));
  return hn::PromoteTo(Double(), hn::Add(hn::Set(Int(), z), up));
}

HWY_INLINE void store_points(hn::Vec<Float> x, hn::Vec<Float> y, hn::Vec<Float> z, float* out) {
  hn::StoreInterleaved3(x, y, z, Float(), out);
}

#endif

/// Where the edges, of a run that begins with row (y, z), have parameter t.
HWY_INLINE LatticePoint points_on(hn::Vec<Int> edge, DoubleV t, std::int32_t y, std::int32_t z) {
  const Double d;
  const Int di;
  const auto x = hn::And(edge, hn::Set(di, PackedEdge::kX));
  const auto row =
      hn::And(hn::ShiftRight<PackedEdge::kRowShift>(edge), hn::Set(di, PackedEdge::kRow));
  return {along<0>(hn::PromoteTo(d, x), edge, t),
          along<1>(hn::PromoteTo(d, hn::Add(hn::Set(di, y), row)), edge, t),
          along<2>(height_of(edge, z), edge, t)};
}

/// As LatticeFrame::position(), operation by operation; where the lattice's axes are the world's,
/// without those that add 0, which only matter for the sign of an origin that is 0.
template <bool kHasOwnAxes, std::size_t i>
HWY_INLINE DoubleV world_coordinate(const LatticeFrame& frame, const LatticePoint& p) {
  const Double d;
  const Vec3d& row = frame.to_world.rows[i];
  if constexpr (!kHasOwnAxes) {
    const auto along_axis = hn::Mul(hn::Set(d, row[i]), i == 0 ? p.x : i == 1 ? p.y : p.z);
    return hn::Add(hn::Set(d, frame.origin[i] + 0.0), along_axis);
  }
  auto sum = hn::Zero(d);
  sum = hn::Add(sum, hn::Mul(hn::Set(d, row[0]), p.x));
  sum = hn::Add(sum, hn::Mul(hn::Set(d, row[1]), p.y));
  sum = hn::Add(sum, hn::Mul(hn::Set(d, row[2]), p.z));
  return hn::Add(hn::Set(d, frame.origin[i]), sum);
}

bool has_own_axes(const LatticeFrame& frame) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (i != j && frame.to_world.rows[i][j] != 0) return true;
  return false;
}

template <bool kHasOwnAxes, typename T>
void run_in(const EdgeRun<T>& run, const VertexRun& to, EdgeExtremes& extremes) {
  using Ends = EndValues<T>;
  const Double d;
  const Float df;
  const typename Ends::Step ds;
  const std::size_t lanes = hn::Lanes(d);
  const LatticeFrame& frame = *to.frame;
  const auto isovalue = hn::Set(d, to.isovalue);
  const auto lowest = hn::Set(d, frame.margin);
  const auto highest = hn::Set(d, 1 - frame.margin);
  auto largest_step = hn::Zero(ds);
  auto largest_snap = hn::Zero(d);
  float* out = to.positions->v.data();
  for (std::size_t i = 0; i < run.n; i += lanes) {
    const std::size_t n = std::min(lanes, run.n - i);
    const Ends ends(run.first + i, run.second + i);
    const auto difference = ends.difference();
    const auto t = hn::Div(hn::Sub(isovalue, ends.first()), difference);
    const auto kept = hn::Min(hn::Max(t, lowest), highest);
    if (to.kept != nullptr) hn::StoreU(kept, d, to.kept + i);
    ends.raise(largest_step, n);
    const auto snapped = hn::And(hn::Ne(kept, t), hn::FirstN(d, n));
    if (HWY_UNLIKELY(!hn::AllFalse(d, snapped)))
      largest_snap = hn::Max(largest_snap, hn::IfThenElseZero(snapped, hn::Abs(difference)));
    const auto edge = hn::LoadU(Int(), reinterpret_cast<const std::int32_t*>(run.place) + i);
    const LatticePoint p = points_on(edge, kept, to.y, to.z);
    const auto x = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 0>(frame, p));
    const auto y = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 1>(frame, p));
    const auto z = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 2>(frame, p));
    if (to.positions + i + lanes <= to.end) {
      store_points(x, y, z, out + 3 * i);
    } else {
      float last[3 * 8];
      store_points(x, y, z, last);
      std::memcpy(out + 3 * i, last, 3 * n * sizeof(float));
    }
  }
  extremes.largest_step = std::max(
      extremes.largest_step, static_cast<double>(hn::GetLane(hn::MaxOfLanes(ds, largest_step))));
  extremes.largest_snap =
      std::max(extremes.largest_snap, hn::GetLane(hn::MaxOfLanes(d, largest_snap)));
}

template <typename T>
void run_vertices(const EdgeRun<T>& run, const VertexRun& to, EdgeExtremes& extremes) {
  if (has_own_axes(*to.frame))
    run_in<true>(run, to, extremes);
  else
    run_in<false>(run, to, extremes);
}

void vertices_u8(const EdgeRun<std::uint8_t>& run, const VertexRun& to, EdgeExtremes& extremes) {
  run_vertices(run, to, extremes);
}
void vertices_u16(const EdgeRun<std::uint16_t>& run, const VertexRun& to, EdgeExtremes& extremes) {
  run_vertices(run, to, extremes);
}
void vertices_i16(const EdgeRun<std::int16_t>& run, const VertexRun& to, EdgeExtremes& extremes) {
  run_vertices(run, to, extremes);
}
void vertices_f32(const EdgeRun<float>& run, const VertexRun& to, EdgeExtremes& extremes) {
  run_vertices(run, to, extremes);
}
void vertices_f64(const EdgeRun<double>& run, const VertexRun& to, EdgeExtremes& extremes) {
  run_vertices(run, to, extremes);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(vertices_u8);
HWY_EXPORT(vertices_u16);
HWY_EXPORT(vertices_i16);
HWY_EXPORT(vertices_f32);
HWY_EXPORT(vertices_f64);

void place_vertices(const EdgeRun<std::uint8_t>& run, const VertexRun& to, EdgeExtremes& extremes) {
  HWY_DYNAMIC_DISPATCH(vertices_u8)(run, to, extremes);
}
void place_vertices(const EdgeRun<std::uint16_t>& run, const VertexRun& to,
                    EdgeExtremes& extremes) {
  HWY_DYNAMIC_DISPATCH(vertices_u16)(run, to, extremes);
}
void place_vertices(const EdgeRun<std::int16_t>& run, const VertexRun& to, EdgeExtremes& extremes) {
  HWY_DYNAMIC_DISPATCH(vertices_i16)(run, to, extremes);
}
void place_vertices(const EdgeRun<float>& run, const VertexRun& to, EdgeExtremes& extremes) {
  HWY_DYNAMIC_DISPATCH(vertices_f32)(run, to, extremes);
}
void place_vertices(const EdgeRun<double>& run, const VertexRun& to, EdgeExtremes& extremes) {
  HWY_DYNAMIC_DISPATCH(vertices_f64)(run, to, extremes);
}

}  // namespace lode::diamond
#endif
