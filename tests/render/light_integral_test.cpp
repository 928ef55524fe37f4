#include "lode/render/light_integral.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace lode::test {
namespace {

/// A stretch of a ray on which field, extinction and colour are linear.
struct Stretch {
  double near, far;  ///< Extinctions.
  Vec3d near_color, far_color;
  double length;
};

struct Light {
  Vec3d light;
  double transmittance = 1;
};

/// Halved until its optical depth is small, then by five Gauss points: far beyond 1e-9.
void add_reference(const Stretch& s, int level, Light& sum) {
  if (sum.transmittance < 1e-12) return;
  const double depth = (s.near + s.far) / 2 * s.length;
  if (depth > 0.05 && level < 60) {
    const double extinction = (s.near + s.far) / 2;
    const Vec3d color = (s.near_color + s.far_color) * 0.5;
    add_reference({s.near, extinction, s.near_color, color, s.length / 2}, level + 1, sum);
    add_reference({extinction, s.far, color, s.far_color, s.length / 2}, level + 1, sum);
    return;
  }
  constexpr std::array<double, 5> kPoints{-0.9061798459386640, -0.5384693101056831, 0,
                                          0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 5> kWeights{0.2369268850561891, 0.4786286704993665,
                                           0.5688888888888889, 0.4786286704993665,
                                           0.2369268850561891};
  for (std::size_t i = 0; i < 5; ++i) {
    const double x = (1 + kPoints[i]) / 2;
    const double extinction = s.near + (s.far - s.near) * x;
    const double before = (s.near + extinction) / 2 * x * s.length;
    const Vec3d color = s.near_color * (1 - x) + s.far_color * x;
    sum.light = sum.light + color * (sum.transmittance * std::exp(-before) * extinction * s.length *
                                     kWeights[i] / 2);
  }
  sum.transmittance *= std::exp(-depth);
}

/// Cut at all knots by brute force.
void add_reference(const TransferFunction& f, double from, double to, double length, Light& sum) {
  std::vector<double> cuts{0, 1};
  for (const TransferKnot& knot : f.knots) {
    const double t = (knot.value - from) / (to - from);
    if (t > 0 && t < 1) cuts.push_back(t);
  }
  std::ranges::sort(cuts);
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const auto at = [&](double t) { return f.at(from + (to - from) * t); };
    // Just inside, so that steps at almost one value are on the right side of the cut.
    const double inset = (cuts[i] - cuts[i - 1]) * 1e-9;
    const TransferKnot a = at(cuts[i - 1] + inset);
    const TransferKnot b = at(cuts[i] - inset);
    add_reference({a.extinction, b.extinction, a.color, b.color, length * (cuts[i] - cuts[i - 1])},
                  0, sum);
  }
}

/// The largest difference of light or transmittance along a ray of segments between `values`.
double difference(const TransferFunction& f, const std::vector<double>& values,
                  const std::vector<double>& lengths) {
  const LightRamps ramps(f);
  LightIntegral integral;
  Light reference;
  integral.start(ramps, ramps.level(values.front()));
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    integral.add(ramps.level(values[i]), ramps.level(values[i + 1]), lengths[i]);
    add_reference(f, values[i], values[i + 1], lengths[i], reference);
    if (integral.is_opaque()) break;
  }
  if (integral.is_opaque()) {
    EXPECT_LT(reference.transmittance, 1e-4);
  }
  double worst = std::abs(integral.transmittance() - reference.transmittance);
  for (std::size_t c = 0; c < 3; ++c)
    worst = std::max(worst, std::abs(integral.light()[c] - reference.light[c]));
  return worst;
}

/// Segments from hardly anything to opaque, functions from smooth to steps, seeded.
double worst_of_random_rays(double steepness, double thickness) {
  std::mt19937_64 random(20261124);
  std::uniform_real_distribution<double> unit(0, 1);
  double worst = 0;
  for (int ray = 0; ray < 200; ++ray) {
    TransferFunction f;
    double value = 100;
    const int n_knots = 2 + static_cast<int>(unit(random) * 8);
    for (int i = 0; i < n_knots; ++i) {
      const bool is_clear = unit(random) < 0.3;
      f.knots.push_back({value,
                         {{unit(random), unit(random), unit(random)}},
                         is_clear ? 0 : std::pow(10, 4 * unit(random) - 2)});
      value += unit(random) < 0.5 ? 1e-4 + unit(random) : steepness;
    }
    const double low = 99.5;
    std::vector<double> values{low};
    std::vector<double> lengths;
    for (int i = 0; i < 30; ++i) {
      const bool is_jump = unit(random) < 0.3;
      values.push_back(is_jump ? low + unit(random) * (value + 0.5 - low)
                               : values.back() + (unit(random) - 0.5) * 0.1);
      lengths.push_back(thickness * unit(random));
    }
    worst = std::max(worst, difference(f, values, lengths));
  }
  return worst;
}

TEST(light_integral, is_within_1e4_of_quadrature_on_random_rays) {
  for (const double steepness : {0.1, 1e-6})
    for (const double thickness : {1e-4, 0.01, 0.1, 3.0, 1e4})
      EXPECT_LT(worst_of_random_rays(steepness, thickness), 5e-5)
          << "steepness " << steepness << " thickness " << thickness;
}

TEST(light_integral, is_within_1e4_where_extinction_starts_or_ends_at_nothing) {
  for (const double depth : {1e-3, 0.03, 0.032, 0.1, 0.299, 0.3, 0.301, 1.0, 7.0, 1e3, 1e9}) {
    const TransferFunction up{{{0, {{0, 1, 0.5}}, 0}, {1, {{1, 0, 0.5}}, 2 * depth}}};
    EXPECT_LT(difference(up, {0, 1}, {1}), 4e-5) << depth;
    EXPECT_LT(difference(up, {1, 0}, {1}), 4e-5) << depth;
  }
}

TEST(light_integral, of_one_color_is_that_color_times_what_is_absorbed) {
  const TransferFunction f{{{5, {{0.25, 0.5, 1}}, 3}}};
  const LightRamps ramps(f);
  for (const double length : {0.0, 1e-9, 0.01, 0.5, 2.0}) {
    LightIntegral integral;
    integral.start(ramps, ramps.level(-7));
    integral.add(ramps.level(-7), ramps.level(12), length);
    EXPECT_NEAR(integral.transmittance(), std::exp(-3 * length), 1e-7);
    EXPECT_NEAR(integral.light()[2], 1 - std::exp(-3 * length), 1e-7);
    EXPECT_NEAR(integral.light()[0], 0.25 * integral.light()[2], 1e-12);
  }
}

TEST(light_integral, adds_nothing_without_length_or_extinction) {
  const TransferFunction f{{{0, {{1, 1, 1}}, 0}, {1, {{1, 1, 1}}, 0}, {2, {{1, 1, 1}}, 1e6}}};
  const LightRamps ramps(f);
  LightIntegral integral;
  integral.start(ramps, ramps.level(0));
  integral.add(ramps.level(0), ramps.level(1), 1e6);
  integral.add(ramps.level(1), ramps.level(5), 0);
  integral.add(ramps.level(5), ramps.level(-5), 0);
  EXPECT_EQ(integral.transmittance(), 1);
  EXPECT_EQ(integral.light(), (Vec3d{{0, 0, 0}}));
}

}  // namespace
}  // namespace lode::test
