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

void run_normals(const EdgeGradients& from, const NormalFrame& frame, Vec3f* normals,
                 const Vec3f* end) {
  const Double d;
  const Float df;
  const std::size_t lanes = hn::Lanes(d);
  const auto one = hn::Set(d, 1.0);
  const auto sign = hn::Set(d, frame.sign);
  const Vector3 rows[3]{constant(frame.to_world.rows[0]), constant(frame.to_world.rows[1]),
                        constant(frame.to_world.rows[2])};
  for (std::size_t i = 0; i < from.n; i += lanes) {
    const auto t = hn::LoadU(d, from.kept + i);
    const auto rest = hn::Sub(one, t);
    const auto between = [&](std::size_t axis) HWY_ATTR {
      return hn::Add(hn::Mul(hn::LoadU(d, from.first[axis] + i), rest),
                     hn::Mul(hn::LoadU(d, from.second[axis] + i), t));
    };
    const Vector3 gradient{between(0), between(1), between(2)};
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
      std::memcpy(normals[i].v.data(), last, 3 * std::min(lanes, from.n - i) * sizeof(float));
    }
  }
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(run_normals);

void place_normals(const EdgeGradients& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end) {
  HWY_DYNAMIC_DISPATCH(run_normals)(gradients, frame, normals, end);
}

}  // namespace lode::diamond
#endif
