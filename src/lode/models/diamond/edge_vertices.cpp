#include "lode/models/diamond/edge_vertices.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/edge_vertices.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Double = hn::CappedTag<double, 8>;
using Float = hn::Rebind<float, Double>;
using Int = hn::Rebind<std::int32_t, Double>;
using DoubleV = hn::Vec<Double>;

template <typename T>
HWY_INLINE DoubleV load_values(const T* from) {
  const Double d;
  const auto values = hn::LoadU(hn::Rebind<T, Double>(), from);
  if constexpr (sizeof(T) == 8)
    return values;
  else if constexpr (sizeof(T) == 4)
    return hn::PromoteTo(d, values);
  else
    return hn::PromoteTo(d, hn::PromoteTo(Int(), values));
}

/// Lattice points, coordinate by coordinate.
struct LatticePoint {
  DoubleV x, y, z;
};

/// p + t (q - p): the product is exact.
template <int kStepShift>
HWY_INLINE DoubleV along(hn::Vec<Int> p, hn::Vec<Int> place, DoubleV t) {
  const Double d;
  const auto step = hn::ShiftRight<30>(hn::ShiftLeft<30 - kStepShift>(place));
  return hn::Add(hn::PromoteTo(d, p), hn::Mul(t, hn::PromoteTo(d, step)));
}

/// As LatticeFrame::position(), operation by operation; where the lattice's axes are the world's,
/// without those that add 0.
template <bool kHasOwnAxes, std::size_t i>
HWY_INLINE DoubleV world_coordinate(const LatticeFrame& frame, const LatticePoint& p) {
  const Double d;
  const Vec3d& row = frame.to_world.rows[i];
  auto sum = hn::Zero(d);
  if (kHasOwnAxes || i == 0) sum = hn::Add(sum, hn::Mul(hn::Set(d, row[0]), p.x));
  if (kHasOwnAxes || i == 1) sum = hn::Add(sum, hn::Mul(hn::Set(d, row[1]), p.y));
  if (kHasOwnAxes || i == 2) sum = hn::Add(sum, hn::Mul(hn::Set(d, row[2]), p.z));
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
  const Double d;
  const Float df;
  const Int di;
  const std::size_t lanes = hn::Lanes(d);
  const LatticeFrame& frame = *to.frame;
  const auto isovalue = hn::Set(d, to.isovalue);
  const auto lowest = hn::Set(d, frame.margin);
  const auto highest = hn::Set(d, 1 - frame.margin);
  const auto one = hn::Set(di, 1);
  auto largest_step = hn::Zero(d);
  auto largest_snap = hn::Zero(d);
  float* out = to.positions->v.data();
  for (std::size_t i = 0; i < run.n; i += lanes) {
    const auto a = load_values(run.first + i);
    const auto difference = hn::Sub(load_values(run.second + i), a);
    const auto t = hn::Div(hn::Sub(isovalue, a), difference);
    const auto kept = hn::Min(hn::Max(t, lowest), highest);
    if (to.kept != nullptr) hn::StoreU(kept, d, to.kept + i);
    const std::size_t n = std::min(lanes, run.n - i);
    const auto step = hn::IfThenElseZero(hn::FirstN(d, n), hn::Abs(difference));
    largest_step = hn::Max(largest_step, step);
    largest_snap = hn::Max(largest_snap, hn::IfThenElseZero(hn::Ne(kept, t), step));
    const auto place = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(run.place) + i);
    const auto row = hn::And(hn::ShiftRight<kRowShift>(place), hn::Set(di, kRowsPerRun - 1));
    const LatticePoint p{
        along<22>(hn::And(place, hn::Set(di, 0xFFFFF)), place, kept),
        along<24>(hn::Add(hn::Add(hn::Set(di, to.y), row), hn::And(hn::ShiftRight<20>(place), one)),
                  place, kept),
        along<26>(hn::Add(hn::Set(di, to.z), hn::And(hn::ShiftRight<21>(place), one)), place,
                  kept)};
    const auto x = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 0>(frame, p));
    const auto y = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 1>(frame, p));
    const auto z = hn::DemoteTo(df, world_coordinate<kHasOwnAxes, 2>(frame, p));
    if (to.positions + i + lanes <= to.end) {
      hn::StoreInterleaved3(x, y, z, df, out + 3 * i);
    } else {
      float last[3 * 8];
      hn::StoreInterleaved3(x, y, z, df, last);
      std::memcpy(out + 3 * i, last, 3 * n * sizeof(float));
    }
  }
  extremes.largest_step =
      std::max(extremes.largest_step, hn::GetLane(hn::MaxOfLanes(d, largest_step)));
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
