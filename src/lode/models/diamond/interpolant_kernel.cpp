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
using LaneTag = hn::CappedTag<C, kLanesOf<C>>;

/// Where a plan's point is; its places are those in arrays of kLanes values a point.
template <typename C>
constexpr std::size_t place_of(std::uint16_t point) {
  return std::size_t{point} * (kLanesOf<C> / kLanes);
}

template <typename V>
V mean_of(LaneTag<Step> /*d*/, V a, V b) {
  return hn::AverageRound(a, b);  // the sum is even
}
template <typename Tag, typename V>
V mean_of(Tag d, V a, V b) {
  return hn::Mul(hn::Add(a, b), hn::Set(d, hn::TFromD<Tag>(0.5)));
}

template <typename C>
void interpolate(const InterpolantPass& pass, const InterpolantArrays<C>& arrays) {
  const LaneTag<C> d;
  const std::size_t step = hn::Lanes(d);
  for (const std::uint16_t v : pass.vertices)
    for (std::size_t l = 0; l < kLanesOf<C>; l += step) {
      const std::size_t at = place_of<C>(v) + l;
      hn::Store(hn::Load(d, arrays.vertices + at), d, arrays.values + at);
    }
  for (const InterpolantPass::Mean& mean : pass.means)
    for (std::size_t l = 0; l < kLanesOf<C>; l += step) {
      const auto a = hn::Load(d, arrays.values + place_of<C>(mean.first) + l);
      const auto b = hn::Load(d, arrays.values + place_of<C>(mean.second) + l);
      hn::Store(mean_of(d, a, b), d, arrays.values + place_of<C>(mean.to) + l);
    }
}

template <Gaps kGaps, typename V>
V larger_error(LaneTag<Step> d, V sample, V value, V largest) {
  auto error = hn::Sub(hn::Max(sample, value), hn::Min(sample, value));
  if constexpr (kGaps != Gaps::none)
    error = hn::IfThenZeroElse(hn::Eq(sample, hn::Set(d, kNoSample<Step>)), error);
  return hn::Max(error, largest);
}

template <Gaps kGaps, typename Tag, typename V>
V larger_error(Tag d, V sample, V value, V largest) {
  using C = hn::TFromD<Tag>;
  auto error = hn::Abs(hn::Sub(sample, value));
  if constexpr (kGaps == Gaps::none) return hn::Max(error, largest);
  if constexpr (kGaps == Gaps::holes) {
    const auto infinity = hn::Set(d, std::numeric_limits<C>::infinity());
    const auto at_hole = hn::IfThenZeroElse(hn::Eq(sample, infinity), infinity);
    error = hn::IfThenElse(hn::IsNaN(value), at_hole, error);
    error = hn::IfThenElse(hn::IsNaN(sample), hn::Zero(d), error);
  }
  // A comparison with NaN is false: points that must not count do not.
  return hn::IfThenElse(hn::Gt(error, largest), error, largest);
}

template <Gaps kGaps, typename C>
void largest_errors(const InterpolantPass& pass, const InterpolantArrays<C>& arrays, C* out) {
  const LaneTag<C> d;
  const std::size_t step = hn::Lanes(d);
  const auto raised = [&](std::uint16_t point, std::size_t l, auto largest) {
    const std::size_t at = place_of<C>(point) + l;
    return larger_error<kGaps>(d, hn::Load(d, arrays.samples + at), hn::Load(d, arrays.values + at),
                               largest);
  };
  for (std::size_t r = 0; r < pass.regions.size(); ++r) {
    const std::uint16_t* point = pass.points.data() + pass.regions[r].begin;
    const std::size_t n = pass.regions[r].end - pass.regions[r].begin;
    for (std::size_t l = 0; l < kLanesOf<C>; l += step) {
      auto first = hn::Zero(d);  // two chains of maxima: each alone would wait for itself
      auto second = hn::Zero(d);
      std::size_t i = 0;
      for (; i + 1 < n; i += 2) {
        first = raised(point[i], l, first);
        second = raised(point[i + 1], l, second);
      }
      if (i < n) first = raised(point[i], l, first);
      hn::Store(hn::Max(first, second), d, out + r * kLanesOf<C> + l);
    }
  }
}

