#include "tests/io/zarr_fixtures.h"

namespace lode::io {
namespace {

using test::expect_failure;
using test::kSmallZarr;
using test::samples_of;
using test::zarr_samples;
using test::ZarrFixture;

class zarr_shard : public testing::TestWithParam<const char*> {};

TEST_P(zarr_shard, gives_the_samples_back) {
  const ZarrFixture fixture(std::string("v3/shard_") + GetParam());
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path()), zarr_samples<std::int16_t>(kSmallZarr));
}

INSTANTIATE_TEST_SUITE_P(all, zarr_shard,
                         testing::Values("raw", "zstd", "plain_index", "transposed",
                                         "index_at_start", "nested", "inside_transpose",
                                         "inside_crc32c"),
                         [](const auto& each) { return std::string(each.param); });

TEST(zarr_shards, read_at_a_time_and_channel) {
  const ZarrFixture fixture("v3/shard_rank5");
  EXPECT_EQ(samples_of<std::int16_t>(fixture.path(), {.component = 1, .time = 1}),
            zarr_samples<std::int16_t>({{10, 7, 2}}, {.time = 1, .channel = 1}));
}

/// kSmallZarr with 0 in the chunks of 2 x 4 x 5 that `is_hole` says.
template <typename F>
std::vector<std::int16_t> with_holes(const F& is_hole) {
  auto samples = zarr_samples<std::int16_t>(kSmallZarr);
  for (std::size_t z = 0; z < 3; ++z)
    for (std::size_t y = 0; y < 7; ++y)
      for (std::size_t x = 0; x < 10; ++x)
        if (is_hole(z / 2, y / 4, x / 5)) samples[(z * 7 + y) * 10 + x] = 0;
  return samples;
}

TEST(zarr_shards, fill_missing_chunks_and_missing_shards) {
  EXPECT_EQ(samples_of<std::int16_t>(ZarrFixture("v3/shard_some_holes").path()),
            with_holes([](auto z, auto y, auto x) { return z == 0 && y == 0 && x == 1; }));
  EXPECT_EQ(samples_of<std::int16_t>(ZarrFixture("v3/shard_holes").path()),
            with_holes([](auto, auto, auto x) { return x == 1; }));
}

TEST(zarr_shards, are_described_by_what_is_in_them) {
  const auto description = describe_volume(ZarrFixture("v3/shard_zstd").path(), {});
  ASSERT_TRUE(description) << description.error().message;
  EXPECT_EQ(description->format, "Zarr v3, shards of zstd");
}

/// Every byte of a file flipped in turn: a checksum covers the index, nothing the raw samples.
TEST(zarr_shards, notice_every_flipped_byte_of_a_summed_index) {
  const ZarrFixture fixture("v3/shard_raw");
  const std::string shard = fixture.read("c/0/0/0");
  constexpr std::size_t kIndexBytes = 4 * 16 + 4;
  ASSERT_GT(shard.size(), kIndexBytes);
  for (std::size_t at = shard.size() - kIndexBytes; at < shard.size(); ++at) {
    std::string flipped = shard;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    fixture.write("c/0/0/0", flipped);
    expect_failure(fixture.path(), {"c/0/0/0", "its index", "CRC-32C"});
  }
}

TEST(zarr_shards, refuse_ranges_outside_of_the_file_and_files_without_an_index) {
  const ZarrFixture fixture("v3/shard_plain_index");
  const std::string shard = fixture.read("c/0/0/0");
  const std::size_t index_at = shard.size() - 4 * 16;
  using Entry = std::vector<std::uint64_t>;
  constexpr std::uint64_t kAll = std::numeric_limits<std::uint64_t>::max();
  for (const Entry& entry : {Entry{shard.size(), 80}, Entry{shard.size() + 1, 0}, Entry{kAll, 80},
                             Entry{80, kAll}, Entry{kAll - 1, kAll - 1}}) {
    std::string hostile = shard;
    hostile.replace(index_at, 16, test::bytes_of(entry));
    fixture.write("c/0/0/0", hostile);
    expect_failure(fixture.path(), {"c/0/0/0", "expected chunk 0 inside"});
  }
  std::string other = shard;
  other.replace(index_at, 16, test::bytes_of(Entry{0, 79}));
  fixture.write("c/0/0/0", other);
  expect_failure(fixture.path(), {"chunk 0/0/0 in it", "expected 80 bytes, got 79"});
  for (std::size_t n = 1; n < 64; ++n) {
    fixture.write("c/0/0/0", shard.substr(0, n));
    expect_failure(fixture.path(), {"c/0/0/0", "expected an index of 64 bytes"});
  }
}

}  // namespace
}  // namespace lode::io
