#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/lattice_field.h"

namespace lode::diamond {

/// What passes over bricks hold a sample in: float, double, or a Step, the number of steps of
/// 1/kPlanEdge that it is above the field's smallest. Of integers every interpolant is a multiple
/// of such a step at all points of a plan's cube, so that steps are exact, and twice as many as
/// floats fit in a register.
using Step = std::uint16_t;

/// Cubes whose errors are found side by side.
template <typename V>
inline constexpr std::size_t kLanesOf = std::is_same_v<V, Step> ? 2 * kLanes : kLanes;

/// Stands for a point that is no sample.
template <typename V>
inline constexpr V kNoSample = std::is_same_v<V, Step> ? std::numeric_limits<V>::max()
                                                       : std::numeric_limits<V>::quiet_NaN();

/// What the V of a field mean. C is what they are computed with where V does not hold enough.
template <int D, typename V>
struct SampleScale {
  using C = V;

  template <typename Field>
  explicit SampleScale(const LatticeField<D, Field>& /*field*/) {}
  [[nodiscard]] C value(V held) const { return held; }
  [[nodiscard]] C error(V held) const { return held; }
  template <typename T>
  [[nodiscard]] V held(T sample) const {
    return static_cast<V>(sample);
  }
};

template <int D>
struct SampleScale<D, Step> {
  using C = float;
  static constexpr C kStep = C(1) / C(kPlanEdge<D>);

  template <typename Field>
  explicit SampleScale(const LatticeField<D, Field>& field) : smallest_(field.stats.min) {}
  [[nodiscard]] C value(Step held) const {
    return static_cast<C>(smallest_) + kStep * static_cast<C>(held);
  }
  [[nodiscard]] C error(Step held) const { return kStep * static_cast<C>(held); }
  template <typename T>
  [[nodiscard]] Step held(T sample) const {
    return static_cast<Step>(
        (static_cast<std::int32_t>(sample) - static_cast<std::int32_t>(smallest_)) * kPlanEdge<D>);
  }

 private:
  double smallest_;
};

/// Whether float32 holds every interpolant exactly: multiples of 1/root side below the largest
/// value's magnitude.
template <int D, typename Field>
[[nodiscard]] bool is_exact_in_float(const LatticeField<D, Field>& field) {
  if (is_floating(field.storage)) return false;
  const double largest = std::max(std::abs(field.stats.min), std::abs(field.stats.max));
  const int bits = static_cast<int>(std::ceil(std::log2(largest + 1))) + 1;
  return bits + field.shape.n_levels <= 24;
}

/// Whether steps hold all samples, and those are numbers.
template <int D, typename Field>
[[nodiscard]] bool fits_in_steps(const LatticeField<D, Field>& field) {
  const double n_steps = (field.stats.max - field.stats.min) * double{kPlanEdge<D>};
  return is_exact_in_float(field) && !field.has_holes() && n_steps < double{kNoSample<Step>};
}

/// Calls f.template operator()<V>() with what passes over the field's bricks hold samples in.
template <int D, typename Field, typename F>
decltype(auto) visit_held_type(const LatticeField<D, Field>& field, F&& f) {
  if (fits_in_steps(field)) return f.template operator()<Step>();
  if (is_exact_in_float(field)) return f.template operator()<float>();
  return f.template operator()<double>();
}

}  // namespace lode::diamond
