#include "lode/render/legend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "lode/render/lettering.h"

namespace lode {
namespace {

Image plain(int width, int height, Color color) {
  const auto n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  return {width, height, std::vector<Color>(n, color)};
}

constexpr Color kWhite{255, 255, 255};
constexpr Color kBlack{0, 0, 0};
constexpr Color kClear{0, 0, 0, 0};

/// From black to red.
Legend red_legend() {
  return {.title = "Temperature", .low = -3, .high = 12, .color = [](double value) {
            return Color{static_cast<std::uint8_t>(std::lround((value + 3) * 17)), 0, 0};
          }};
}

TEST(legend, has_round_values_in_its_range) {
  const std::vector<double> fifths = round_values(0, 1);
  ASSERT_EQ(fifths.size(), 6U);
  for (std::size_t i = 0; i < fifths.size(); ++i)
    EXPECT_DOUBLE_EQ(fifths[i], 0.2 * static_cast<double>(i));
  EXPECT_EQ(round_values(-3, 12), (std::vector<double>{-2, 0, 2, 4, 6, 8, 10, 12}));
  EXPECT_EQ(round_values(7, 7), std::vector<double>{7});
  for (const double size : {1e-300, 3e-7, 0.13, 1.0, 47.0, 999.0, 1e20, 1e300})
    for (const double low : {0.0, -0.37 * size, 1.9 * size, -1e3 * size}) {
      const auto values = round_values(low, low + size);
      EXPECT_GE(values.size(), 3U) << low << ' ' << size;
      EXPECT_LE(values.size(), 9U) << low << ' ' << size;
      for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_GE(values[i], low - 1e-6 * size);
        EXPECT_LE(values[i], low + size * (1 + 1e-6));
        if (i > 0) EXPECT_GT(values[i], values[i - 1]);
      }
    }
  EXPECT_EQ(round_values(0, 4).size(), 9U);
  for (const auto& [low, high] : {std::pair{0.0, 5e-324}, {1.0, 1 + 9e-16}, {-1e-310, 1e-310}})
    for (const double value : round_values(low, high)) EXPECT_TRUE(low <= value && value <= high);
  // Steps that doubles do not tell apart.
  EXPECT_LE(round_values(1e20, 1e20 + 16384).size(), 9U);
}

TEST(legend, is_a_bar_at_the_right_with_its_least_value_below) {
  Image image = plain(640, 480, kWhite);
  ASSERT_TRUE(draw_legend(red_legend(), image));
  int bar = -1;
  for (int x = 0; x < image.width; ++x)
    if (image.at(x, 300).r > 60 && image.at(x, 300).g == 0) bar = x;
  ASSERT_GT(bar, 560);
  int reds = 0;
  int last = 256;
  for (int y = 0; y < image.height; ++y) {
    const Color& at = image.at(bar, y);
    if (at.g != 0 || at.b != 0) continue;
    EXPECT_LE(at.r, last);
    last = at.r;
    ++reds;
  }
  EXPECT_GT(reds, 200);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width / 2; ++x) ASSERT_EQ(image.at(x, y), kWhite);
}

TEST(legend, is_written_in_what_stands_out) {
  const auto count = [](const Image& image, const auto& is_ink) {
    return std::ranges::count_if(image.pixels, is_ink);
  };
  Image white = plain(640, 480, kWhite);
  Image black = plain(640, 480, kBlack);
  Image clear = plain(640, 480, kClear);
  for (Image* image : {&white, &black, &clear}) ASSERT_TRUE(draw_legend(red_legend(), *image));
  EXPECT_GT(count(white, [](const Color& c) { return c.g < 60 && c.b > 20 && c.r < 60; }), 300);
  EXPECT_GT(count(black, [](const Color& c) { return c.g > 200 && c.r > 200; }), 300);
  EXPECT_GT(count(clear, [](const Color& c) { return c.a > 200 && c.g < 60; }), 300);
  EXPECT_EQ(clear.at(100, 100), kClear);
}

TEST(legend, needs_room_and_takes_any_title) {
  Image small = plain(kLeastLegendWidth - 1, 400, kWhite);
  const Image before = small;
  ASSERT_TRUE(draw_legend(red_legend(), small));
  EXPECT_EQ(small, before);
  for (const std::string& title : {std::string(), std::string(1000, 'W'),
                                   std::string("\xff\xc3 \xe2\x82 T in \xc2\xb0"
                                               "C")}) {
    Image image = plain(320, 240, kWhite);
    Legend legend = red_legend();
    legend.title = title;
    EXPECT_TRUE(draw_legend(legend, image));
    legend.high = legend.low;
    EXPECT_TRUE(draw_legend(legend, image));
  }
}

TEST(lettering, is_as_wide_as_it_says) {
  const auto letters = Lettering::open(20);
  ASSERT_TRUE(letters) << letters.error().message;
  EXPECT_GT(letters->height(), 10);
  EXPECT_LE(letters->height(), 20);
  EXPECT_EQ(letters->width(""), 0);
  EXPECT_EQ(letters->width("11"), 2 * letters->width("1"));
  Image image = plain(200, 40, kWhite);
  letters->write("0.5", 10, 30, kBlack, image);
  const int end = 10 + letters->width("0.5");
  int n_dark = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y) == kWhite) continue;
      EXPECT_TRUE(x >= 8 && x < end + 2 && y <= 31 && y > 30 - 2 - letters->height())
          << x << ' ' << y;
      ++n_dark;
    }
  EXPECT_GT(n_dark, 40);
  // Beyond the picture nothing is written.
  letters->write("0.5", -1000, 2000, kBlack, image);
  letters->write("0.5", 190, 3, kBlack, image);
}

}  // namespace
}  // namespace lode
