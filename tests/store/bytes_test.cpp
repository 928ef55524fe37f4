#include "lode/store/bytes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace lode::store {
namespace {

TEST(bytes, come_back_as_they_were_written) {
  ByteWriter out;
  out.write(std::uint8_t{200});
  out.write(std::int32_t{-7});
  out.write(std::uint64_t{0x0102030405060708});
  out.write(-0.1);
  out.write_string("häl\0lo");
  out.write_all(std::span<const std::int16_t>(std::array<std::int16_t, 3>{1, -2, 3}));
  ByteReader in(out.bytes(), "test");
  EXPECT_EQ(*in.read<std::uint8_t>(), 200);
  EXPECT_EQ(*in.read<std::int32_t>(), -7);
  EXPECT_EQ(*in.read<std::uint64_t>(), 0x0102030405060708u);
  EXPECT_EQ(*in.read<double>(), -0.1);
  EXPECT_EQ(*in.read_string(), "häl\0lo");
  EXPECT_EQ(*in.read_all<std::int16_t>(3), (std::vector<std::int16_t>{1, -2, 3}));
  EXPECT_TRUE(in.expect_end());
}

TEST(bytes, are_little_endian) {
  ByteWriter out;
  out.write(std::uint32_t{0x01020304});
  const std::vector<std::byte> expected = {std::byte{4}, std::byte{3}, std::byte{2}, std::byte{1}};
  EXPECT_EQ(std::move(out).take(), expected);
}

TEST(byte_reader, refuses_more_than_there_is_and_stays_where_it_was) {
  const std::array<std::byte, 6> bytes{};
  ByteReader in(bytes, "f.lode: directory");
  ASSERT_TRUE(in.read<std::uint32_t>());
  const auto number = in.read<std::uint32_t>();
  ASSERT_FALSE(number);
  EXPECT_EQ(number.error().message,
            "f.lode: directory: expected 4 items of 1 bytes at byte 4, got only 2 bytes");
  EXPECT_EQ(in.n_left(), 2u);
  EXPECT_FALSE(in.expect_end());
}

TEST(byte_reader, refuses_counts_that_overflow_before_allocating) {
  const std::array<std::byte, 16> bytes{};
  ByteReader in(bytes, "test");
  EXPECT_FALSE(in.read_all<double>(std::uint64_t{1} << 61));
  EXPECT_FALSE(in.read_all<double>(UINT64_MAX));
  EXPECT_FALSE(in.read_bytes(UINT64_MAX));
  EXPECT_EQ(in.position(), 0u);
}

TEST(byte_reader, refuses_a_string_longer_than_the_bytes) {
  ByteWriter out;
  out.write(std::uint32_t{0xFFFFFFFF});
  out.write(std::uint32_t{0});
  ByteReader in(out.bytes(), "test");
  EXPECT_FALSE(in.read_string());
}

}  // namespace
}  // namespace lode::store
