#include "lode/mappers/point_positions.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/mappers/point_positions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Double = hn::CappedTag<double, 8>;
using Key = hn::RebindToUnsigned<Double>;
using DoubleV = hn::Vec<Double>;

static_assert(sizeof(EdgePoint) == 3 * sizeof(double) && sizeof(Vec3f) == 3 * sizeof(float));

/// A coordinate of keys, exactly.
template <int kAxis>
HWY_INLINE DoubleV coordinate(hn::Vec<Key> keys) {
  const Double d;
  const Key du;
  constexpr double kTwoTo52 = 0x1p52;  // whose lowest mantissa bits count ones
  const auto field =
      hn::And(hn::ShiftRight<kAxis * kKeyBits>(keys), hn::Set(du, std::uint64_t{kKeyMask}));
  const auto shifted = hn::Set(d, kTwoTo52);
  return hn::Sub(hn::BitCast(d, hn::Or(field, hn::BitCast(du, shifted))), shifted);
}

template <int kAxis>
HWY_INLINE DoubleV along(hn::Vec<Key> first, hn::Vec<Key> second, DoubleV t) {
  const auto a = coordinate<kAxis>(first);
  const auto b = coordinate<kAxis>(second);
  return hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
}

/// As LatticeFrame::position(), operation by operation.
HWY_INLINE hn::Vec<hn::Rebind<float, Double>> world(const LatticeFrame& frame, std::size_t i,
                                                    DoubleV x, DoubleV y, DoubleV z) {
  const Double d;
  const Vec3d& row = frame.to_world.rows[i];
  auto sum = hn::Add(hn::Zero(d), hn::Mul(hn::Set(d, row[0]), x));
  sum = hn::Add(sum, hn::Mul(hn::Set(d, row[1]), y));
  sum = hn::Add(sum, hn::Mul(hn::Set(d, row[2]), z));
  return hn::DemoteTo(hn::Rebind<float, Double>(), hn::Add(hn::Set(d, frame.origin[i]), sum));
}

void place_all(std::span<const EdgePoint> points, const LatticeFrame& frame, Vec3f* out) {
  const Double d;
  const Key du;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= points.size(); i += lanes) {
    hn::Vec<Key> first;
    hn::Vec<Key> second;
    hn::Vec<Key> bits_of_t;
    hn::LoadInterleaved3(du, reinterpret_cast<const std::uint64_t*>(points.data() + i), first,
                         second, bits_of_t);
    const auto t = hn::BitCast(d, bits_of_t);
    const auto x = along<0>(first, second, t);
    const auto y = along<1>(first, second, t);
    const auto z = along<2>(first, second, t);
    hn::StoreInterleaved3(world(frame, 0, x, y, z), world(frame, 1, x, y, z),
                          world(frame, 2, x, y, z), hn::Rebind<float, Double>(),
                          reinterpret_cast<float*>(out + i));
  }
  for (; i < points.size(); ++i) {
    const Vec3d p = frame.position(points[i].lattice_position());
    out[i] = {{static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])}};
  }
}

}  // namespace lode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode {

HWY_EXPORT(place_all);

void place_points(std::span<const EdgePoint> points, const LatticeFrame& frame, Vec3f* out) {
  HWY_DYNAMIC_DISPATCH(place_all)(points, frame, out);
}

}  // namespace lode
#endif
