#include <cmath>
#include <limits>

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

template <typename T>
void expect_type(const std::string& name, const std::vector<std::string>& orders) {
  for (const std::string& order : orders) {
    const ZarrFixture fixture("v2/type_" + name + '_' + order);
    EXPECT_EQ(samples_of<T>(fixture.path()), zarr_samples<T>(kSmallZarr)) << name << ' ' << order;
  }
}

TEST(zarr_v2_reader, reads_every_type_in_both_byte_orders) {
  const std::vector<std::string> both = {"little", "big"};
  expect_type<std::uint8_t>("u1", {"native"});
  expect_type<std::int8_t>("i1", {"native"});
  expect_type<std::uint16_t>("u2", both);
  expect_type<std::int16_t>("i2", both);
  expect_type<std::uint32_t>("u4", both);
  expect_type<std::int32_t>("i4", both);
  expect_type<std::uint64_t>("u8", both);
  expect_type<std::int64_t>("i8", both);
  expect_type<float>("f4", both);
  expect_type<double>("f8", both);
}

class zarr_v2_compressor : public testing::TestWithParam<const char*> {};

TEST_P(zarr_v2_compressor, gives_the_samples_back) {
  const ZarrFixture fixture(std::string("v2/codec_") + GetParam());
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kLargeZarr));
}

INSTANTIATE_TEST_SUITE_P(all, zarr_v2_compressor,
                         testing::Values("raw", "gzip", "zlib", "zstd", "blosc_blosclz_none",
                                         "blosc_blosclz_bytes", "blosc_blosclz_bits",
                                         "blosc_lz4_none", "blosc_lz4_bytes", "blosc_lz4_bits",
                                         "blosc_lz4hc_none", "blosc_lz4hc_bytes",
                                         "blosc_lz4hc_bits", "blosc_snappy_none",
                                         "blosc_snappy_bytes", "blosc_snappy_bits",
                                         "blosc_zlib_none", "blosc_zlib_bytes", "blosc_zlib_bits",
                                         "blosc_zstd_none", "blosc_zstd_bytes", "blosc_zstd_bits"),
                         [](const auto& each) { return std::string(each.param); });

TEST(zarr_v2_reader, reads_both_memory_orders_of_two_to_five_axes) {
  for (const char* order : {"C", "F"}) {
    const ZarrFixture two(std::string("v2/rank2_") + order);
    EXPECT_EQ(samples_of<std::int16_t>(two.path()), zarr_samples<std::int16_t>({{10, 7, 1}}));
    const ZarrFixture three(std::string("v2/rank3_") + order);
    EXPECT_EQ(samples_of<std::int16_t>(three.path()), zarr_samples<std::int16_t>(kSmallZarr));
    const ZarrFixture four(std::string("v2/rank4_") + order);
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(samples_of<std::int16_t>(four.path(), {.component = c}),
                zarr_samples<std::int16_t>({{10, 7, 2}}, {.channel = c}));
    const ZarrFixture five(std::string("v2/rank5_") + order);
    for (int t = 0; t < 2; ++t)
      for (int c = 0; c < 3; ++c)
        EXPECT_EQ(samples_of<std::int16_t>(five.path(), {.component = c, .time = t}),
                  zarr_samples<std::int16_t>({{10, 7, 2}}, {.time = t, .channel = c}));
  }
}

TEST(zarr_v2_reader, reads_chunks_in_folders_and_chunks_larger_than_the_array) {
  for (const char* name : {"v2/slashes", "v2/one_chunk"}) {
    const ZarrFixture fixture(name);
    EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kSmallZarr))
        << name;
  }
}

TEST(zarr_v2_reader, drops_leading_axes_of_length_one) {
  const ZarrFixture fixture("v2/thin");
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kSmallZarr));
  expect_failure(fixture.path(), {"--time between 0 and 0"}, {.time = 1});
  expect_failure(fixture.path(), {"--component between 0 and 0"}, {.component = 1});
}

