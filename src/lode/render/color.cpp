#include "lode/render/color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>

namespace lode {
namespace {

struct NamedColor {
  std::string_view name;
  Color color;
};

constexpr std::array kNamedColors{
    NamedColor{"black", {0, 0, 0}},          NamedColor{"white", {255, 255, 255}},
    NamedColor{"gray", {128, 128, 128}},     NamedColor{"silver", {192, 192, 192}},
    NamedColor{"red", {200, 42, 42}},        NamedColor{"orange", {232, 120, 36}},
    NamedColor{"gold", {222, 172, 58}},      NamedColor{"yellow", {240, 214, 72}},
    NamedColor{"green", {56, 142, 78}},      NamedColor{"teal", {30, 138, 138}},
    NamedColor{"steelblue", {98, 142, 186}}, NamedColor{"blue", {42, 90, 190}},
    NamedColor{"purple", {126, 74, 160}},    NamedColor{"pink", {224, 138, 170}},
    NamedColor{"brown", {134, 88, 56}},      NamedColor{"bone", {230, 216, 192}},
    NamedColor{"clay", {200, 140, 110}},     NamedColor{"transparent", {255, 255, 255, 0}},
};

// Neighbours differ in lightness as well as in hue, so that a grey print still tells them apart.
constexpr std::array kCategories{
    Color{100, 146, 192}, Color{226, 140, 58}, Color{72, 150, 110}, Color{200, 82, 78},
    Color{148, 114, 182}, Color{222, 190, 84}, Color{118, 90, 74},  Color{92, 184, 196},
};

constexpr std::array kSequence{
    Color{52, 46, 108},  Color{50, 88, 146},  Color{38, 128, 150},
    Color{54, 164, 134}, Color{130, 196, 98}, Color{240, 224, 84},
};

constexpr std::array kElevations{
    Color{96, 146, 92},  Color{150, 178, 112}, Color{216, 204, 142}, Color{200, 162, 104},
    Color{160, 116, 82}, Color{178, 158, 144}, Color{246, 246, 244},
};

constexpr std::array kDepths{
    Color{28, 52, 102},
    Color{44, 92, 148},
    Color{84, 140, 186},
    Color{148, 192, 214},
};

std::optional<int> hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

std::optional<Color> parse_hex(std::string_view digits) {
  if (digits.size() != 3 && digits.size() != 6 && digits.size() != 8) return std::nullopt;
  std::array<std::uint8_t, 4> channels{0, 0, 0, 255};
  const std::size_t per_channel = digits.size() == 3 ? 1 : 2;
  for (std::size_t i = 0; i < digits.size(); i += per_channel) {
    const auto high = hex_digit(digits[i]);
    const auto low = hex_digit(digits[i + per_channel - 1]);
    if (!high || !low) return std::nullopt;
    channels[i / per_channel] = static_cast<std::uint8_t>(*high * 16 + *low);
  }
  return Color{channels[0], channels[1], channels[2], channels[3]};
}

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

std::string list_of_names() {
  std::string list;
  for (const NamedColor& named : kNamedColors) {
    if (!list.empty()) list += ", ";
    list += named.name;
  }
  return list;
}

std::array<float, 256> make_decode_table() {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255.0;
    table[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return table;
}

std::uint8_t encode(float linear) {
  const float c = linear > 0 ? std::min(linear, 1.0f) : 0.0f;  // NaN becomes 0.
  const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(s * 255.0f));
}

std::uint8_t mix(std::uint8_t a, std::uint8_t b, double fraction) {
  return static_cast<std::uint8_t>(std::lround(a + (b - a) * fraction));
}

/// Between neighbours, linearly.
Color color_on(std::span<const Color> colors, double fraction) {
  const double last = static_cast<double>(colors.size() - 1);
  const double position = fraction > 0 ? std::min(fraction, 1.0) * last : 0.0;
  const auto i = std::min(static_cast<std::size_t>(position), colors.size() - 2);
  const double f = position - static_cast<double>(i);
  const Color& a = colors[i];
  const Color& b = colors[i + 1];
  return {mix(a.r, b.r, f), mix(a.g, b.g, f), mix(a.b, b.b, f)};
}

}  // namespace

Result<Color> parse_color(std::string_view text) {
  if (!text.empty() && text.front() == '#') {
    if (const auto color = parse_hex(text.substr(1))) return *color;
    return fail("colour \"{}\": expected #rgb, #rrggbb or #rrggbbaa in hexadecimal", text);
  }
  for (const NamedColor& named : kNamedColors) {
    if (equals_ignoring_case(named.name, text)) return named.color;
  }
  return fail("colour \"{}\": expected #rrggbb or one of {}", text, list_of_names());
}

Vec3f to_linear(Color color) {
  static const std::array<float, 256> kTable = make_decode_table();
  return {{kTable[color.r], kTable[color.g], kTable[color.b]}};
}

Color to_srgb(const Vec3f& linear, float alpha) {
  const float a = alpha > 0 ? std::min(alpha, 1.0f) : 0.0f;
  return {encode(linear[0]), encode(linear[1]), encode(linear[2]),
          static_cast<std::uint8_t>(std::lround(a * 255.0f))};
}

Color sequential_color(double fraction) { return color_on(kSequence, fraction); }
Color elevation_color(double fraction) { return color_on(kElevations, fraction); }
Color depth_color(double fraction) { return color_on(kDepths, fraction); }

std::vector<Color> distinct_colors(std::size_t n) {
  if (n <= kCategories.size()) {
    return {kCategories.begin(), kCategories.begin() + static_cast<std::ptrdiff_t>(n)};
  }
  std::vector<Color> colors;
  colors.reserve(n);
  for (std::size_t i = 0; i < n; ++i) {
    colors.push_back(sequential_color(static_cast<double>(i) / static_cast<double>(n - 1)));
  }
  return colors;
}

}  // namespace lode
