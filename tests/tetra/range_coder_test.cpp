// Numbers as coded bits: they come back, take what they are improbable, and any bytes are read.

#include "lode/models/tetra_mt/range_coder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/number_models.h"
#include "lode/models/tetra_mt/position_codes.h"
#include "lode/models/tetra_mt/value_codes.h"
#include "tests/oracles/random.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;

/// A bit, or a number, of all kinds there are.
struct Item {
  std::size_t kind;
  std::uint64_t number;
};

/// Codes items in place, with models by kind.
class Items {
 public:
  template <typename Coder>
  std::uint64_t code(Coder& coder, const Item& item) {
    const auto number = static_cast<std::uint32_t>(item.number);
    switch (item.kind) {
      case 0: return coder.bit(bit_, item.number != 0) ? 1 : 0;
      case 1: return coder.one_of(65536, number);
      case 2: return code_plain(coder, 64, item.number);
      case 3: return symbol_.code(coder, number);
      case 4: return number_.code(coder, number);
      case 5: return wide_.code(coder, item.number);
      case 6: return count_.code(coder, number);
      default: return code_below(coder, kBelow, item.number);
    }
  }
  [[nodiscard]] static std::uint64_t largest(std::size_t kind) {
    constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t sizes[]{
        1, 65535, kAll, 127, NumberModel::kLargest, kAll, NumberModel::kLargest, kBelow - 1};
    return sizes[kind];
  }
  static constexpr std::size_t kKinds = 8;

 private:
  static constexpr std::uint64_t kBelow = 0x123456789ABCDULL;

  BitModel bit_;
  SymbolModel<7> symbol_;
  NumberModel number_;
  WideModel wide_;
  CountModel<4> count_;
};

std::vector<Item> some_items(Random& random, std::size_t n) {
  std::vector<Item> items;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t kind = random.below(Items::kKinds);
    const std::uint64_t largest = Items::largest(kind);
    std::uint64_t number = random.below(3);
    if (random.below(4) == 0) number = largest - number;
    if (random.below(4) == 0) number = random.below(~0ULL) >> random.below(64);
    items.push_back({kind, std::min(number, largest)});
  }
  return items;
}

std::vector<std::byte> written(const std::vector<Item>& items) {
  RangeWriter out;
  Items models;
  for (const Item& item : items) EXPECT_EQ(models.code(out, item), item.number);
  return std::move(out).take();
}

TEST(range_coder, gives_back_numbers_of_all_kinds_and_sees_where_they_end) {
  Random random(4);
  for (std::size_t n = 0; n < 400; n += n < 40 ? 1 : 30) {
    const std::vector<Item> items = some_items(random, n);
    const std::vector<std::byte> bytes = written(items);
    RangeReader in(bytes);
    Items models;
    for (const Item& item : items) EXPECT_EQ(models.code(in, {item.kind, 0}), item.number);
    EXPECT_TRUE(in.is_at_end());
    if (bytes.size() < 20) continue;
    const std::span first = std::span(bytes).first(bytes.size() - 5);
    RangeReader shorter(first);
    Items again;
    for (const Item& item : items) static_cast<void>(again.code(shorter, {item.kind, 0}));
    EXPECT_FALSE(shorter.is_at_end());
  }
}

TEST(range_coder, carries_through_long_runs_of_bits_that_are_improbable) {
  // A model that is sure of 0 and gets 1 again and again brings the low end up to the top.
  for (const std::uint32_t last : {0U, 1U, 32767U, 65535U}) {
    RangeWriter out;
    for (int i = 0; i < 3000; ++i) static_cast<void>(out.one_of(65536, 65535));
    static_cast<void>(out.one_of(65536, last));
    const std::vector<std::byte> bytes = std::move(out).take();
    RangeReader in(bytes);
    for (int i = 0; i < 3000; ++i) ASSERT_EQ(in.one_of(65536), 65535U);
    EXPECT_EQ(in.one_of(65536), last);
    EXPECT_TRUE(in.is_at_end());
  }
}

