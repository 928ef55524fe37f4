#include "lode/models/diamond/interpolant_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/diamond/interpolant_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace lode::diamond::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <typename C>
void interpolate(const InterpolantPass& pass, const InterpolantArrays<C>& arrays) {
  const hn::CappedTag<C, kLanes> d;
  const std::size_t step = hn::Lanes(d);
  const auto half = hn::Set(d, C(0.5));
  for (const std::uint16_t v : pass.vertices)
    for (std::size_t l = 0; l < kLanes; l += step)
      hn::Store(hn::Load(d, arrays.vertices + v * kLanes + l), d, arrays.values + v * kLanes + l);
  for (const InterpolantPass::Mean& mean : pass.means)
    for (std::size_t l = 0; l < kLanes; l += step) {
      const auto a = hn::Load(d, arrays.values + mean.first * kLanes + l);
      const auto b = hn::Load(d, arrays.values + mean.second * kLanes + l);
      hn::Store(hn::Mul(hn::Add(a, b), half), d, arrays.values + mean.to * kLanes + l);
    }
}

template <Holes kHoles, typename C>
void largest_errors(const InterpolantPass& pass, const InterpolantArrays<C>& arrays, C* out) {
  const hn::CappedTag<C, kLanes> d;
  const std::size_t step = hn::Lanes(d);
  const auto zero = hn::Zero(d);
  const auto infinity = hn::Set(d, std::numeric_limits<C>::infinity());
  for (std::size_t r = 0; r < pass.regions.size(); ++r) {
    const InterpolantPass::Region& region = pass.regions[r];
    for (std::size_t l = 0; l < kLanes; l += step) {
      auto largest = zero;
      for (std::uint32_t i = region.begin; i < region.end; ++i) {
        const std::size_t at = pass.points[i] * kLanes + l;
        const auto sample = hn::Load(d, arrays.samples + at);
        const auto value = hn::Load(d, arrays.values + at);
        auto error = hn::Abs(hn::Sub(sample, value));
        if constexpr (kHoles == Holes::present) {
          error = hn::IfThenElse(hn::IsNaN(value), infinity, error);
          error = hn::IfThenElse(hn::IsNaN(sample), zero, error);
        }
        // A comparison with NaN is false: points that must not count do not.
        largest = hn::IfThenElse(hn::Gt(error, largest), error, largest);
      }
      hn::Store(largest, d, out + r * kLanes + l);
    }
  }
}

template <typename C>
void run(const InterpolantPass& pass, const InterpolantArrays<C>& arrays, Holes holes, C* out) {
  interpolate(pass, arrays);
  if (holes == Holes::present)
    largest_errors<Holes::present>(pass, arrays, out);
  else
    largest_errors<Holes::absent>(pass, arrays, out);
}

void run_float(const InterpolantPass& pass, const InterpolantArrays<float>& arrays, Holes holes,
               float* out) {
  run(pass, arrays, holes, out);
}

void run_double(const InterpolantPass& pass, const InterpolantArrays<double>& arrays, Holes holes,
                double* out) {
  run(pass, arrays, holes, out);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(run_float);
HWY_EXPORT(run_double);

void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<float>& arrays,
                     Holes holes, float* out) {
  HWY_DYNAMIC_DISPATCH(run_float)(pass, arrays, holes, out);
}

void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<double>& arrays,
                     Holes holes, double* out) {
  HWY_DYNAMIC_DISPATCH(run_double)(pass, arrays, holes, out);
}

}  // namespace lode::diamond
#endif
