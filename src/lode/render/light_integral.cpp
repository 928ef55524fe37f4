#include "lode/render/light_integral.h"

namespace lode {

LightRamps::LightRamps(const TransferFunction& function) : first_(function.knots.front().value) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto& knots = function.knots;
  const double width = knots.back().value - first_;
  scale_ = width > 0 && std::isfinite(1 / width) ? 1 / width : 1;
  ramps_.reserve(knots.size() + 1);
  const auto add_constant = [&](const TransferKnot& knot, double lower, double upper) {
    const double origin = level(knot.value);
    ramps_.push_back({lower, upper, origin, knot.extinction, 0, knot.color, {}});
  };
  add_constant(knots.front(), -kInfinity, 0);
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const TransferKnot& a = knots[i - 1];
    const TransferKnot& b = knots[i];
    const double lower = level(a.value);
    const double upper = level(b.value);
    const double slope = 1 / (upper - lower);
    ramps_.push_back({lower, upper, lower, a.extinction, (b.extinction - a.extinction) * slope,
                      a.color, (b.color - a.color) * slope});
  }
  add_constant(knots.back(), level(knots.back().value), kInfinity);
}

const LightRamp* LightRamps::at(double level) const {
  const auto after = std::ranges::lower_bound(ramps_, level, {}, &LightRamp::upper);
  return after == ramps_.end() ? &ramps_.back() : &*after;
}

void LightIntegral::step_ramp(std::ptrdiff_t by) {
  state_.light = light();
  state_.weight = state_.level_weight = 0;
  state_.ramp += by;
}

// Slices of an optical depth of kThin each; the last has what is left.
void LightIntegral::add_thick(double near, double far, double h0, double h1, double length) {
  const double rise = (far - near) / length;
  double left = length;
  double extinction = near;
  for (double from = h0; !is_opaque();) {
    const double depth = 0.5 * (extinction + far) * left;
    if (!(depth > kThin)) return add_thin(depth, 0.5 * (far - extinction) * left, from, h1);
    const double root = std::sqrt(std::max(0.0, extinction * extinction + 2 * rise * kThin));
    const double step = std::min(left, 2 * kThin / (extinction + root));
    const double next = std::max(0.0, extinction + rise * step);
    const double to = from + (h1 - from) * (step / left);
    add_thin(kThin, 0.5 * (next - extinction) * step, from, to);
    left -= step;
    extinction = next;
    from = to;
  }
}

void LightIntegral::add_across_knots(double from, double to, double length) {
  const double whole = to - from;  // Not zero: only one of its ends is on the ramp.
  while (to > state_.ramp->upper || to < state_.ramp->lower) {
    const bool is_up = to > state_.ramp->upper;
    const double cut =
        is_up ? std::max(from, state_.ramp->upper) : std::min(from, state_.ramp->lower);
    add_piece(from, cut, length * ((cut - from) / whole));
    step_ramp(is_up ? 1 : -1);
    from = cut;
    if (is_opaque()) return;
  }
  add_piece(from, to, length * ((to - from) / whole));
}

}  // namespace lode
