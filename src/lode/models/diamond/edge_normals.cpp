#include "lode/models/diamond/edge_normals.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/edge_normals.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Double = hn::CappedTag<double, 8>;
using Float = hn::Rebind<float, Double>;
using DoubleV = hn::Vec<Double>;

struct Vector3 {
  DoubleV x, y, z;
};

/// In this order of operations, as dot() does.
HWY_INLINE DoubleV dot(const Vector3& a, const Vector3& b) {
  auto sum = hn::Add(hn::Zero(Double()), hn::Mul(a.x, b.x));
  sum = hn::Add(sum, hn::Mul(a.y, b.y));
  return hn::Add(sum, hn::Mul(a.z, b.z));
}

HWY_INLINE Vector3 constant(const Vec3d& a) {
  const Double d;
  return {hn::Set(d, a[0]), hn::Set(d, a[1]), hn::Set(d, a[2])};
}

/// The gradients where the vertices are.
template <typename G>
HWY_INLINE void find_between(const EdgeGradients<G>& from) {
  const hn::CappedTag<double, 4> d;
  const hn::Rebind<G, decltype(d)> dg;
  const auto load = [&](const G* at) HWY_ATTR {
    if constexpr (sizeof(G) == sizeof(double))
      return hn::LoadU(dg, at);
    else
      return hn::PromoteTo(d, hn::LoadU(dg, at));
  };
  const auto one = hn::Set(d, 1.0);
  for (std::size_t i = 0; i < from.n; ++i) {
    const G* const first = from.gradients + 4 * static_cast<std::size_t>(from.first[i]);
    const G* const second = from.gradients + 4 * static_cast<std::size_t>(from.second[i]);
    const auto t = hn::Set(d, from.kept[i]);
    const auto rest = hn::Sub(one, t);
    for (std::size_t k = 0; k < 4; k += hn::Lanes(d))
      hn::StoreU(hn::Add(hn::Mul(load(first + k), rest), hn::Mul(load(second + k), t)), d,
                 from.between + 4 * i + k);
  }
}

void run_normals(const double* gradients, std::size_t n, const NormalFrame& frame, Vec3f* normals,
                 const Vec3f* end) {
  const Double d;
  const Float df;
  const std::size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, 1.0);
  const auto sign = hn::Set(d, frame.sign);
  const Vector3 rows[3]{constant(frame.to_world.rows[0]), constant(frame.to_world.rows[1]),
                        constant(frame.to_world.rows[2])};
  for (std::size_t i = 0; i < n; i += lanes) {
    Vector3 gradient;
    DoubleV zero;
    hn::LoadInterleaved4(d, gradients + 4 * i, gradient.x, gradient.y, gradient.z, zero);
    const Vector3 world{dot(rows[0], gradient), dot(rows[1], gradient), dot(rows[2], gradient)};
    const auto length = hn::Sqrt(dot(world, world));
    // A gradient of 0 stays as it is.
    const auto scale = hn::IfThenElse(hn::Gt(length, hn::Zero(d)), hn::Div(one, length), one);
    const auto coordinate = [&](DoubleV a) HWY_ATTR {
      return hn::DemoteTo(df, hn::Mul(sign, hn::Mul(a, scale)));
    };
    const auto x = coordinate(world.x);
    const auto y = coordinate(world.y);
    const auto z = coordinate(world.z);
    if (normals + i + lanes <= end) {
      hn::StoreInterleaved3(x, y, z, df, normals[i].v.data());
    } else {
      float last[3 * 8];
      hn::StoreInterleaved3(x, y, z, df, last);
      std::memcpy(normals[i].v.data(), last, 3 * std::min(lanes, n - i) * sizeof(float));
    }
  }
}

void normals_f32(const EdgeGradients<float>& from, const NormalFrame& frame, Vec3f* normals,
                 const Vec3f* end) {
  find_between(from);
  run_normals(from.between, from.n, frame, normals, end);
}
void normals_f64(const EdgeGradients<double>& from, const NormalFrame& frame, Vec3f* normals,
                 const Vec3f* end) {
  find_between(from);
  run_normals(from.between, from.n, frame, normals, end);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(normals_f32);
HWY_EXPORT(normals_f64);
HWY_EXPORT(run_normals);

void place_normals(const EdgeGradients<float>& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end) {
  HWY_DYNAMIC_DISPATCH(normals_f32)(gradients, frame, normals, end);
}
void place_normals(const EdgeGradients<double>& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end) {
  HWY_DYNAMIC_DISPATCH(normals_f64)(gradients, frame, normals, end);
}

void place_normals(const double* gradients, std::size_t n, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end) {
  HWY_DYNAMIC_DISPATCH(run_normals)(gradients, n, frame, normals, end);
}

}  // namespace lode::diamond
#endif
