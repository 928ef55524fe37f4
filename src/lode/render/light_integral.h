#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "lode/render/transfer_function.h"

namespace lode {

/// Between two knots: extinction and colour are linear in h = level - origin.
struct LightRamp {
  double lower;  ///< Levels; infinite beyond the first and the last knot.
  double upper;
  double origin;
  double extinction;
  double extinction_slope;
  Vec3d color;
  Vec3d color_slope;
};

/// A transfer function made ready for integrals. Fields are mapped to levels first: 0 at the first
/// knot, 1 at the last, linearly, so that steep ramps keep their digits.
class LightRamps {
 public:
  /// Precondition: check_transfer_function(function) holds.
  explicit LightRamps(const TransferFunction& function);

  /// Far beyond the knots it is cut, so that differences of levels are numbers.
  [[nodiscard]] double level(double value) const {
    return std::clamp((value - first_) * scale_, -1e100, 1e100);
  }
  /// The ramp that a level is on; of two, any.
  [[nodiscard]] const LightRamp* at(double level) const;

 private:
  double first_;
  double scale_;
  std::vector<LightRamp> ramps_;
};

/// Emission and absorption along a ray from the eye away, piece by piece: with q the optical depth
/// so far, the integral of exp(-q) dq · colour. Within 1e-4 of the exact one for colours up to 1,
/// what is left out behind kOpaque included.
///
/// On a piece of length 1 on one ramp q(x) = t x + b (x^2 - x), with t its whole optical depth
/// and b half the difference of extinctions, |b| <= t. By parts the ends' colours have weights 1 -
/// M and M - exp(-t), M the integral of exp(-q). Of exp(b (x - x^2)) terms to b^3 are kept, of
/// exp(-t x) those to t^6; pieces with t > 0.3 are cut, so M is off by less than 1e-5 t.
class LightIntegral {
 public:
  /// Behind less than this nothing is added any more.
  static constexpr double kOpaque = 2e-5;
  /// Pieces of more optical depth are cut.
  static constexpr double kThin = 0.3;

  struct State {
    double transmittance = 1;
    double weight = 0;        ///< Of what was added on the ramp.
    double level_weight = 0;  ///< The same, times h.
    Vec3d light;              ///< Of the ramps before.
    const LightRamp* ramp = nullptr;
  };

  LightIntegral() = default;
  explicit LightIntegral(const State& state) : state_(state) {}
  [[nodiscard]] const State& state() const { return state_; }

  void start(const LightRamps& ramps, double level) {
    state_.light = light();
    state_.weight = state_.level_weight = 0;
    state_.ramp = ramps.at(level);
  }
  /// `from` and `to`: levels at the ends of a segment on which the field is linear, `length` in
  /// world units. `from`: the level of start(), then the `to` before.
  void add(double from, double to, double length) {
    if (to >= state_.ramp->lower && to <= state_.ramp->upper) {
      add_piece(from, to, length);
    } else {
      add_across_knots(from, to, length);
    }
  }
  [[nodiscard]] double transmittance() const { return state_.transmittance; }
  [[nodiscard]] bool is_opaque() const { return state_.transmittance < kOpaque; }
  /// Linear light.
  [[nodiscard]] Vec3d light() const {
    return state_.ramp == nullptr ? state_.light
                                  : state_.light + state_.ramp->color * state_.weight +
                                        state_.ramp->color_slope * state_.level_weight;
  }

 private:
  void add_piece(double from, double to, double length) {
    const double h0 = from - state_.ramp->origin;
    const double h1 = to - state_.ramp->origin;
    const double near = std::max(0.0, state_.ramp->extinction + state_.ramp->extinction_slope * h0);
    const double far = std::max(0.0, state_.ramp->extinction + state_.ramp->extinction_slope * h1);
    const double depth = 0.5 * (near + far) * length;
    if (depth > kThin) {
      add_thick(near, far, h0, h1, length);
    } else {
      add_thin(depth, 0.5 * (far - near) * length, h0, h1);
    }
  }

  void add_thin(double t, double b, double h0, double h1) {
    const double mean =  // Of exp(-t x).
        1 - t * (1.0 / 2 - t * (1.0 / 6 - t * (1.0 / 24 - t * (1.0 / 120 - t * (1.0 / 720)))));
    const double first = 1.0 / 6 - t * (1.0 / 12 - t * (1.0 / 40 - t * (1.0 / 180)));
    const double second = 1.0 / 60 - t * (1.0 / 120 - t * (1.0 / 420));
    const double m = mean + b * (first + b * (second + b * (1.0 / 840)));
    add_weights(t * mean, 1 - m, h0, h1);
  }

  void add_weights(double absorbed, double near_weight, double h0, double h1) {
    const double shone = state_.transmittance * absorbed;
    state_.level_weight += shone * h1 + state_.transmittance * near_weight * (h0 - h1);
    state_.weight += shone;
    state_.transmittance -= shone;
  }

  [[gnu::noinline]] void add_thick(double near, double far, double h0, double h1, double length);
  [[gnu::noinline]] void add_across_knots(double from, double to, double length);
  void step_ramp(std::ptrdiff_t by);

  State state_;
};

}  // namespace lode
