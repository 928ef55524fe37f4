// Files without a directory: what indexes say, and what they must not make anybody believe.
#include "lode/store/index_scan.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstring>

#include "lode/store/block_index.h"
#include "lode/store/checksum.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"
#include "tests/store/test_file.h"

namespace lode::store {
namespace {

using Bytes = std::vector<std::byte>;

/// A file of four runs, and what its blocks decode to.
class IndexedTestFile : public testing::Test {
 protected:
  static constexpr std::size_t kBlocksPerRun = 3;

  void SetUp() override {
    auto writer = Writer::create(path_.str(), "test model", to_bytes("late metadata"));
    ASSERT_TRUE(writer);
    writer->set_early_metadata(to_bytes("early metadata"));
    patterns_ = {Pattern::random, Pattern::ramp, Pattern::noise};
    for (std::int32_t run = 0; run < 4; ++run) {
      std::vector<KeyedBlock> blocks;
      for (std::size_t i = 0; i < kBlocksPerRun; ++i) {
        raw_.push_back(pattern_bytes(patterns_[i], 90 + raw_.size(), 2));
        blocks.push_back({{static_cast<std::uint32_t>(1 + i), 2, {{run, -1, 4}}},
                          encode_block({raw_.back(), 2})});
      }
      ASSERT_TRUE(writer->append_run(blocks));
    }
    ASSERT_TRUE(writer->finish());
    bytes_ = load_file(path_.str());
    const auto reader = Reader::open(path_.str());
    ASSERT_TRUE(reader);
    for (const BlockEntry& block : reader->blocks())
      (is_index(block.key) ? indexes_ : blocks_).push_back(block);
    ASSERT_EQ(indexes_.size(), 4U);
    ASSERT_EQ(blocks_.size(), raw_.size());
  }

  [[nodiscard]] Result<Reader> open(const Bytes& bytes) const {
    save_file(path_.str(), bytes);
    return Reader::open(path_.str(), {.length = Length::any});
  }
  /// The first bytes of the file.
  [[nodiscard]] Bytes cut(std::uint64_t n) const {
    return {bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(n)};
  }
  [[nodiscard]] std::uint64_t end_of_blocks() const { return end_of(blocks_); }

  /// How many blocks are found and whole; those are what was written.
  std::size_t count_whole(const Bytes& bytes) const {
    const auto reader = open(bytes);
    if (!reader) return 0;
    EXPECT_TRUE(reader->is_rebuilt());
    EXPECT_EQ(reader->model(), "test model");
    EXPECT_TRUE(std::ranges::equal(reader->metadata(), to_bytes("early metadata")));
    std::size_t n = 0;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const auto at = reader->find(blocks_[i].key);
      if (!at) continue;
      const auto raw = reader->read_block(*at);
      if (!raw) continue;
      EXPECT_EQ(*raw, raw_[i]);
      ++n;
    }
    return n;
  }

