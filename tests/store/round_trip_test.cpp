#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>

#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/store/test_file.h"

namespace lode::store {
namespace {

std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(store, gives_back_every_block_in_the_order_of_writing) {
  const TestPath path("round_trip.lode");
  const auto blocks = small_blocks();
  write_file(path.str(), blocks);
  const auto reader = Reader::open(path.str());
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_EQ(reader->model(), "test model");
  EXPECT_EQ(text_of(reader->metadata()), "some metadata");
  ASSERT_EQ(reader->blocks().size(), blocks.size());
  std::uint64_t offset = kHeaderBytes;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const BlockEntry& entry = reader->blocks()[i];
    EXPECT_EQ(entry.key, blocks[i].key);
    EXPECT_EQ(entry.offset, offset);
    offset += entry.stored_size;
    EXPECT_EQ(reader->find(blocks[i].key), i);
    const auto raw = reader->read_block(i);
    ASSERT_TRUE(raw) << raw.error().message;
    EXPECT_EQ(*raw, blocks[i].raw);
  }
  EXPECT_EQ(reader->find({9, 9, {{9, 9, 9}}}), std::nullopt);
  EXPECT_EQ(open_and_check(path.str()), "");
}

TEST(store, test_file_uses_every_codec) {
  std::array<bool, kLastCodec + 1> is_used{};
  for (const TestBlock& block : small_blocks())
    is_used[static_cast<std::size_t>(
        encode_block({block.raw, block.element_size, block.grid}).codec)] = true;
  EXPECT_TRUE(std::ranges::all_of(is_used, [](bool used) { return used; }));
}

TEST(store, holds_a_file_without_blocks_or_metadata) {
  const TestPath path("no_blocks.lode");
  auto writer = Writer::create(path.str(), "", {});
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->finish());
  const auto reader = Reader::open(path.str());
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(reader->blocks().empty());
  EXPECT_TRUE(reader->metadata().empty());
  EXPECT_EQ(open_and_check(path.str()), "");
}

/// What comes later in the directory is not there any more.
TEST(reader, names_the_model_by_the_start_of_the_directory) {
  constexpr std::int32_t kBlocks = 20'000;
  constexpr std::size_t kStart = 8 << 10;
  const TestPath path("many_blocks.lode");
  auto writer = Writer::create(path.str(), "of many blocks", to_bytes("metadata"));
  ASSERT_TRUE(writer);
  for (std::int32_t i = 0; i < kBlocks; ++i)
    ASSERT_TRUE(writer->append({1, 0, {{i, 0, 0}}},
                               encode_block({pattern_bytes(Pattern::random, 9 + i % 90, 1), 1})));
  ASSERT_TRUE(writer->finish());
  auto bytes = load_file(path.str());
  const auto directory =
      decode_header(std::span(bytes).first(kHeaderBytes), bytes.size(), path.str());
  ASSERT_TRUE(directory);
  ASSERT_GT(directory->directory_stored_size, 4 * kStart);
  EXPECT_EQ(Reader::model_of(path.str()).value(), "of many blocks");
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(directory->directory_offset + kStart),
            bytes.end(), std::byte{0});
  save_file(path.str(), bytes);
  EXPECT_FALSE(Reader::open(path.str()));
  EXPECT_EQ(Reader::model_of(path.str()).value(), "of many blocks");
}

TEST(reader, names_no_model_of_what_is_no_such_file) {
  const TestPath path("none.lode");
  EXPECT_FALSE(Reader::model_of(path.str()));
  for (const char* const text :
       {"", "text", "long enough to be a header, but a text all the same"}) {
    save_file(path.str(), to_bytes(text));
    EXPECT_FALSE(Reader::model_of(path.str())) << text;
  }
}

TEST(store, keeps_the_metadata_set_last) {
  const TestPath path("metadata.lode");
  auto writer = Writer::create(path.str(), "m", to_bytes("early"));
  ASSERT_TRUE(writer);
  writer->set_metadata(to_bytes("late"));
  ASSERT_TRUE(writer->finish());
  const auto reader = Reader::open(path.str());
  ASSERT_TRUE(reader);
  EXPECT_EQ(text_of(reader->metadata()), "late");
}

TEST(store, writes_the_same_bytes_twice) {
  const TestPath first("same_1.lode");
  const TestPath second("same_2.lode");
  write_file(first.str(), small_blocks());
  write_file(second.str(), small_blocks());
  EXPECT_EQ(load_file(first.str()), load_file(second.str()));
}

TEST(writer, leaves_nothing_without_finish) {
  const TestPath directory("unfinished");
  std::filesystem::create_directory(directory.str());
  {
    auto writer = Writer::create(directory.str() + "/a.lode", "m", {});
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->append({}, encode_block({to_bytes("abc")})));
  }
  EXPECT_TRUE(std::filesystem::is_empty(directory.str()));
}

TEST(writer, refuses_two_blocks_with_one_key_and_leaves_nothing) {
  const TestPath path("twice.lode");
  {
    auto writer = Writer::create(path.str(), "m", {});
    ASSERT_TRUE(writer);
    for (int i = 0; i < 2; ++i)
      ASSERT_TRUE(writer->append({1, 2, {{3, 4, 5}}}, encode_block({to_bytes("abc")})));
    const auto size = writer->finish();
    ASSERT_FALSE(size);
    EXPECT_EQ(size.error().message,
              path.str() +
                  ": expected each block once, got block (kind 1, level 2, position "
                  "3 4 5) at offsets 128 and 131");
  }
  EXPECT_FALSE(std::filesystem::exists(path.str()));
}

TEST(writer, names_an_output_it_cannot_create) {
  const auto writer = Writer::create("/nowhere/at/all.lode", "m", {});
  ASSERT_FALSE(writer);
  EXPECT_TRUE(writer.error().message.starts_with("/nowhere/at/all.lode: "));
}

TEST(reader, serves_many_threads_at_once) {
  const TestPath path("threads.lode");
  std::vector<TestBlock> blocks;
  for (std::int32_t i = 0; i < 100; ++i)
    blocks.push_back({{1, 0, {{i, 0, 0}}},
                      2,
                      pattern_bytes(Pattern::wave, static_cast<std::size_t>(1000 + 2 * i), 2)});
  write_file(path.str(), blocks);
  const auto reader = Reader::open(path.str());
  ASSERT_TRUE(reader) << reader.error().message;
  std::atomic<int> n_wrong{0};
  parallel_for(1000, {.count = 8}, 1, [&](std::size_t i, int) {
    const auto raw = reader->read_block(i % 100);
    if (!raw || *raw != blocks[i % 100].raw) ++n_wrong;
  });
  EXPECT_EQ(n_wrong, 0);
}

TEST(reader, still_reads_after_being_moved) {
  const TestPath path("moved.lode");
  write_file(path.str(), small_blocks());
  auto opened = Reader::open(path.str());
  ASSERT_TRUE(opened);
  Reader reader = std::move(opened).value();
  auto other = Reader::open(path.str());
  ASSERT_TRUE(other);
  *other = std::move(reader);
  EXPECT_EQ(*other->read_block(1), small_blocks()[1].raw);
}

TEST(reader, stops_checking_when_cancelled) {
  const TestPath path("cancelled.lode");
  write_file(path.str(), small_blocks());
  const auto reader = Reader::open(path.str());
  ASSERT_TRUE(reader);
  Progress progress;
  progress.cancel();
  const auto checked = reader->check_all({.count = 1}, progress);
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().message, cancelled_error().message);
}

}  // namespace
}  // namespace lode::store
