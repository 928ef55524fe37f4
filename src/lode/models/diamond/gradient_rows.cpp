#include "lode/models/diamond/gradient_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/gradient_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// high - low, which floats have exactly of integers of 16 bits.
template <typename T, class D>
HWY_INLINE hn::Vec<D> difference(D d, const T* low, const T* high) {
  const hn::Rebind<T, D> from;
  const auto a = hn::LoadU(from, low);
  const auto b = hn::LoadU(from, high);
  if constexpr (sizeof(T) <= 2) {
    const hn::Rebind<std::int32_t, D> whole;
    return hn::ConvertTo(d, hn::Sub(hn::PromoteTo(whole, b), hn::PromoteTo(whole, a)));
  } else if constexpr (sizeof(T) == 4) {
    return hn::Sub(hn::PromoteTo(d, b), hn::PromoteTo(d, a));
  } else {
    return hn::Sub(b, a);
  }
}

template <typename T>
void run_gradients(const RunNeighbours<T>& from, GradientOf<T>* out) {
  using Gradient = GradientOf<T>;
  const hn::CappedTag<Gradient, std::min(kGradientRun, 64 / sizeof(Gradient))> d;
  const auto half = hn::Set(d, Gradient{0.5});
  const auto scale_y = hn::Set(d, static_cast<Gradient>(from.scale[0]));
  const auto scale_z = hn::Set(d, static_cast<Gradient>(from.scale[1]));
  for (std::size_t i = 0; i < kGradientRun; i += hn::Lanes(d)) {
    const auto x = hn::Mul(difference(d, from.run + i - 1, from.run + i + 1), half);
    const auto y = hn::Mul(difference(d, from.low[0] + i, from.high[0] + i), scale_y);
    const auto z = hn::Mul(difference(d, from.low[1] + i, from.high[1] + i), scale_z);
    hn::StoreInterleaved4(x, y, z, hn::Zero(d), d, out + 4 * i);
  }
}

void run_places(const GradientPlaces& places, const EdgePlaces& of) {
  const hn::ScalableTag<std::int32_t> d;
  const auto set = [&](auto x) HWY_ATTR { return hn::Set(d, static_cast<std::int32_t>(x)); };
  const auto one = set(1);
  const auto rows = set(places.n_rows - 1);
  const auto row_length = set(places.row_length);
  const auto slice_length = set(places.n_rows * places.row_length);
  const auto put = [&](auto x, auto y, auto z, std::uint32_t* out) HWY_ATTR {
    const auto row = hn::Mul(hn::And(y, rows), row_length);
    const auto slice = hn::Mul(hn::And(z, one), slice_length);
    hn::StoreU(hn::Add(hn::Add(x, row), slice), d, reinterpret_cast<std::int32_t*>(out));
  };
  for (std::size_t i = 0; i < of.n; i += hn::Lanes(d)) {
    const auto edge = hn::LoadU(d, reinterpret_cast<const std::int32_t*>(of.edges) + i);
    const auto row = hn::And(hn::ShiftRight<PackedEdge::kRowShift>(edge), set(PackedEdge::kRow));
    const auto x = hn::And(edge, set(PackedEdge::kX));
    const auto y = hn::Add(set(of.y), row);
    const auto z = hn::Add(set(of.z), hn::And(hn::ShiftRight<PackedEdge::kUpShift>(edge), one));
    put(x, y, z, of.first + i);
    put(hn::Add(x, hn::ShiftRight<30>(hn::ShiftLeft<4>(edge))),
        hn::Add(y, hn::ShiftRight<30>(hn::ShiftLeft<2>(edge))),
        hn::Add(z, hn::ShiftRight<30>(edge)), of.second + i);
  }
}

void gradients_u8(const RunNeighbours<std::uint8_t>& from, float* out) { run_gradients(from, out); }
void gradients_u16(const RunNeighbours<std::uint16_t>& from, float* out) {
  run_gradients(from, out);
}
void gradients_i16(const RunNeighbours<std::int16_t>& from, float* out) {
  run_gradients(from, out);
}
void gradients_f32(const RunNeighbours<float>& from, double* out) { run_gradients(from, out); }
void gradients_f64(const RunNeighbours<double>& from, double* out) { run_gradients(from, out); }

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(gradients_u8);
HWY_EXPORT(gradients_u16);
HWY_EXPORT(gradients_i16);
HWY_EXPORT(gradients_f32);
HWY_EXPORT(gradients_f64);
HWY_EXPORT(run_places);

void find_gradients(const RunNeighbours<std::uint8_t>& from, float* out) {
  HWY_DYNAMIC_DISPATCH(gradients_u8)(from, out);
}
void find_gradients(const RunNeighbours<std::uint16_t>& from, float* out) {
  HWY_DYNAMIC_DISPATCH(gradients_u16)(from, out);
}
void find_gradients(const RunNeighbours<std::int16_t>& from, float* out) {
  HWY_DYNAMIC_DISPATCH(gradients_i16)(from, out);
}
void find_gradients(const RunNeighbours<float>& from, double* out) {
  HWY_DYNAMIC_DISPATCH(gradients_f32)(from, out);
}
void find_gradients(const RunNeighbours<double>& from, double* out) {
  HWY_DYNAMIC_DISPATCH(gradients_f64)(from, out);
}

void find_places(const GradientPlaces& places, const EdgePlaces& of) {
  HWY_DYNAMIC_DISPATCH(run_places)(places, of);
}

}  // namespace lode::diamond
#endif
