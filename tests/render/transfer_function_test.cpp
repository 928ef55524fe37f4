#include "lode/render/transfer_function.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <limits>

namespace lode::test {
namespace {

TransferFunction parsed(std::string_view text) {
  auto function = parse_transfer_function(text, "f.txt");
  EXPECT_TRUE(function) << function.error().message;
  return function ? *function : TransferFunction{};
}

TEST(transfer_function, is_linear_between_knots_and_constant_beyond) {
  const TransferFunction f{{{1, {{0, 0, 0}}, 2}, {3, {{1, 0.5, 0}}, 6}}};
  EXPECT_EQ(f.at(2), (TransferKnot{2, {{0.5, 0.25, 0}}, 4}));
  EXPECT_EQ(f.at(-9).extinction, 2);
  EXPECT_EQ(f.at(9).color, (Vec3d{{1, 0.5, 0}}));
  EXPECT_EQ(f.at(3).extinction, 6);
}

TEST(transfer_function, presets_fit_range_and_length) {
  for (const char* const name : {"viridis-smoke", "smoke", "bands", "solid", "clear-middle"}) {
    const auto small = transfer_preset(name, {10, 20, 0.5});
    const auto large = transfer_preset(name, {10, 20, 50});
    ASSERT_TRUE(small && large) << name;
    ASSERT_TRUE(check_transfer_function(*small)) << name;
    EXPECT_GE(small->knots.front().value, 10);
    EXPECT_LE(small->knots.back().value, 20);
    for (std::size_t i = 0; i < small->knots.size(); ++i)
      EXPECT_NEAR(small->knots[i].extinction, 100 * large->knots[i].extinction, 1e-9);
    const auto constant = transfer_preset(name, {3, 3, 1});
    ASSERT_TRUE(constant) << name;
    EXPECT_EQ(constant->knots.size(), 1U);
  }
  const auto unknown = transfer_preset("fog", {});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("viridis-smoke, smoke"), std::string::npos);
  EXPECT_FALSE(transfer_preset("smoke", {2, 1, 1}));
  EXPECT_FALSE(transfer_preset("smoke", {0, 1, 0}));
  EXPECT_FALSE(transfer_preset("smoke", {0, std::numeric_limits<double>::quiet_NaN(), 1}));
}

TEST(transfer_function, is_read_from_lines_of_five_numbers) {
  const TransferFunction f =
      parsed("# value r g b extinction\n1.5 0 0.25 1 0\r\n\n  2,1,1,1,+3e1 # dense\n3;0;0;0;7");
  ASSERT_EQ(f.knots.size(), 3U);
  EXPECT_EQ(f.knots[0], (TransferKnot{1.5, {{0, 0.25, 1}}, 0}));
  EXPECT_EQ(f.knots[1], (TransferKnot{2, {{1, 1, 1}}, 30}));
  EXPECT_EQ(f.knots[2].extinction, 7);
}

TEST(transfer_function, files_that_say_nothing_usable_are_refused_by_line) {
  const auto refused = [](std::string_view text, std::string_view message) {
    const auto function = parse_transfer_function(text, "f.txt");
    ASSERT_FALSE(function) << text;
    EXPECT_NE(function.error().message.find("f.txt"), std::string::npos);
    EXPECT_NE(function.error().message.find(message), std::string::npos)
        << function.error().message;
  };
  refused("", "expected 1 to 65536 knots, got 0");
  refused("1 0 0 0 1\n2 0 0 1\n", "line 2: expected five numbers");
  refused("1 0 0 0 1 9", "got more");
  refused("1 0 0 zero 1", "expected a number, got 'zero'");
  refused("1 0 0 0 1\n1 0 0 0 2", "expected ascending values, knot 1");
  refused("1 0 0 0 1\n1e999 0 0 0 2", "expected a number");
  refused("1 0 0 0 -1", "expected extinctions");
  refused("1 0 -1 0 1", "expected colours");
  refused("1 0 nan 0 1", "expected colours");
  refused("inf 0 0 0 1", "expected finite values");
  refused("-1e308 0 0 0 1\n1e308 0 0 0 1", "differences");
  refused("0 0 0 0 1\n1e-300 0 0 0 1", "apart");
  refused("0 0 0 0 1\n1e-20 0 0 0 1\n1 0 0 0 1", "ascending");
  refused(std::string("\x89PNG\0\r\n", 7), "expected a number");
}

TEST(transfer_function, files_that_cannot_be_read_or_are_huge_are_refused) {
  EXPECT_FALSE(read_transfer_function("/nowhere/f.txt"));
  EXPECT_FALSE(read_transfer_function("/"));
  const auto endless = read_transfer_function("/dev/zero");
  ASSERT_FALSE(endless);
  EXPECT_NE(endless.error().message.find("larger"), std::string::npos);
}

}  // namespace
}  // namespace lode::test