  TestPath path_{"indexed.lode"};
  Bytes bytes_;
  std::vector<Pattern> patterns_;
  std::vector<Bytes> raw_;
  std::vector<BlockEntry> indexes_;
  std::vector<BlockEntry> blocks_;
};

using indexed_file = IndexedTestFile;

TEST_F(indexed_file, that_is_whole_needs_no_index) {
  const auto reader = open(bytes_);
  ASSERT_TRUE(reader);
  EXPECT_FALSE(reader->is_rebuilt());
  EXPECT_TRUE(std::ranges::equal(reader->metadata(), to_bytes("late metadata")));
  EXPECT_EQ(open_and_check(path_.str()), "");
}

TEST_F(indexed_file, has_all_blocks_before_the_cut_wherever_it_is_cut) {
  const std::uint64_t first = indexes_[0].offset + indexes_[0].stored_size;
  for (std::uint64_t size = 0; size < bytes_.size(); ++size) {
    if (size < first) {
      const auto reader = open(cut(size));
      ASSERT_FALSE(reader) << size;
      if (size >= kHeaderBytes)
        EXPECT_NE(reader.error().message.find("no index of its blocks is whole"),
                  std::string::npos);
      continue;
    }
    std::size_t n = 0;
    for (const BlockEntry& block : blocks_) n += block.offset + block.stored_size <= size ? 1 : 0;
    ASSERT_EQ(count_whole(cut(size)), n) << size;
    EXPECT_FALSE(Reader::open(path_.str()));
  }
}

TEST_F(indexed_file, loses_a_run_with_its_index) {
  for (const BlockEntry& index : indexes_)
    for (std::uint64_t i = 0; i < index.stored_size; ++i) {
      Bytes damaged = cut(end_of_blocks());
      damaged[index.offset + i] ^= std::byte{0x20};
      ASSERT_EQ(count_whole(damaged), blocks_.size() - kBlocksPerRun) << index.offset + i;
    }
}

TEST_F(indexed_file, with_a_damaged_header_or_directory_has_all_its_blocks) {
  for (const std::size_t at : {std::size_t{12}, std::size_t{60}, bytes_.size() - 3}) {
    Bytes damaged = bytes_;
    damaged[at] ^= std::byte{4};
    EXPECT_EQ(count_whole(damaged), blocks_.size()) << at;
  }
  Bytes newer = cut(end_of_blocks());
  patch_header(newer, 8, std::uint32_t{3});
  EXPECT_FALSE(open(newer));
  newer = cut(end_of_blocks());
  patch_header(newer, 16, std::uint64_t{0x80});
  EXPECT_FALSE(open(newer));
}

TEST_F(indexed_file, is_not_searched_where_an_index_says_that_blocks_lie) {
  // A field whose samples are a file: its marks are data, even at their right place.
  const auto run_of = [&](const BlockEntry& block) {
    return encode_directory({"test model", to_bytes("early metadata"), {block}});
  };
  const std::uint64_t n = encode_index(run_of({.key = {9, 9, {}}}), 1000).size();
  const BlockEntry data{.key = {1, 0, {}}, .stored_size = n, .raw_size = n};
  Bytes file = cut(kHeaderBytes);
  for (const bool is_listed : {true, false}) {
    file.resize(kHeaderBytes);
    const Bytes index = encode_index(run_of(data), file.size());
    file.insert(file.end(), index.begin(), index.end());
    if (!is_listed) file[kHeaderBytes + 20] ^= std::byte{1};
    const Bytes fake = encode_index(run_of({.key = {9, 9, {}}}), file.size());
    ASSERT_EQ(fake.size(), n);
    file.insert(file.end(), fake.begin(), fake.end());
    const auto reader = open(file);
    ASSERT_TRUE(reader);
    EXPECT_EQ(reader->find({1, 0, {}}).has_value(), is_listed);
    EXPECT_EQ(reader->find({9, 9, {}}).has_value(), !is_listed);
  }
}

/// Bytes after the runs, without a directory.
class lying_index : public IndexedTestFile {
 protected:
  [[nodiscard]] Directory run_of(std::vector<BlockEntry> blocks) const {
    return {"test model", to_bytes("early metadata"), std::move(blocks)};
  }
  void expect_ignored(const Bytes& index) {
    Bytes damaged = cut(end_of_blocks());
    damaged.insert(damaged.end(), index.begin(), index.end());
    EXPECT_EQ(count_whole(damaged), blocks_.size());
    const auto reader = open(damaged);
    ASSERT_TRUE(reader);
    EXPECT_EQ(reader->blocks().size(), blocks_.size());
  }
  /// An index with one number of its head replaced, and the head's checksum made right again.
  [[nodiscard]] Bytes with_number(std::size_t i, std::uint64_t value) const {
    Bytes index = encode_index(encode_directory(run_of({{.key = {9, 9, {}}}})), end_of_blocks());
    std::memcpy(index.data() + 16 + 8 * i, &value, sizeof(value));
    const std::uint64_t sum = checksum(std::span(index).first(48));
    std::memcpy(index.data() + 48, &sum, sizeof(sum));
    return index;
  }
};

TEST_F(lying_index, about_its_place_or_length_is_ignored) {
  for (std::size_t i = 0; i < 4; ++i)
    for (const std::uint64_t value :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << 40, std::uint64_t{1} << 63,
          UINT64_MAX, UINT64_MAX - 60, UINT64_MAX - end_of_blocks()})
      expect_ignored(with_number(i, value));
}