void widen(const Step* from, std::size_t n_points, float smallest, float size, float* to) {
  const hn::CappedTag<float, kLanes> d;
  const hn::RebindToSigned<decltype(d)> wide;
  const hn::Rebind<Step, decltype(d)> narrow;
  const auto none = hn::Set(wide, kNoSample<Step>);
  const auto nan = hn::Set(d, kNoSample<float>);
  for (std::size_t p = 0; p < n_points; ++p, from += kLanesOf<Step>, to += kLanes)
    for (std::size_t l = 0; l < kLanes; l += hn::Lanes(d)) {
      const auto steps = hn::PromoteTo(wide, hn::LoadU(narrow, from + l));
      // Both are exact.
      const auto value =
          hn::Add(hn::Set(d, smallest), hn::Mul(hn::Set(d, size), hn::ConvertTo(d, steps)));
      hn::Store(hn::IfThenElse(hn::RebindMask(d, hn::Eq(steps, none)), nan, value), d, to + l);
    }
}

/// One interpolant of run_linear on one simplex and the lanes from l on: value at the origin and
/// the change per step along each edge of the chain.
template <typename Tag, int D>
class LinearPiece {
 public:
  using C = hn::TFromD<Tag>;
  using V = hn::Vec<Tag>;

  LinearPiece(Tag d, const C* corners, const KuhnSimplex<D>& simplex, std::size_t l)
      : corners_(corners + l), d_(d), simplex_(simplex) {}

  [[nodiscard]] V slope(std::size_t edge) const {
    const auto difference = hn::Sub(at(edge + 1), at(edge));
    return hn::Mul(difference, hn::Set(d_, C(1) / C(kPlanEdge<D>)));
  }
  [[nodiscard]] V first_of(const typename KuhnSimplex<D>::Row& row) const {
    auto value = at(0);
    for (std::size_t j = 0; j < static_cast<std::size_t>(D); ++j)
      value = hn::Add(value, hn::Mul(slope(j), hn::Set(d_, static_cast<C>(row.u[j]))));
    return value;
  }

 private:
  [[nodiscard]] V at(std::size_t chain) const {
    return hn::Load(d_, corners_ + simplex_.corner[chain] * kLanes);
  }

  const C* corners_;
  Tag d_;
  const KuhnSimplex<D>& simplex_;
};

template <Gaps kGaps, int D, typename C>
void linear_errors(const std::vector<KuhnSimplex<D>>& kuhn, const LinearArrays<C>& arrays) {
  const hn::CappedTag<C, kLanes> d;
  using Piece = LinearPiece<hn::CappedTag<C, kLanes>, D>;
  for (std::size_t s = 0; s < kuhn.size(); ++s) {
    const KuhnSimplex<D>& simplex = kuhn[s];
    for (std::size_t l = 0; l < kLanes; l += hn::Lanes(d)) {
      const Piece a(d, arrays.corners[0], simplex, l);
      const Piece b(d, arrays.corners[1], simplex, l);
      const Piece c(d, arrays.corners[2], simplex, l);
      const auto a_step = a.slope(0);
      const auto b_step = b.slope(0);
      const auto c_step = c.slope(0);
      auto a_largest = hn::Zero(d);
      auto b_largest = hn::Zero(d);
      auto c_largest = hn::Zero(d);
      for (const auto& row : simplex.rows) {
        auto a_value = a.first_of(row);
        auto b_value = b.first_of(row);
        auto c_value = c.first_of(row);
        const C* sample = arrays.samples + row.first + l;
        for (std::size_t i = 0; i < row.n; ++i, sample += simplex.step) {
          const auto v = hn::Load(d, sample);
          a_largest = larger_error<kGaps>(d, v, a_value, a_largest);
          b_largest = larger_error<kGaps>(d, v, b_value, b_largest);
          c_largest = larger_error<kGaps>(d, v, c_value, c_largest);
          a_value = hn::Add(a_value, a_step);
          b_value = hn::Add(b_value, b_step);
          c_value = hn::Add(c_value, c_step);
        }
      }
      hn::Store(a_largest, d, arrays.errors[0] + s * kLanes + l);
      hn::Store(b_largest, d, arrays.errors[1] + s * kLanes + l);
      hn::Store(c_largest, d, arrays.errors[2] + s * kLanes + l);
    }
  }
}

