#include "lode/render/color.h"

#include <gtest/gtest.h>

#include "lode/render/surface_colors.h"

#include <algorithm>
#include <limits>
#include <string>

namespace lode {
namespace {

TEST(color, reads_hexadecimal_and_names) {
  EXPECT_EQ(*parse_color("#1a2B3c"), (Color{0x1a, 0x2b, 0x3c}));
  EXPECT_EQ(*parse_color("#fa0"), (Color{0xff, 0xaa, 0x00}));
  EXPECT_EQ(*parse_color("#01020304"), (Color{1, 2, 3, 4}));
  EXPECT_EQ(*parse_color("white"), (Color{255, 255, 255}));
  EXPECT_EQ(*parse_color("SteelBlue"), *parse_color("steelblue"));
  EXPECT_EQ(parse_color("transparent")->a, 0);
}

TEST(color, refuses_what_is_no_colour_and_says_what_is) {
  for (const std::string text : {"", "#", "#12", "#12345", "#1234567", "#123456789", "#gg0000",
                                 "#-1-1-1", "123456", "mauvish", "white "}) {
    const auto color = parse_color(text);
    ASSERT_FALSE(color) << text;
    EXPECT_NE(color.error().message.find("\"" + text + "\""), std::string::npos) << text;
  }
  EXPECT_NE(parse_color("mauvish").error().message.find("steelblue"), std::string::npos);
}

TEST(color, survives_linear_light_and_back) {
  for (int i = 0; i < 256; ++i) {
    const auto level = static_cast<std::uint8_t>(i);
    const Color color{level, level, level};
    EXPECT_EQ(to_srgb(to_linear(color)), color);
  }
}

TEST(color, clamps_light_outside_the_range_and_makes_nan_black) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(to_srgb({{-1, 2, nan}}), (Color{0, 255, 0}));
  EXPECT_EQ(to_srgb({{1, 1, 1}}, nan).a, 0);
}

TEST(color, gives_as_many_different_colours_as_asked) {
  for (const std::size_t n : {0U, 1U, 2U, 8U, 9U, 40U}) {
    const std::vector<Color> colors = distinct_colors(n);
    ASSERT_EQ(colors.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(std::count(colors.begin(), colors.end(), colors[i]), 1) << i << " of " << n;
    }
  }
}

TEST(color, sequence_rises_in_lightness_and_clamps) {
  float last = -1;
  for (int i = 0; i <= 64; ++i) {
    const Vec3f light = to_linear(sequential_color(i / 64.0));
    const float lightness = dot(light, Vec3f{{0.2126f, 0.7152f, 0.0722f}});
    EXPECT_GE(lightness, last);
    last = lightness;
  }
  EXPECT_EQ(sequential_color(-1), sequential_color(0));
  EXPECT_EQ(sequential_color(2), sequential_color(1));
  EXPECT_EQ(sequential_color(std::numeric_limits<double>::quiet_NaN()), sequential_color(0));
}

/// As the field is linear between vertices, and not the colours.
TEST(surface_colors, of_levels_are_those_of_the_ramp_in_between) {
  const Vec3f black{{0, 0, 0}};
  const Vec3f red{{1, 0, 0}};
  const Vec3f blue{{0, 0, 1}};
  const SurfaceColors colors{.uniform = {{1, 1, 1}},
                             .per_vertex = {},
                             .levels = {0, 1, 1, -1, -1, -1},
                             .ramp = {black, red, blue}};
  EXPECT_EQ(colors.at({0, 1, 2}, {0.5F, 0.25F, 0.25F}), red);
  EXPECT_EQ(colors.at({0, 1, 2}, {1, 0, 0}), black);
  EXPECT_EQ(colors.at({0, 1, 2}, {0, 0, 1}), blue);
  EXPECT_EQ(colors.at({1, 2, 0}, {0.5F, 0.25F, 0.25F}), (red + blue) * 0.5F);
  EXPECT_EQ(colors.at({3, 4, 5}, {0.5F, 0.25F, 0.25F}), colors.uniform);
}

}  // namespace
}  // namespace lode
