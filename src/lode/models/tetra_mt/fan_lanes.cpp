#include "lode/models/tetra_mt/fan.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/tetra_mt/fan_lanes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::tetra_mt::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Float = hn::CappedTag<float, 16>;
using Double = hn::CappedTag<double, 8>;
using Index = hn::RebindToSigned<Float>;
using FloatV = hn::Vec<Float>;

struct Vector3 {
  FloatV x, y, z;
};

HWY_INLINE Vector3 difference(const std::array<StarLanes::Floats, 3>& a, std::size_t i,
                              const std::array<float, 3>& b) {
  const Float d;
  return {hn::Sub(hn::LoadU(d, a[0].data() + i), hn::Set(d, b[0])),
          hn::Sub(hn::LoadU(d, a[1].data() + i), hn::Set(d, b[1])),
          hn::Sub(hn::LoadU(d, a[2].data() + i), hn::Set(d, b[2]))};
}

HWY_INLINE Vector3 cross(const Vector3& a, const Vector3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

HWY_INLINE FloatV dot(const Vector3& a, const Vector3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE Vector3 scaled(const Vector3& a, FloatV scale) {
  return {hn::Mul(a.x, scale), hn::Mul(a.y, scale), hn::Mul(a.z, scale)};
}

HWY_INLINE void store(const Vector3& a, std::size_t i, std::array<StarLanes::Floats, 3>& to) {
  const Float d;
  hn::StoreU(a.x, d, to[0].data() + i);
  hn::StoreU(a.y, d, to[1].data() + i);
  hn::StoreU(a.z, d, to[2].data() + i);
}

/// Notes in `gaps` which lanes make no positive volume, and returns how many.
HWY_INLINE std::size_t find_gaps(const StarLanes& star, const Vec3d& at, Fan& fan) {
  const Double d;
  const hn::Rebind<float, Double> df;
  const auto x = hn::Set(d, at[0]);
  const auto y = hn::Set(d, at[1]);
  const auto z = hn::Set(d, at[2]);
  std::size_t n_flat = 0;
  for (std::size_t i = 0; i < star.n; i += hn::Lanes(d)) {
    auto volume = hn::Mul(hn::LoadU(d, star.planes[0].data() + i), x);
    volume = hn::Add(volume, hn::Mul(hn::LoadU(d, star.planes[1].data() + i), y));
    volume = hn::Add(volume, hn::Mul(hn::LoadU(d, star.planes[2].data() + i), z));
    volume = hn::Sub(volume, hn::LoadU(d, star.heights.data() + i));
    const auto is_flat = hn::Not(hn::Gt(volume, hn::LoadU(d, star.slacks.data() + i)));
    n_flat += hn::CountTrue(d, is_flat);
    const auto gap = hn::IfThenElseZero(is_flat, hn::Set(d, -1e30));
    hn::StoreU(hn::DemoteTo(df, gap), df, fan.gaps.data() + i);
    const auto inverse = hn::Div(hn::Set(d, 1.0), hn::IfThenElse(is_flat, hn::Set(d, 1.0), volume));
    hn::StoreU(hn::DemoteTo(df, inverse), df, fan.inverses.data() + i);
  }
  return n_flat;
}

bool run_make(const StarLanes& star, const Vec3d& at, std::size_t n_flat, Fan& fan) {
  const Float d;
  if (find_gaps(star, at, fan) != n_flat) return false;
  for (std::size_t i = 0; i < 3; ++i) fan.at[i] = static_cast<float>(at[i]);
  for (std::size_t i = 0; i < star.n; i += hn::Lanes(d)) {
    const Vector3 a = difference(star.corners[0], i, fan.at);
    const Vector3 b = difference(star.corners[1], i, fan.at);
    const Vector3 c = difference(star.corners[2], i, fan.at);
    const auto scale = hn::LoadU(d, fan.inverses.data() + i);
    const Vector3 rows[3]{scaled(cross(b, c), scale), scaled(cross(c, a), scale),
                          scaled(cross(a, b), scale)};
    for (std::size_t k = 0; k < 3; ++k) store(rows[k], i, fan.rows[k]);
    for (std::size_t f = 0; f < star.values.size(); ++f) {
      const auto kept = hn::Set(d, fan.kept_value[f]);
      const auto rise = [&](std::size_t k) HWY_ATTR {
        return hn::Sub(hn::LoadU(d, star.values[f][k].data() + i), kept);
      };
      const Vector3 g0 = scaled(rows[0], rise(0));
      const Vector3 g1 = scaled(rows[1], rise(1));
      const Vector3 g2 = scaled(rows[2], rise(2));
      store({hn::Add(hn::Add(g0.x, g1.x), g2.x), hn::Add(hn::Add(g0.y, g1.y), g2.y),
             hn::Add(hn::Add(g0.z, g1.z), g2.z)},
            i, fan.gradients[f]);
    }
  }
  return true;
}

HWY_INLINE std::size_t locate(const Fan& fan, std::size_t n_lanes, float x, float y, float z) {
  const Float d;
  const Index di;
  const auto one = hn::Set(d, 1.0F);
  const Vector3 p{hn::Set(d, x), hn::Set(d, y), hn::Set(d, z)};
  auto best = hn::Set(d, -2e30F);
  auto best_lane = hn::Zero(di);
  for (std::size_t i = 0; i < n_lanes; i += hn::Lanes(d)) {
    const auto weight = [&](std::size_t k) HWY_ATTR {
      return dot({hn::LoadU(d, fan.rows[k][0].data() + i), hn::LoadU(d, fan.rows[k][1].data() + i),
                  hn::LoadU(d, fan.rows[k][2].data() + i)},
                 p);
    };
    const auto a = weight(0);
    const auto b = weight(1);
    const auto c = weight(2);
    const auto rest = hn::Sub(one, hn::Add(hn::Add(a, b), c));
    const auto least = hn::Min(hn::Min(hn::Min(a, b), hn::Min(c, rest)),
                               hn::Add(hn::LoadU(d, fan.gaps.data() + i), one));
    const auto is_better = hn::Gt(least, best);
    best = hn::IfThenElse(is_better, least, best);
    best_lane = hn::IfThenElse(hn::RebindMask(di, is_better),
                               hn::Iota(di, static_cast<std::int32_t>(i)), best_lane);
  }
  const auto is_best = hn::Eq(best, hn::MaxOfLanes(d, best));
  const auto first = hn::IfThenElse(hn::RebindMask(di, is_best), best_lane,
                                    hn::Set(di, static_cast<std::int32_t>(n_lanes)));
  return static_cast<std::size_t>(hn::GetLane(hn::MinOfLanes(di, first)));
}

std::size_t run_find(const Fan& fan, std::size_t n_lanes, const StarSamples& samples,
                     std::size_t sample) {
  return locate(fan, n_lanes, samples.x[sample] - fan.at[0], samples.y[sample] - fan.at[1],
                samples.z[sample] - fan.at[2]);
}

double run_cost(const Fan& fan, std::size_t n_lanes, const StarSamples& samples, double limit) {
  double sum = 0;
  for (std::size_t s = 0; s < samples.samples.size() && sum <= limit; ++s) {
    const std::size_t lane = run_find(fan, n_lanes, samples, s);
    for (std::size_t f = 0; f < samples.n_fields; ++f)
      sum += cost_of(static_cast<double>(samples.space_unit > 0 ? fan.distance(samples, s, f, lane)
                                                                : fan.error(samples, s, f, lane)));
  }
  return sum;
}

}  // namespace lode::tetra_mt::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::tetra_mt {

HWY_EXPORT(run_make);
HWY_EXPORT(run_find);
HWY_EXPORT(run_cost);

bool make_fan(const StarLanes& star, const Vec3d& at, std::size_t n_flat, Fan& fan) {
  return HWY_DYNAMIC_DISPATCH(run_make)(star, at, n_flat, fan);
}

double cost_of(const Fan& fan, std::size_t n_lanes, const StarSamples& samples, double limit) {
  return HWY_DYNAMIC_DISPATCH(run_cost)(fan, n_lanes, samples, limit);
}

std::size_t find_lane(const Fan& fan, std::size_t n_lanes, const StarSamples& samples,
                      std::size_t sample) {
  return HWY_DYNAMIC_DISPATCH(run_find)(fan, n_lanes, samples, sample);
}

}  // namespace lode::tetra_mt
#endif
