// Numbers of a page in memory: every bit comes back, in no more bits than the numbers have.
#include "lode/models/tetra_mt/packed_numbers.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "tests/oracles/random.h"

namespace lode::tetra_mt {
namespace {

using Numbers = std::vector<std::array<double, 3>>;

std::uint64_t bits_of(double number) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &number, sizeof bits);
  return bits;
}

/// Writes behind a few bytes of something else, and reads all back. Returns how many bytes it took.
std::size_t expect_exact(const Numbers& numbers, bool is_narrow) {
  const auto n = static_cast<std::uint32_t>(numbers.size());
  const auto number = [&](std::uint32_t i, std::size_t k) { return numbers[i][k]; };
  BitWriter bits;
  for (int i = 0; i < 3; ++i) bits.write(5, 7);
  const std::size_t begin = bits.align();
  const PackedNumbers<3> packed(n, is_narrow, number);
  packed.write(n, number, bits);
  const std::size_t end = bits.align();
  bits.write(~0U, 32);
  const std::vector<std::uint8_t> bytes = std::move(bits).take();
  for (std::uint32_t i = 0; i < n; ++i) {
    const auto read = packed.read(bytes.data() + begin, i);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(bits_of(read[k]), bits_of(numbers[i][k])) << i;
  }
  return end - begin;
}

double narrowed(double number) { return static_cast<double>(static_cast<float>(number)); }

TEST(packed_numbers, come_back_bit_for_bit) {
  oracles::Random random(41);
  for (const bool is_narrow : {true, false})
    for (const std::size_t n : {1U, 2U, 31U, 512U}) {
      Numbers numbers(n);
      for (auto& three : numbers)
        for (double& x : three) {
          x = random.uniform(-1, 1) * std::exp2(random.uniform(-100, 100));
          if (is_narrow) x = narrowed(x);
        }
      expect_exact(numbers, is_narrow);
    }
}

TEST(packed_numbers, have_signed_zeros_and_the_ends_of_floats) {
  const double tiny = std::numeric_limits<float>::denorm_min();
  const double huge = std::numeric_limits<float>::max();
  expect_exact({{0, -0.0, tiny}, {-0.0, 0, -tiny}, {huge, -huge, 0}}, true);
  const double least = std::numeric_limits<double>::denorm_min();
  const double most = std::numeric_limits<double>::max();
  expect_exact({{0, -0.0, least}, {-0.0, 0, -least}, {most, -most, 1}, {-most, most, -1}}, false);
  expect_exact({}, true);
}

TEST(packed_numbers, take_the_bits_that_they_have) {
  Numbers grid;
  for (int i = 0; i < 512; ++i) grid.push_back({16.0 + i % 8, 16.0 + i / 8 % 8, 16.0 + i / 64});
  // Of 16 to 23 float32 has 20 bits below them: three bits are left of each, 9 of three.
  EXPECT_EQ(expect_exact(grid, true), 512 * 9 / 8U);
  // float64 has as few, as those of both end in zeros.
  EXPECT_EQ(expect_exact(grid, false), 512 * 9 / 8U);
  // Equal ones take none.
  EXPECT_EQ(expect_exact(Numbers(512, {0.1, -7, 1e300}), false), 0U);
  // And what is anywhere between 1 and 2 takes the 23 of a mantissa.
  oracles::Random random(43);
  Numbers any(512);
  for (auto& three : any)
    for (double& x : three) x = narrowed(random.uniform(1, 1.999));
  EXPECT_EQ(expect_exact(any, true), 512 * 3 * 23 / 8U);
}

}  // namespace
}  // namespace lode::tetra_mt
