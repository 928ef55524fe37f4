// Rows of leaf attributes against plain loops over points.
#include "lode/models/diamond/leaf_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/oracles/random.h"

namespace lode::diamond {
namespace {

constexpr std::size_t kLengths[] = {5, 33, 35, 129, 131};
constexpr std::size_t kStride = 200;  // between rows

template <typename C>
std::vector<C> rows_of_noise(std::size_t n_rows, bool has_nan, std::uint64_t seed) {
  oracles::Random random(seed);
  std::vector<C> values(n_rows * kStride + kRowPadding);
  for (C& v : values) {
    if constexpr (std::is_integral_v<C>) {
      v = static_cast<C>(2 * random.below(1U << 15));
      continue;
    }
    v = static_cast<C>(random.uniform(-100, 100));
    if (has_nan && random.uniform(0, 1) < 0.2) v = std::numeric_limits<C>::quiet_NaN();
  }
  return values;
}

template <typename C>
void expect_midpoint_errors(std::size_t n, bool has_nan, std::ptrdiff_t across) {
  const auto values = rows_of_noise<C>(4, has_nan, n);
  const C* row = values.data() + 2 * kStride;
  std::vector<C> error(n + kRowPadding);
  midpoint_errors(row, across, n, error.data());
  for (std::size_t x = 0; x < n; ++x) {
    const std::ptrdiff_t along = x % 2 == 0 ? 0 : x % 4 == 1 ? -1 : 1;
    const C* at = row + x;
    using Wide = std::conditional_t<std::is_integral_v<C>, double, C>;
    const Wide mean = (Wide(at[across + along]) + Wide(at[-across - along])) * Wide(0.5);
    const Wide expected = std::abs(Wide(at[0]) - mean);
    EXPECT_EQ(error[x], std::isnan(expected) ? C(0) : static_cast<C>(expected)) << n << ", x " << x;
  }
}

TEST(leaf_rows, midpoint_errors_are_those_of_single_points) {
  for (const std::size_t n : kLengths)
    for (const bool has_nan : {false, true})
      for (const std::ptrdiff_t across : {std::ptrdiff_t{0}, std::ptrdiff_t{kStride}, -37L}) {
        expect_midpoint_errors<float>(n, has_nan, across);
        expect_midpoint_errors<double>(n, has_nan, across);
        expect_midpoint_errors<std::uint16_t>(n, has_nan, across);
      }
}

template <typename C>
void expect_largest(std::size_t n) {
  auto values = rows_of_noise<C>(3, false, n);
  if constexpr (std::is_signed_v<C>)
    for (C& v : values) v = std::abs(v);
  const std::vector<const C*> rows = {values.data(), values.data() + kStride,
                                      values.data() + 2 * kStride};
  std::vector<C> largest(n + kRowPadding);
  largest_of(rows, n, largest.data());
  for (std::size_t x = 0; x < n; ++x)
    EXPECT_EQ(largest[x], std::max({rows[0][x], rows[1][x], rows[2][x]})) << n << ", x " << x;
}

TEST(leaf_rows, the_largest_is_that_of_each_point) {
  for (const std::size_t n : kLengths) {
    expect_largest<float>(n);
    expect_largest<double>(n);
    expect_largest<std::uint16_t>(n);
  }
}

template <typename C>
void expect_extremes(std::size_t n, bool has_nan) {
  const auto values = rows_of_noise<C>(5, has_nan, n);
  const C* row = values.data() + 2 * kStride;
  const RowStencil stencil = {{{-2 * static_cast<std::ptrdiff_t>(kStride)},
                               {kStride, -static_cast<std::ptrdiff_t>(kStride)},
                               {0, 2 * kStride}}};
  std::vector<C> low(n + kRowPadding);
  std::vector<C> high(n + kRowPadding);
  extremes_round(row, stencil, n, has_nan, low.data(), high.data());
  for (std::size_t x = 2; x + 2 < n; ++x) {
    double least = std::numeric_limits<double>::infinity();
    double largest = -least;
    for (std::ptrdiff_t reach = 0; reach < 3; ++reach)
      for (const std::ptrdiff_t offset : stencil[static_cast<std::size_t>(reach)])
        for (std::ptrdiff_t along = -reach; along <= reach; ++along) {
          const double v = row[static_cast<std::ptrdiff_t>(x) + offset + along];
          if (std::isnan(v)) continue;
          least = std::min(least, v);
          largest = std::max(largest, v);
        }
    EXPECT_EQ(low[x], least) << n << ", x " << x;
    EXPECT_EQ(high[x], largest) << n << ", x " << x;
  }
}

TEST(leaf_rows, extremes_are_those_of_the_stencil_without_nan) {
  for (const std::size_t n : kLengths)
    for (const bool has_nan : {false, true}) {
      expect_extremes<float>(n, has_nan);
      expect_extremes<double>(n, has_nan);
      expect_extremes<std::uint16_t>(n, has_nan);
    }
}

}  // namespace
}  // namespace lode::diamond
