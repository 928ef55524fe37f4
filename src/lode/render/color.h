#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// A colour as files and screens hold it: 8-bit sRGB with straight (not premultiplied) alpha.
struct Color {
  std::uint8_t r = 0;
  std::uint8_t g = 0;
  std::uint8_t b = 0;
  std::uint8_t a = 255;

  friend constexpr bool operator==(const Color&, const Color&) = default;
};

/// Reads "#rgb", "#rrggbb", "#rrggbbaa" or a name ("white", "steelblue", "transparent", ...; any
/// case). The error lists the names.
[[nodiscard]] Result<Color> parse_color(std::string_view text);

/// Linear light, 0..1 per channel; alpha is dropped.
[[nodiscard]] Vec3f to_linear(Color color);
/// The nearest 8-bit sRGB colour; channels outside 0..1 are clamped.
[[nodiscard]] Color to_srgb(const Vec3f& linear, float alpha = 1.0f);

/// `n` colours that are told apart at a glance, also by most colour-blind readers: a categorical
/// set up to 8, steps of sequential_color beyond.
[[nodiscard]] std::vector<Color> distinct_colors(std::size_t n);
/// A map of rising lightness, dark blue over teal to yellow; `fraction` is clamped to 0..1.
[[nodiscard]] Color sequential_color(double fraction);
/// Hypsometric tints: of land from the shore up, green over ochre and brown to white; of water from
/// its greatest depth up, dark to light blue. `fraction` likewise.
[[nodiscard]] Color elevation_color(double fraction);
[[nodiscard]] Color depth_color(double fraction);

}  // namespace lode
