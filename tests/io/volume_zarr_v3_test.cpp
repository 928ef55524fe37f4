#include <cmath>

#include "lode/io/crc32c.h"
#include "tests/io/zarr_fixtures.h"

namespace lode::io {
namespace {

using test::expect_failure;
using test::kLargeZarr;
using test::kSmallZarr;
using test::samples_of;
using test::with_missing_chunk;
using test::zarr_samples;
using test::ZarrFixture;

std::uint32_t crc32c_of(const std::string& text) { return crc32c(std::as_bytes(std::span(text))); }

TEST(crc32c, gives_the_sums_of_rfc_3720) {
  // Appendix B.4, read as little-endian numbers; the last is the usual check value of the CRC.
  EXPECT_EQ(crc32c_of(std::string(32, '\0')), 0x8a9136aaU);
  EXPECT_EQ(crc32c_of(std::string(32, '\xff')), 0x62a8ab43U);
  std::string ascending;
  for (char c = 0; c < 32; ++c) ascending += c;
  EXPECT_EQ(crc32c_of(ascending), 0x46dd794eU);
  EXPECT_EQ(crc32c_of({ascending.rbegin(), ascending.rend()}), 0x113fdb5cU);
  EXPECT_EQ(crc32c_of("123456789"), 0xe3069283U);
  EXPECT_EQ(crc32c_of(""), 0U);
}

template <typename T>
void expect_type(const std::string& name) {
  for (const char* order : {"little", "big"}) {
    if (sizeof(T) == 1 && std::string(order) == "big") continue;
    const ZarrFixture fixture("v3/type_" + name + '_' + order);
    EXPECT_EQ(samples_of<T>(fixture.path()), zarr_samples<T>(kSmallZarr)) << name << ' ' << order;
  }
}

TEST(zarr_v3_reader, reads_every_type_in_both_byte_orders) {
  expect_type<std::uint8_t>("uint8");
  expect_type<std::int8_t>("int8");
  expect_type<std::uint16_t>("uint16");
  expect_type<std::int16_t>("int16");
  expect_type<std::uint32_t>("uint32");
  expect_type<std::int32_t>("int32");
  expect_type<std::uint64_t>("uint64");
  expect_type<std::int64_t>("int64");
  expect_type<float>("float32");
  expect_type<double>("float64");
}

class zarr_v3_codec : public testing::TestWithParam<const char*> {};

TEST_P(zarr_v3_codec, gives_the_samples_back) {
  const ZarrFixture fixture(std::string("v3/codec_") + GetParam());
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kLargeZarr));
}

INSTANTIATE_TEST_SUITE_P(
    all, zarr_v3_codec,
    testing::Values("gzip", "zstd", "crc32c", "gzip_crc32c", "crc32c_gzip", "zstd_crc32c",
                    "blosc_blosclz_noshuffle", "blosc_blosclz_shuffle", "blosc_blosclz_bitshuffle",
                    "blosc_lz4_noshuffle", "blosc_lz4_shuffle", "blosc_lz4_bitshuffle",
                    "blosc_lz4hc_noshuffle", "blosc_lz4hc_shuffle", "blosc_lz4hc_bitshuffle",
                    "blosc_zlib_noshuffle", "blosc_zlib_shuffle", "blosc_zlib_bitshuffle",
                    "blosc_zstd_noshuffle", "blosc_zstd_shuffle", "blosc_zstd_bitshuffle"),
    [](const auto& each) { return std::string(each.param); });

class zarr_v3_layout : public testing::TestWithParam<const char*> {};

TEST_P(zarr_v3_layout, gives_the_samples_back) {
  const ZarrFixture fixture(std::string("v3/") + GetParam());
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kSmallZarr));
}

INSTANTIATE_TEST_SUITE_P(all, zarr_v3_layout,
                         testing::Values("transpose_012", "transpose_021", "transpose_102",
                                         "transpose_120", "transpose_201", "transpose_210", "dots",
                                         "keys_v2_dots", "keys_v2_slashes"),
                         [](const auto& each) { return std::string(each.param); });

TEST(zarr_v3_reader, reads_two_and_five_axes) {
  const ZarrFixture two("v3/rank2");
  EXPECT_EQ(samples_of<std::int16_t>(two.path()), zarr_samples<std::int16_t>({{10, 7, 1}}));
  const ZarrFixture five("v3/rank5");
  EXPECT_EQ(samples_of<std::int16_t>(five.path(), {.component = 2, .time = 1}),
            zarr_samples<std::int16_t>({{10, 7, 2}}, {.time = 1, .channel = 2}));
}

TEST(zarr_v3_reader, takes_the_axis_named_t_for_time) {
  const ZarrFixture fixture("v3/named");
  expect_failure(fixture.path(), {"holds 2 times"}, {.component = 2});
  // The formula's time counts along the first axis, which here is the channel.
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path(), {.component = 2, .time = 1}),
            zarr_samples<std::int16_t>({{10, 7, 2}}, {.time = 2, .channel = 1}));
}

TEST(zarr_v3_reader, fills_missing_chunks) {
  EXPECT_EQ(samples_of<std::int16_t>(ZarrFixture("v3/fill_42").path()),
            with_missing_chunk<std::int16_t>(42));
  EXPECT_EQ(samples_of<double>(ZarrFixture("v3/fill_infinity").path()),
            with_missing_chunk(-std::numeric_limits<double>::infinity()));
  EXPECT_EQ(samples_of<float>(ZarrFixture("v3/fill_bits").path()), with_missing_chunk<float>(1000));
  const auto with_nan = samples_of<float>(ZarrFixture("v3/fill_nan").path());
  ASSERT_EQ(with_nan.size(), 210U);
  EXPECT_TRUE(std::isnan(with_nan[5]));
  EXPECT_FALSE(std::isnan(with_nan[4]));
}

}  // namespace
}  // namespace lode::io
