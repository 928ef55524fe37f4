#include "lode/render/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lode/render/color.h"

namespace lode {
namespace {

constexpr std::size_t kMaxKnots = 65536;
constexpr double kMaxLight = 1e6;
constexpr double kMaxExtinction = 1e100;
constexpr double kLeastWidth = 1e-290;  // Its inverse is still a double.

Result<void> check_knot(const TransferKnot& knot, std::size_t i) {
  if (!std::isfinite(knot.value))
    return fail("transfer function: expected finite values, knot {} has {}", i, knot.value);
  for (const double channel : knot.color.v) {
    if (!(channel >= 0 && channel <= kMaxLight))
      return fail("transfer function: expected colours from 0 to {}, knot {} has {}", kMaxLight, i,
                  channel);
  }
  if (!(knot.extinction >= 0 && knot.extinction <= kMaxExtinction))
    return fail("transfer function: expected extinctions from 0 to {}, knot {} has {}",
                kMaxExtinction, i, knot.extinction);
  return {};
}

/// A knot of a preset: where in the range, which colour, how dense over the scale's length.
struct PresetKnot {
  double fraction;
  Color color;
  double density;
};

std::vector<PresetKnot> viridis_smoke() {
  return {{0.00, {68, 1, 84}, 1.0},
          {0.25, {59, 82, 139}, 2.5},
          {0.50, {33, 145, 140}, 6},
          {0.75, {94, 201, 98}, 15},
          {1.00, {253, 231, 37}, 40}};
}

std::vector<PresetKnot> smoke() {
  return {{0.0, {250, 250, 250}, 0}, {0.3, {225, 228, 232}, 0.5}, {1.0, {60, 64, 72}, 14}};
}

std::vector<PresetKnot> solid() {
  std::vector<PresetKnot> knots;
  for (const double fraction : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0})
    knots.push_back({fraction, sequential_color(fraction), 60});
  return knots;
}

std::vector<PresetKnot> clear_middle() {
  return {{0.00, {40, 84, 170}, 18},  {0.30, {120, 168, 210}, 2}, {0.42, {220, 220, 220}, 0},
          {0.58, {220, 220, 220}, 0}, {0.70, {222, 150, 96}, 2},  {1.00, {178, 34, 40}, 18}};
}

std::vector<PresetKnot> bands() {
  constexpr double kHalfWidth = 0.018;
  const std::vector<Color> colors = distinct_colors(5);
  std::vector<PresetKnot> knots;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const double middle = 0.1 + 0.2 * static_cast<double>(i);
    knots.push_back({middle - kHalfWidth, colors[i], 0});
    knots.push_back({middle, colors[i], 90});
    knots.push_back({middle + kHalfWidth, colors[i], 0});
  }
  return knots;
}

struct Preset {
  std::string_view name;
  std::vector<PresetKnot> (*make)();
};
constexpr std::array kPresets{Preset{"viridis-smoke", viridis_smoke}, Preset{"smoke", smoke},
                              Preset{"bands", bands}, Preset{"solid", solid},
                              Preset{"clear-middle", clear_middle}};

Result<void> check_scale(const TransferScale& scale) {
  if (!std::isfinite(scale.range_min) || !std::isfinite(scale.range_max) ||
      scale.range_min > scale.range_max)
    return fail("transfer function: expected a finite range of values, got {} to {}",
                scale.range_min, scale.range_max);
  if (!(scale.length > 0 && std::isfinite(scale.length)))
    return fail("transfer function: expected a length above 0, got {}", scale.length);
  return {};
}

/// Knots that rounding makes one are left out: a field that hardly varies has one colour.
TransferFunction stretch(const std::vector<PresetKnot>& knots, const TransferScale& scale) {
  TransferFunction function;
  for (const PresetKnot& knot : knots) {
    const double value = std::lerp(scale.range_min, scale.range_max, knot.fraction);
    const Vec3d color = widened(to_linear(knot.color));
    const double extinction = std::min(knot.density / scale.length, kMaxExtinction);
    function.knots.push_back({value, color, extinction});
    if (function.knots.size() > 1 && !check_transfer_function(function)) function.knots.pop_back();
  }
  return function;
}

}  // namespace

TransferKnot TransferFunction::at(double value) const {
  const auto after = std::ranges::upper_bound(knots, value, {}, &TransferKnot::value);
  if (after == knots.begin()) return knots.front();
  if (after == knots.end()) return knots.back();
  const TransferKnot& a = *(after - 1);
  const TransferKnot& b = *after;
  const double t = (value - a.value) / (b.value - a.value);
  return {value, a.color * (1 - t) + b.color * t, a.extinction * (1 - t) + b.extinction * t};
}

Result<void> check_transfer_function(const TransferFunction& function) {
  const auto& knots = function.knots;
  if (knots.empty() || knots.size() > kMaxKnots)
    return fail("transfer function: expected 1 to {} knots, got {}", kMaxKnots, knots.size());
  for (std::size_t i = 0; i < knots.size(); ++i) LODE_CHECK(check_knot(knots[i], i));
  const double width = knots.back().value - knots.front().value;
  if (!std::isfinite(width))
    return fail("transfer function: expected values whose differences are numbers, got {} and {}",
                knots.front().value, knots.back().value);
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (!(knots[i].value - knots[i - 1].value > 1e-12 * width))
      return fail(
          "transfer function: expected ascending values, knot {} has {} after {}, where 1e-12 of "
          "their range is the least step",
          i, knots[i].value, knots[i - 1].value);
  }
  if (knots.size() > 1 && width < kLeastWidth)
    return fail("transfer function: expected values at least {} apart, got {} and {}", kLeastWidth,
                knots.front().value, knots.back().value);
  return {};
}

bool is_transfer_preset(std::string_view name) {
  return std::ranges::find(kPresets, name, &Preset::name) != kPresets.end();
}

Result<TransferFunction> transfer_preset(std::string_view name, const TransferScale& scale) {
  LODE_CHECK(check_scale(scale));
  const auto* const preset = std::ranges::find(kPresets, name, &Preset::name);
  if (preset != kPresets.end()) return stretch(preset->make(), scale);
  std::string names;
  for (const Preset& one : kPresets) names += (names.empty() ? "" : ", ") + std::string(one.name);
  return fail("transfer function: expected one of {}, got '{}'", names, name);
}

}  // namespace lode