TEST_F(lying_index, of_another_model_or_of_known_keys_is_ignored) {
  const std::vector<BlockEntry> blocks{{.key = {9, 9, {}}}};
  Directory run = run_of(blocks);
  run.model = "another";
  expect_ignored(encode_index(encode_directory(run), end_of_blocks()));
  run = run_of(blocks);
  run.metadata.pop_back();
  expect_ignored(encode_index(encode_directory(run), end_of_blocks()));
  run = run_of({blocks_[4], blocks_[0]});
  expect_ignored(encode_index(encode_directory(run), end_of_blocks()));
}

TEST_F(lying_index, about_blocks_gives_none_or_such_as_cannot_be_read) {
  BlockEntry block{.key = {9, 9, {}}, .stored_size = 1000, .raw_size = 1000};
  const auto with = [&](auto change) {
    BlockEntry changed = block;
    change(changed);
    return encode_index(encode_directory(run_of({changed})), end_of_blocks());
  };
  expect_ignored(with([](BlockEntry& b) { b.raw_size = b.stored_size = kMaxBlockBytes + 1; }));
  expect_ignored(with([](BlockEntry& b) { b.stored_size = UINT64_MAX; }));
  expect_ignored(with([](BlockEntry& b) { b.codec = Codec{9}; }));
  expect_ignored(with([](BlockEntry& b) { b.element_size = 3; }));
  expect_ignored(with([](BlockEntry& b) {
    b.codec = Codec::zstd;
    b.stored_size = 1;
    b.raw_size = 2 * kMaxZstdRatio;
  }));
  Bytes damaged = cut(end_of_blocks());
  const Bytes index = with([](BlockEntry&) {});
  damaged.insert(damaged.end(), index.begin(), index.end());
  const auto reader = open(damaged);
  ASSERT_TRUE(reader);
  const auto read = reader->read_block(reader->find(block.key).value());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("truncated"), std::string::npos);
}

TEST_F(lying_index, said_ten_thousand_times_takes_little_memory_and_time) {
  Bytes damaged = cut(end_of_blocks());
  const std::size_t begin = damaged.size();
  for (int i = 0; i < 10'000; ++i) {
    // Each claims all that follows it.
    Bytes head = with_number(0, damaged.size());
    head.resize(kIndexHeadBytes);
    const std::uint64_t size = (10'000 - static_cast<std::uint64_t>(i) - 1) * kIndexHeadBytes;
    std::memcpy(head.data() + 24, &size, sizeof(size));
    std::memcpy(head.data() + 32, &size, sizeof(size));
    const std::uint64_t sum = checksum(std::span(head).first(48));
    std::memcpy(head.data() + 48, &sum, sizeof(sum));
    damaged.insert(damaged.end(), head.begin(), head.end());
  }
  ASSERT_EQ(damaged.size() - begin, 10'000 * kIndexHeadBytes);
  rusage before{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_EQ(count_whole(damaged), blocks_.size());
  rusage after{};
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 16 << 10);
}

TEST(index_scan, finds_an_index_wherever_it_lies_in_what_is_read_at_once) {
  const Directory run{"m", {}, {{.key = {1, 0, {}}}}};
  constexpr std::size_t kWindow = std::size_t{1} << 20;
  for (std::size_t shift = 0; shift < 80; shift += 3) {
    const std::size_t place = kHeaderBytes + kWindow - 70 + shift;
    Bytes file(place, std::byte{0x8B});
    const Bytes index = encode_index(encode_directory(run), place);
    file.insert(file.end(), index.begin(), index.end());
    const Directory found =
        scan_indexes({.path = "file",
                      .size = file.size(),
                      .memory_limit = 1 << 20,
                      .read_at = [&](std::uint64_t at, std::span<std::byte> to) -> Result<void> {
                        std::memcpy(to.data(), file.data() + at, to.size());
                        return {};
                      }});
    EXPECT_EQ(found.blocks.size(), 1U) << shift;
  }
}

}  // namespace
}  // namespace lode::store
