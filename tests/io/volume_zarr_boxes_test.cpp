#include <cstring>
#include <random>

#include "lode/io/chunk_cache.h"
#include "tests/io/zarr_fixtures.h"

namespace lode::io {
namespace {

using test::zarr_sample;
using test::ZarrFixture;

/// Reads a box and expects the formula's samples there.
void expect_box(VolumeSource& source, const IndexBox& box, std::int64_t first = 0) {
  std::vector<std::int16_t> samples(static_cast<std::size_t>(box.n_samples()));
  const auto status = source.read(box, std::as_writable_bytes(std::span(samples)));
  ASSERT_TRUE(status) << status.error().message;
  std::size_t i = 0;
  for (std::int64_t z = box.lower[2]; z < box.upper[2]; ++z)
    for (std::int64_t y = box.lower[1]; y < box.upper[1]; ++y)
      for (std::int64_t x = box.lower[0]; x < box.upper[0]; ++x)
        ASSERT_EQ(samples[i++], zarr_sample<std::int16_t>(first + 101 * z + 13 * y + x));
}

void expect_random_boxes(const std::string& path, const ReadOptions& options, std::int64_t first) {
  const auto source = open_volume(path, options);
  ASSERT_TRUE(source) << source.error().message;
  const Index3 dims = (*source)->info().grid.dims;
  constexpr std::uint64_t kSeed = 20240915;
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 200; ++round) {
    IndexBox box;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto n = static_cast<std::uint64_t>(dims[i]);
      box.lower[i] = static_cast<std::int32_t>(random() % n);
      const auto left = n - static_cast<std::uint64_t>(box.lower[i]);
      box.upper[i] = box.lower[i] + static_cast<std::int32_t>(random() % (left + 1));
    }
    SCOPED_TRACE(fmt::format("seed {} round {}", kSeed, round));
    expect_box(**source, box, first);
  }
}

TEST(zarr_source, reads_any_box_on_any_number_of_threads) {
  for (const int n_threads : {1, 2, 5}) {
    const Threads threads{n_threads};
    expect_random_boxes(ZarrFixture("v2/codec_blosc_lz4_bytes").path(), {.threads = threads}, 0);
    expect_random_boxes(ZarrFixture("v2/rank2_F").path(), {.threads = threads}, 0);
    expect_random_boxes(ZarrFixture("v2/rank5_F").path(),
                        {.component = 2, .time = 1, .threads = threads}, 5003 + 2 * 1009);
    expect_random_boxes(ZarrFixture("v3/shard_transposed").path(), {.threads = threads}, 0);
    expect_random_boxes(ZarrFixture("v3/shard_nested").path(), {.threads = threads}, 0);
    expect_random_boxes(ZarrFixture("v3/shard_rank5").path(),
                        {.component = 2, .time = 1, .threads = threads}, 5003 + 2 * 1009);
  }
}

TEST(zarr_source, decodes_only_the_chunks_that_a_box_meets) {
  const ZarrFixture fixture("v2/codec_raw");
  for (const char* chunk : {"0.0.1", "0.1.0", "0.1.1"}) fixture.write(chunk, "damaged");
  const auto source = open_volume(fixture.path(), {});
  ASSERT_TRUE(source) << source.error().message;
  expect_box(**source, {{{3, 2, 1}}, {{20, 16, 8}}});
  std::vector<std::byte> out(2 * 2);
  const auto status = (*source)->read({{{19, 0, 0}}, {{21, 1, 1}}}, out);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("0.0.1"), std::string::npos) << status.error().message;
}

TEST(zarr_source, reads_only_the_parts_of_a_shard_that_a_box_meets) {
  const ZarrFixture fixture("v3/shard_raw");
  // Chunks lie backwards behind one another: the last bytes before the index are chunk 0 0 0.
  std::string shard = fixture.read("c/0/0/0");
  constexpr std::size_t kIndexBytes = 4 * 16 + 4;
  const std::size_t first_chunk_at = shard.size() - kIndexBytes - 80;
  for (std::size_t i = 0; i < first_chunk_at; ++i) shard[i] = 'x';
  fixture.write("c/0/0/0", shard);
  const auto source = open_volume(fixture.path(), {});
  ASSERT_TRUE(source) << source.error().message;
  expect_box(**source, {{{1, 0, 0}}, {{5, 4, 2}}});
}

TEST(zarr_source, decodes_a_chunk_once_when_slab_follows_slab) {
  const ZarrFixture fixture("v2/codec_raw");
  const auto source = open_volume(fixture.path(), {});
  ASSERT_TRUE(source) << source.error().message;
  expect_box(**source, {{{0, 0, 0}}, {{30, 24, 2}}});
  // What is held already needs no file any more.
  for (const char* chunk : {"0.0.0", "0.0.1", "0.1.0", "0.1.1"}) fixture.write(chunk, "damaged");
  for (std::int32_t z = 2; z < 8; z += 3) expect_box(**source, {{{0, 0, z}}, {{30, 24, z + 3}}});
}

TEST(zarr_source, says_the_same_error_on_any_number_of_threads) {
  const ZarrFixture fixture("v2/codec_raw");
  for (const char* chunk : {"0.0.1", "0.1.0", "0.1.1"}) fixture.write(chunk, "damaged");
  for (const int n_threads : {1, 2, 5})
    for (int round = 0; round < 20; ++round)
      test::expect_failure(fixture.path(), {"0.0.1: expected 5120 bytes, got 7"},
                           {.threads = Threads{n_threads}});
}

ChunkCache::Bytes bytes_of_size(std::size_t n) {
  return std::make_shared<const std::vector<std::byte>>(n);
}

TEST(chunk_cache, keeps_what_the_current_read_used_and_never_more_than_its_limit) {
  ChunkCache cache(100);
  cache.begin_read();
  cache.add(1, bytes_of_size(40));
  cache.add(2, bytes_of_size(40));
  cache.add(3, bytes_of_size(40));
  EXPECT_EQ(cache.find(3), nullptr);
  cache.begin_read();
  EXPECT_NE(cache.find(1), nullptr);
  cache.add(3, bytes_of_size(60));
  EXPECT_NE(cache.find(1), nullptr);
  EXPECT_EQ(cache.find(2), nullptr);
  EXPECT_NE(cache.find(3), nullptr);
  cache.begin_read();
  cache.add(4, bytes_of_size(101));
  EXPECT_EQ(cache.find(4), nullptr);
  EXPECT_NE(cache.find(1), nullptr);
}

}  // namespace
}  // namespace lode::io
