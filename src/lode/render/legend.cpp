#include "lode/render/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "lode/render/lettering.h"

namespace lode {
namespace {

constexpr Color kDark{32, 36, 44};
constexpr Color kLight{240, 243, 247};

Color& pixel_of(Image& image, int x, int y) {
  return image.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                      static_cast<std::size_t>(x)];
}

/// Dark where it is light, and light where it is dark.
Color contrast_to(const Image& image, int left, int top, int right, int bottom) {
  constexpr double kMiddle = 128;
  double sum = 0;
  double n = 0;
  for (int y = std::max(top, 0); y < std::min(bottom, image.height); ++y)
    for (int x = std::max(left, 0); x < std::min(right, image.width); ++x) {
      const Color& at = image.at(x, y);
      // Luma, of what shows through taken for white.
      const double luma = 0.299 * at.r + 0.587 * at.g + 0.114 * at.b;
      sum += 255 + (luma - 255) * at.a / 255;
      n += 1;
    }
  return n > 0 && sum / n < kMiddle ? kLight : kDark;
}

/// Where all of it goes, pixels.
struct Layout {
  int bar_left;
  int bar_right;
  int bar_top;
  int bar_bottom;
  int gap;
};

Layout layout_of(const Image& image, int letter) {
  const int right = image.width - 2 * letter;
  const int width = std::max(letter * 5 / 4, 8);
  return {right - width, right, image.height * 3 / 10, image.height * 8 / 10, letter / 2};
}

void draw_bar(const Legend& legend, const Layout& at, Color outline, Image& image) {
  for (int y = at.bar_top; y < at.bar_bottom; ++y) {
    const double up = (at.bar_bottom - y - 0.5) / (at.bar_bottom - at.bar_top);
    Color color = legend.color(legend.low + up * (legend.high - legend.low));
    color.a = 255;
    for (int x = at.bar_left; x < at.bar_right; ++x) pixel_of(image, x, y) = color;
  }
  for (int x = at.bar_left - 1; x <= at.bar_right; ++x) {
    blend(outline, 1, pixel_of(image, x, at.bar_top - 1));
    blend(outline, 1, pixel_of(image, x, at.bar_bottom));
  }
  for (int y = at.bar_top; y < at.bar_bottom; ++y) {
    blend(outline, 1, pixel_of(image, at.bar_left - 1, y));
    blend(outline, 1, pixel_of(image, at.bar_right, y));
  }
}

/// With as many digits as tell one from the next.
std::vector<std::string> texts_of(const std::vector<double>& values) {
  constexpr int kFewest = 1;
  constexpr int kMost = 17;
  const double largest =
      values.empty() ? 0 : std::max(std::abs(values.front()), std::abs(values.back()));
  const double step = values.size() > 1 ? values[1] - values[0] : 0;
  const int digits =
      step > 0 ? std::clamp(static_cast<int>(std::ceil(std::log10(largest / step) - 1e-9)) + 1,
                            kFewest, kMost)
               : 6;
  // Long numbers whole, as far as they are read.
  constexpr int kReadable = 7;
  std::vector<std::string> texts;
  texts.reserve(values.size());
  for (const double value : values)
    texts.push_back(fmt::format("{:.{}g}", value, std::max(digits, kReadable)));
  return texts;
}

/// The text, cut off where it is wider than there is room.
std::string fitted(const Lettering& letters, std::string text, int room) {
  if (letters.width(text) <= room) return text;
  const std::string end = "...";
  while (!text.empty() && letters.width(text + end) > room) {
    // Whole characters of UTF-8.
    while (text.size() > 1 && (static_cast<unsigned char>(text.back()) & 0xC0U) == 0x80)
      text.pop_back();
    text.pop_back();
  }
  return text + end;
}

/// In a colour that stands out from what is there.
void write(const Lettering& letters, const std::string& text, int x, int y, Image& image) {
  const Color ink = contrast_to(image, x, y - letters.height(), x + letters.width(text), y + 1);
  letters.write(text, x, y, ink, image);
}

}  // namespace

std::vector<double> round_values(double low, double high) {
  if (!(low < high) || !std::isfinite(high - low)) return {low};
  constexpr double kMost = 8;
  const double power = std::pow(10, std::floor(std::log10((high - low) / kMost)));
  double step = power;
  for (const double factor : {2.0, 5.0, 10.0})
    if ((high - low) / step > kMost) step = factor * power;
  std::vector<double> values;
  if (!(step > 0)) return {low};
  const double slack = 1e-9 * step;
  const double first = std::ceil(low / step - 1e-9);
  for (int i = 0; i <= static_cast<int>(kMost); ++i)
    if (const double value = (first + i) * step; value >= low - slack && value <= high + slack)
      if (values.empty() || value > values.back()) values.push_back(value == 0 ? 0 : value);
  return values;
}

Result<void> draw_legend(const Legend& legend, Image& image) {
  if (image.width < kLeastLegendWidth || image.height < kLeastLegendHeight) return {};
  constexpr int kLetters = 45;  // So many in the picture's height.
  const int size = std::max(image.height / kLetters, 9);
  LODE_TRY(const Lettering letters, Lettering::open(size));
  const int letter = letters.height();
  const Layout at = layout_of(image, letter);
  const std::vector<double> values = round_values(legend.low, legend.high);
  const std::vector<std::string> texts = texts_of(values);
  const int text_right = at.bar_left - 2 * at.gap;
  const Color ink =
      contrast_to(image, at.bar_left - at.gap, at.bar_top, at.bar_right + at.gap, at.bar_bottom);
  draw_bar(legend, at, ink, image);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double up =
        legend.low < legend.high ? (values[i] - legend.low) / (legend.high - legend.low) : 0.5;
    const int y = at.bar_bottom - static_cast<int>(std::lround(up * (at.bar_bottom - at.bar_top)));
    const int row = std::clamp(y, at.bar_top, at.bar_bottom - 1);
    for (int x = at.bar_left - at.gap; x < at.bar_left; ++x) blend(ink, 1, pixel_of(image, x, row));
    write(letters, texts[i], text_right - letters.width(texts[i]), y + letter / 2, image);
  }
  const std::string title = fitted(letters, legend.title, image.width / 2);
  write(letters, title, std::max(at.bar_right - letters.width(title), at.gap),
        at.bar_top - 3 * letter / 2, image);
  return {};
}

}  // namespace lode