template <typename C>
void run(const InterpolantPass& pass, const InterpolantArrays<C>& arrays, Gaps gaps, C* out) {
  interpolate(pass, arrays);
  switch (gaps) {
    case Gaps::none: return largest_errors<Gaps::none>(pass, arrays, out);
    case Gaps::beyond_data: return largest_errors<Gaps::beyond_data>(pass, arrays, out);
    case Gaps::holes: return largest_errors<Gaps::holes>(pass, arrays, out);
  }
}

void run_step(const InterpolantPass& pass, const InterpolantArrays<Step>& arrays, Gaps gaps,
              Step* out) {
  interpolate(pass, arrays);
  if (gaps == Gaps::none)
    largest_errors<Gaps::none>(pass, arrays, out);
  else
    largest_errors<Gaps::beyond_data>(pass, arrays, out);
}

void run_float(const InterpolantPass& pass, const InterpolantArrays<float>& arrays, Gaps gaps,
               float* out) {
  run(pass, arrays, gaps, out);
}

void run_double(const InterpolantPass& pass, const InterpolantArrays<double>& arrays, Gaps gaps,
                double* out) {
  run(pass, arrays, gaps, out);
}

template <int D, typename C>
void run_linear_as(const std::vector<KuhnSimplex<D>>& kuhn, const LinearArrays<C>& arrays,
                   Gaps gaps) {
  if (gaps == Gaps::none)
    linear_errors<Gaps::none>(kuhn, arrays);
  else
    linear_errors<Gaps::beyond_data>(kuhn, arrays);
}

// Highway exports functions, not templates.
void run_linear_2_float(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<float>& arrays,
                        Gaps gaps) {
  run_linear_as(kuhn, arrays, gaps);
}

void run_linear_3_float(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<float>& arrays,
                        Gaps gaps) {
  run_linear_as(kuhn, arrays, gaps);
}

void run_linear_2_double(const std::vector<KuhnSimplex<2>>& kuhn,
                         const LinearArrays<double>& arrays, Gaps gaps) {
  run_linear_as(kuhn, arrays, gaps);
}

void run_linear_3_double(const std::vector<KuhnSimplex<3>>& kuhn,
                         const LinearArrays<double>& arrays, Gaps gaps) {
  run_linear_as(kuhn, arrays, gaps);
}

}  // namespace lode::diamond::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::diamond {

HWY_EXPORT(widen);
HWY_EXPORT(run_step);
HWY_EXPORT(run_float);
HWY_EXPORT(run_double);
HWY_EXPORT(run_linear_2_float);
HWY_EXPORT(run_linear_3_float);
HWY_EXPORT(run_linear_2_double);
HWY_EXPORT(run_linear_3_double);

void widen_lanes(const Step* from, std::size_t n_points, float smallest, float size, float* to) {
  HWY_DYNAMIC_DISPATCH(widen)(from, n_points, smallest, size, to);
}

void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<Step>& arrays, Gaps gaps,
                     Step* out) {
  HWY_DYNAMIC_DISPATCH(run_step)(pass, arrays, gaps, out);
}

void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<float>& arrays, Gaps gaps,
                     float* out) {
  HWY_DYNAMIC_DISPATCH(run_float)(pass, arrays, gaps, out);
}

void run_interpolant(const InterpolantPass& pass, const InterpolantArrays<double>& arrays,
                     Gaps gaps, double* out) {
  HWY_DYNAMIC_DISPATCH(run_double)(pass, arrays, gaps, out);
}

void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<float>& arrays,
                Gaps gaps) {
  HWY_DYNAMIC_DISPATCH(run_linear_2_float)(kuhn, arrays, gaps);
}

void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<float>& arrays,
                Gaps gaps) {
  HWY_DYNAMIC_DISPATCH(run_linear_3_float)(kuhn, arrays, gaps);
}

void run_linear(const std::vector<KuhnSimplex<2>>& kuhn, const LinearArrays<double>& arrays,
                Gaps gaps) {
  HWY_DYNAMIC_DISPATCH(run_linear_2_double)(kuhn, arrays, gaps);
}

void run_linear(const std::vector<KuhnSimplex<3>>& kuhn, const LinearArrays<double>& arrays,
                Gaps gaps) {
  HWY_DYNAMIC_DISPATCH(run_linear_3_double)(kuhn, arrays, gaps);
}

}  // namespace lode::diamond
#endif