TEST(zarr_v2_reader, wants_a_choice_of_time_and_component) {
  const ZarrFixture fixture("v2/rank5_C");
  expect_failure(fixture.path(), {"holds 2 times", "--time N, 0 to 1"});
  expect_failure(fixture.path(), {"holds 3 components", "--component N, 0 to 2"}, {.time = 1});
  expect_failure(fixture.path(), {"magnitude"}, {.component = Magnitude{}, .time = 1});
  const auto description = describe_volume(fixture.path(), {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->n_times, 2);
  EXPECT_EQ(description->n_components, 3);
  EXPECT_EQ(description->grid.dims, (Index3{{10, 7, 2}}));
  EXPECT_EQ(description->format, "Zarr v2, zlib");
}

TEST(zarr_v2_reader, fills_missing_chunks) {
  auto expected = with_missing_chunk<std::int16_t>(42);
  for (std::size_t y = 4; y < 7; ++y)
    for (std::size_t x = 5; x < 10; ++x) expected[(2 * 7 + y) * 10 + x] = 42;
  EXPECT_EQ(samples_of<std::int16_t>(ZarrFixture("v2/fill_42").path()), expected);
  EXPECT_EQ(samples_of<std::int16_t>(ZarrFixture("v2/fill_null").path()),
            with_missing_chunk<std::int16_t>(0));
  EXPECT_EQ(samples_of<std::uint64_t>(ZarrFixture("v2/fill_largest").path()),
            with_missing_chunk(std::numeric_limits<std::uint64_t>::max()));
  EXPECT_EQ(samples_of<double>(ZarrFixture("v2/fill_infinity").path()),
            with_missing_chunk(-std::numeric_limits<double>::infinity()));
  const auto with_nan = samples_of<float>(ZarrFixture("v2/fill_nan").path());
  const auto marked = with_missing_chunk<float>(1000);
  ASSERT_EQ(with_nan.size(), marked.size());
  for (std::size_t i = 0; i < marked.size(); ++i) {
    if (marked[i] == 1000)
      EXPECT_TRUE(std::isnan(with_nan[i])) << i;
    else
      EXPECT_EQ(with_nan[i], marked[i]) << i;
  }
}

TEST(zarr_v2_reader, opens_the_arrays_of_a_group) {
  const ZarrFixture one("v2/group_one");
  EXPECT_EQ(samples_of<std::uint16_t>(one.path()), zarr_samples<std::uint16_t>(kSmallZarr));
  EXPECT_EQ(test::info_of(one.path()).field_name, "density");
  EXPECT_EQ(test::info_of(one.path("density")).field_name, "");
  const ZarrFixture two("v2/group_two");
  expect_failure(two.path(), {"holds 2 fields", "--field: heat, speed"});
  expect_failure(two.path(), {"no field 'mass'", "heat, speed"}, {.field = "mass"});
  EXPECT_EQ(samples_of<float>(two.path(), {.field = "heat"}), zarr_samples<float>(kSmallZarr));
  EXPECT_EQ(samples_of<std::uint8_t>(two.path("speed")), zarr_samples<std::uint8_t>(kSmallZarr));
  const auto description = describe_volume(two.path(), {.field = "speed"});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->fields, (std::vector<std::string>{"heat", "speed"}));
  EXPECT_EQ(description->type, ScalarType::uint8);
  expect_failure(ZarrFixture("v2/group_of_groups").path(), {"the groups inner"});
  expect_failure(ZarrFixture("v2/group_empty").path(), {"an empty one"});
}

TEST(zarr_v2_reader, refuses_other_directories_and_what_is_for_bare_samples) {
  const test::TempDir dir;
  expect_failure(dir.path(""), {"zarr.json"});
  const ZarrFixture fixture("v2/slashes");
  ReadOptions raw;
  raw.raw = RawLayout{.dims = {{1, 1, 1}}};
  expect_failure(fixture.path(), {"describes itself"}, raw);
  expect_failure(fixture.path(), {"--nodata"}, {.nodata = std::nan("")});
  EXPECT_EQ(test::info_of(fixture.path(), {.nodata = 3}).nodata, 3);
}

}  // namespace
}  // namespace lode::io