TEST(range_coder, takes_what_bits_are_improbable) {
  Random random(7);
  std::vector<bool> bits;
  for (int i = 0; i < 100'000; ++i) bits.push_back(random.below(20) == 0);
  RangeWriter out;
  BitModel model;
  for (const bool bit : bits) static_cast<void>(out.bit(model, bit));
  const double entropy = -(0.05 * std::log2(0.05) + 0.95 * std::log2(0.95));
  const auto n_bits = 8 * static_cast<double>(std::move(out).take().size());
  // A model that learns from the last 60 is off by a variance of p (1 - p) / 120, which costs about
  // 1 / (2 · 120 · ln 2) of a bit: 0.006.
  EXPECT_LT(n_bits, 1e5 * (entropy + 0.008));
}

TEST(range_coder, reads_any_bytes_as_numbers_within_their_bounds) {
  Random random(11);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::byte> bytes(random.below(200));
    const std::size_t kind = random.below(3);
    for (std::byte& byte : bytes)
      byte = kind == 0 ? std::byte{0xFF} : static_cast<std::byte>(random.below(256));
    if (kind == 2) bytes = written(some_items(random, 60));
    if (kind == 2) bytes[random.below(bytes.size())] ^= static_cast<std::byte>(random.below(256));
    RangeReader in(bytes);
    Items models;
    for (std::size_t i = 0; i < 300; ++i) {
      const std::uint64_t found = models.code(in, {i % Items::kKinds, 0});
      // That which is below n may be above by what its top leaves open.
      if (i % Items::kKinds == 7) continue;
      const std::uint64_t more = i % Items::kKinds == 6 ? 15 : 0;
      EXPECT_LE(found, std::max(Items::largest(i % Items::kKinds) + more, more));
    }
  }
}

TEST(position_codes, give_back_grids_points_and_both_zeros_and_refuse_what_is_not_finite) {
  Random random(3);
  for (const bool is_narrow : {true, false})
    for (std::size_t trial = 0; trial < 60; ++trial) {
      std::vector<Vec3d> given(1 + random.below(512));
      for (Vec3d& p : given)
        for (std::size_t i = 0; i < 3; ++i) {
          const std::size_t kind = (trial + i) % 4;
          p[i] = kind == 0   ? static_cast<double>(random.below(9)) / 8
                 : kind == 1 ? random.uniform(-1e30, 1e30)
                 : kind == 2 ? (random.below(2) == 0 ? 0.0 : -0.0)
                             : std::ldexp(1.0, static_cast<int>(random.below(200)) - 100);
          if (is_narrow) p[i] = static_cast<double>(static_cast<float>(p[i]));
        }
      RangeWriter out;
      std::vector<Vec3d> same = given;
      PositionModels models{};
      ASSERT_TRUE(code_positions(out, models, is_narrow, "page", same));
      std::vector<std::byte> bytes = std::move(out).take();
      std::vector<Vec3d> found(given.size());
      RangeReader in(bytes);
      models = {};
      ASSERT_TRUE(code_positions(in, models, is_narrow, "page", found));
      EXPECT_TRUE(in.is_at_end());
      for (std::size_t k = 0; k < given.size(); ++k)
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_EQ(found[k][i], given[k][i]);
          EXPECT_EQ(std::signbit(found[k][i]), std::signbit(given[k][i]));
        }
      for (int k = 0; k < 5; ++k)
        bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
      RangeReader lying(bytes);
      models = {};
      if (!code_positions(lying, models, is_narrow, "page", found)) continue;
      for (const Vec3d& p : found) EXPECT_TRUE(std::isfinite(length(p * 1e-300)));
    }
}

TEST(value_codes, give_back_values_beside_outliers_zeros_and_knots_that_are_alike) {
  Random random(5);
  for (const bool is_narrow : {true, false})
    for (const double outlier : {0.0, -0.0, 1e30, -1e-30}) {
      std::vector<double> given;
      for (int i = 0; i < 3000; ++i) {
        const double value = i % 3 == 0 ? 0.25 : i % 5 == 0 ? -0.0 : random.uniform(-1, 0.5);
        given.push_back(is_narrow ? static_cast<double>(static_cast<float>(value)) : value);
      }
      given.push_back(is_narrow ? static_cast<double>(static_cast<float>(outlier)) : outlier);
      if (outlier < 0) std::ranges::fill(given, given.back());
      const ValueScale scale = ValueScale::of(given);
      const std::string what = "page";
      RangeWriter out;
      ValueModels written{};
      ValueCoder writer(out, written, scale, is_narrow, what);
      for (double value : given) ASSERT_TRUE(writer.code(value));
      const std::vector<std::byte> bytes = std::move(out).take();
      RangeReader in(bytes);
      ValueModels read{};
      ValueCoder reader(in, read, scale, is_narrow, what);
      for (const double value : given) {
        double found = 0;
        ASSERT_TRUE(reader.code(found));
        EXPECT_EQ(found, value);
        EXPECT_EQ(std::signbit(found), std::signbit(value));
      }
      EXPECT_TRUE(in.is_at_end());
    }
}

}  // namespace
}  // namespace lode::tetra_mt
