#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <functional>

#include "lode/store/bytes.h"
#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/directory.h"
#include "lode/store/header.h"
#include "lode/store/reader.h"
#include "tests/sanitized.h"
#include "tests/store/test_file.h"

namespace lode::store {
namespace {

/// A small valid file, in memory and on disk, to be damaged.
class DamagedFile : public testing::Test {
 protected:
  void SetUp() override {
    write_file(path_.str(), small_blocks());
    bytes_ = load_file(path_.str());
    ASSERT_EQ(open_and_check(path_.str()), "");
  }

  std::string check(const std::vector<std::byte>& bytes) {
    save_file(path_.str(), bytes);
    return open_and_check(path_.str());
  }
  void expect_error(const std::vector<std::byte>& bytes, const std::string& part) {
    const std::string message = check(bytes);
    EXPECT_TRUE(message.starts_with(path_.str() + ": ")) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }

  TestPath path_{"damaged.lode"};
  std::vector<std::byte> bytes_;
};

using damaged_file = DamagedFile;

TEST_F(damaged_file, is_detected_whichever_byte_is_flipped) {
  for (std::size_t i = 0; i < bytes_.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xFF}) {
      auto flipped = bytes_;
      flipped[i] ^= static_cast<std::byte>(mask);
      EXPECT_TRUE(check(flipped).starts_with(path_.str() + ": ")) << "byte " << i;
    }
}

/// What it says may be wrong, but is said, or refused, all the same.
TEST_F(damaged_file, names_its_model_or_not_whichever_byte_is_flipped) {
  ASSERT_EQ(Reader::model_of(path_.str()).value(), "test model");
  std::size_t n_refused = 0;
  for (std::size_t i = 0; i < bytes_.size(); ++i)
    for (const int mask : {0x01, 0x80, 0xFF}) {
      auto flipped = bytes_;
      flipped[i] ^= static_cast<std::byte>(mask);
      save_file(path_.str(), flipped);
      const auto model = Reader::model_of(path_.str());
      n_refused += model ? 0 : 1;
      if (i < kHeaderBytes) EXPECT_FALSE(model) << "byte " << i;
      if (!model) EXPECT_TRUE(model.error().message.starts_with(path_.str() + ": ")) << i;
    }
  EXPECT_GE(n_refused, 3 * kHeaderBytes);
}

TEST_F(damaged_file, is_detected_wherever_it_is_truncated) {
  for (std::size_t size = 0; size < bytes_.size(); ++size) {
    const auto reader = [&] {
      save_file(path_.str(), std::span(bytes_).first(size));
      EXPECT_FALSE(Reader::model_of(path_.str())) << size;
      return Reader::open(path_.str());
    }();
    ASSERT_FALSE(reader) << size;
    EXPECT_TRUE(reader.error().message.starts_with(path_.str() + ": ")) << size;
  }
}

/// Blocks of 100 kB and more, of every codec, and where each ends.
class LargeDamagedFile : public DamagedFile {
 protected:
  void SetUp() override {
    std::vector<TestBlock> blocks;
    for (const Pattern pattern : {Pattern::constant, Pattern::ramp, Pattern::random, Pattern::wave})
      for (const std::size_t element_size : {1, 4})
        blocks.push_back({{1, 0, {{static_cast<std::int32_t>(blocks.size()), 0, 0}}},
                          element_size,
                          pattern_bytes(pattern, 100'000 + blocks.size(), element_size)});
    write_file(path_.str(), blocks);
    bytes_ = load_file(path_.str());
    const auto reader = Reader::open(path_.str());
    ASSERT_TRUE(reader);
    for (const BlockEntry& block : reader->blocks())
      ends_.push_back(block.offset + block.stored_size);
    ASSERT_EQ(open_and_check(path_.str()), "");
    before_ = peak_kilobytes();
  }
  void TearDown() override {
    // Of a megabyte decoded, whatever the damage says.
    if (LODE_IS_SANITIZED == 0) EXPECT_LT(peak_kilobytes() - before_, 16 << 10);
  }
  void expect_named_error(std::span<const std::byte> damaged, const std::string& damage) {
    const std::string message = check({damaged.begin(), damaged.end()});
    EXPECT_TRUE(message.starts_with(path_.str() + ": ")) << damage << ": " << message;
  }
  void expect_flip_is_noticed(std::size_t at) {
    bytes_[at] ^= std::byte{0x10};
    expect_named_error(bytes_, fmt::format("byte {}", at));
    bytes_[at] ^= std::byte{0x10};
  }
  /// The most memory this process ever held.
  static std::int64_t peak_kilobytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
  }

  std::vector<std::uint64_t> ends_;
  std::int64_t before_ = 0;
};

using large_damaged_file = LargeDamagedFile;

TEST_F(large_damaged_file, is_detected_whichever_byte_of_header_and_directory_is_flipped) {
  for (std::size_t i = 0; i < kHeaderBytes; ++i) expect_flip_is_noticed(i);
  for (std::size_t i = ends_.back(); i < bytes_.size(); ++i) expect_flip_is_noticed(i);
}

TEST_F(large_damaged_file, is_detected_by_its_blocks_wherever_one_is_flipped) {
  std::size_t begin = kHeaderBytes;
  for (const std::uint64_t end : ends_) {
    for (std::size_t i = begin; i < end; i += 1 + (end - begin) / 16) expect_flip_is_noticed(i);
    expect_flip_is_noticed(end - 1);
    begin = end;
  }
}

TEST_F(large_damaged_file, is_detected_where_it_is_cut_at_the_end_of_any_block) {
  for (const std::uint64_t end : ends_)
    for (const std::size_t n : {end - 1, end, end + 1})
      expect_named_error(std::span(bytes_).first(n), fmt::format("{} bytes", n));
}

TEST_F(damaged_file, says_what_is_wrong_with_its_start) {
  expect_error({}, "got an empty file");
  expect_error(to_bytes("NRRD0004\ntype: float"), "not a .lode file");
  expect_error({bytes_.begin(), bytes_.begin() + 5}, "truncated");
  auto text_mode = bytes_;
  text_mode.erase(text_mode.begin() + 4);
  expect_error(text_mode, "text mode");
}

TEST_F(damaged_file, says_how_long_it_should_be) {
  auto longer = bytes_;
  longer.push_back(std::byte{0});
  expect_error(longer, fmt::format("expected {} bytes, as its header says, got {}: the file has "
                                   "bytes after its end",
                                   bytes_.size(), bytes_.size() + 1));
  expect_error({bytes_.begin(), bytes_.end() - 1}, "the file is truncated");
}

TEST_F(damaged_file, of_any_length_is_read_as_far_as_it_is_there_if_that_is_asked_for) {
  const auto n_read = [&](const std::vector<std::byte>& bytes) -> std::ptrdiff_t {
    save_file(path_.str(), bytes);
    const auto reader = Reader::open(path_.str(), {.length = Length::any});
    if (!reader) return -1;
    std::ptrdiff_t n = 0;
    for (std::size_t i = 0; i < reader->blocks().size(); ++i) n += reader->read_block(i) ? 1 : 0;
    return n;
  };
  const auto all = Reader::open(path_.str());
  ASSERT_TRUE(all);
  const auto n = static_cast<std::ptrdiff_t>(all->blocks().size());
  EXPECT_EQ(n_read(bytes_), n);
  auto longer = bytes_;
  longer.resize(longer.size() + 1000);
  EXPECT_EQ(n_read(longer), n);
  for (const BlockEntry& block : all->blocks()) {
    if (block.stored_size < 2) continue;
    const auto inside = static_cast<std::ptrdiff_t>(block.offset) + 1;
    auto shorter = bytes_;
    shorter.erase(shorter.begin() + inside);
    EXPECT_EQ(n_read(shorter), n - 1) << block.offset;
    auto wider = bytes_;
    wider.insert(wider.begin() + inside, 5, std::byte{7});
    EXPECT_EQ(n_read(wider), n - 1) << block.offset;
  }
  for (std::size_t size = 0; size < bytes_.size(); ++size)
    EXPECT_EQ(n_read({bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(size)}), -1);
}

TEST_F(damaged_file, whose_length_is_a_lie_takes_no_memory) {
  patch_header(bytes_, 24, std::uint64_t{1} << 60);
  patch_header(bytes_, 32, (std::uint64_t{1} << 60) - 100);
  patch_header(bytes_, 40, std::uint64_t{100});
  save_file(path_.str(), bytes_);
  const auto reader = Reader::open(path_.str(), {.length = Length::any});
  ASSERT_FALSE(reader);
  EXPECT_NE(reader.error().message.find("truncated"), std::string::npos);
}

TEST_F(damaged_file, names_the_block_the_offset_and_the_checksums) {
  bytes_[kHeaderBytes] ^= std::byte{1};
  expect_error(bytes_,
               "block (kind 1, level 3, position 0 0 0) at offset 128: damaged: expected "
               "checksum ");
}

TEST_F(damaged_file, reports_the_first_of_several_faults_for_any_number_of_threads) {
  const auto reader = Reader::open(path_.str());
  ASSERT_TRUE(reader);
  for (const BlockEntry& block : reader->blocks())
    if (block.offset > kHeaderBytes && block.stored_size > 0) bytes_[block.offset] ^= std::byte{4};
  save_file(path_.str(), bytes_);
  const auto opened = Reader::open(path_.str());
  ASSERT_TRUE(opened);
  for (int threads = 1; threads <= 4; ++threads) {
    Progress progress;
    const auto checked = opened->check_all({.count = threads}, progress);
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message.find("level 2, position -5 70000 2)"), std::string::npos);
  }
}

TEST_F(damaged_file, is_not_mistaken_for_a_newer_version) {
  bytes_[8] = std::byte{7};
  expect_error(bytes_, "header is damaged");
}

TEST_F(damaged_file, fails_when_it_shrinks_after_opening) {
  const auto reader = Reader::open(path_.str());
  ASSERT_TRUE(reader);
  std::filesystem::resize_file(path_.str(), kHeaderBytes);
  EXPECT_FALSE(reader->read_block(0));
  Progress progress;
  EXPECT_FALSE(reader->check_all({.count = 2}, progress));
}

TEST_F(damaged_file, of_a_newer_version_asks_for_an_update) {
  patch_header(bytes_, 8, std::uint32_t{7});
  expect_error(bytes_, "format version 7, this program reads version 2: update lode");
}

TEST_F(damaged_file, of_version_1_asks_to_be_built_again) {
  patch_header(bytes_, 8, std::uint32_t{1});
  expect_error(bytes_, "format version 1, this program reads version 2: build the file again");
}

TEST_F(damaged_file, with_unknown_features_asks_for_an_update) {
  patch_header(bytes_, 16, std::uint64_t{0x120});
  expect_error(bytes_, "made by a newer version: feature bits 0x120 unknown");
}

TEST_F(damaged_file, with_lies_in_its_header_is_refused_without_large_allocations) {
  for (const std::size_t offset : {24, 32, 40, 48})
    for (const std::uint64_t lie :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{127}, bytes_.size() - 1,
          bytes_.size() + 1, std::uint64_t{1} << 40, std::uint64_t{1} << 63, UINT64_MAX}) {
      auto lying = bytes_;
      patch_header(lying, offset, lie);
      EXPECT_NE(check(lying), "") << offset << ' ' << lie;
    }
}

/// A directory of one block of four stored bytes, changed by `change`, in a file that is right
/// in all else.
std::vector<std::byte> forge(const std::function<void(BlockEntry&)>& change,
                             std::uint64_t n_said = 1) {
  const std::vector<std::byte> stored = to_bytes("abcd");
  BlockEntry block{.key = {1, 2, {{3, 4, 5}}},
                   .offset = kHeaderBytes,
                   .stored_size = 4,
                   .raw_size = 4,
                   .checksum = checksum(stored),
                   .codec = Codec::none,
                   .element_size = 1};
  change(block);
  auto directory = encode_directory({"m", {}, {block}});
  // A string of one, its length, the length of the metadata: then the number of blocks.
  std::memcpy(directory.data() + 4 + 1 + 8, &n_said, sizeof(n_said));
  return forge_file(stored, directory);
}

TEST_F(damaged_file, with_lies_in_its_directory_is_refused) {
  EXPECT_EQ(check(forge([](BlockEntry&) {})), "");
  expect_error(forge([](BlockEntry& b) { b.raw_size = 5; }), "cannot make 5 bytes");
  expect_error(forge([](BlockEntry& b) { b.raw_size = kMaxBlockBytes + 1; }), "expected at most");
  expect_error(forge([](BlockEntry& b) { b.codec = static_cast<Codec>(9); }), "got 9");
  expect_error(forge([](BlockEntry& b) { b.element_size = 3; }), "got 3");
  expect_error(forge([](BlockEntry& b) { b.stored_size = b.raw_size = 5; }),
               "before the directory");
  expect_error(forge([](BlockEntry& b) { b.stored_size = b.raw_size = 3; }),
               "expected the blocks to end at the directory, offset 132, got 131");
  expect_error(forge([](BlockEntry& b) {
                 b.codec = Codec::zstd;
                 b.raw_size = kMaxBlockBytes;
               }),
               "cannot make 67108864 bytes of 4 stored ones");
  expect_error(forge([](BlockEntry& b) {
                 b.codec = Codec::zstd;
                 b.raw_size = 100;
               }),
               "expected a zstd frame");
  expect_error(forge([](BlockEntry&) {}, 2), "for each of 2 blocks");
  expect_error(forge([](BlockEntry&) {}, UINT64_MAX), "directory: expected");
}

TEST_F(damaged_file, with_a_key_twice_is_refused) {
  BlockEntry block;
  block.key = {1, 0, {{1, 1, 1}}};
  const auto directory = encode_directory({"m", {}, {block, block}});
  expect_error(forge_file({}, directory), "expected each block once");
}

TEST_F(damaged_file, with_a_truncated_directory_is_refused_at_every_length) {
  BlockEntry block;
  const auto directory = encode_directory({"model", to_bytes("meta"), {block}});
  for (std::size_t size = 0; size < directory.size(); ++size)
    EXPECT_NE(check(forge_file({}, std::span(directory).first(size))), "") << size;
  auto longer = directory;
  longer.push_back(std::byte{0});
  EXPECT_NE(check(forge_file({}, longer)), "");
}

TEST(reader, refuses_what_is_not_a_regular_file) {
  const TestPath path("not_a_file");
  const auto absent = Reader::open(path.str());
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().message, path.str() + ": cannot open: No such file or directory");
  std::filesystem::create_directory(path.str());
  const auto directory = Reader::open(path.str());
  ASSERT_FALSE(directory);
  EXPECT_EQ(directory.error().message, path.str() + ": expected a .lode file, got a directory");
  std::filesystem::remove(path.str());
  ASSERT_EQ(::mkfifo(path.str().c_str(), 0600), 0);
  EXPECT_FALSE(Reader::open(path.str()));
}

TEST(reader, keeps_within_the_memory_limit) {
  const TestPath path("limit.lode");
  const std::vector<TestBlock> blocks = {{{}, 1, std::vector<std::byte>(100000)}};
  write_file(path.str(), blocks);
  const auto tight = Reader::open(path.str(), {.memory_limit = 16});
  ASSERT_FALSE(tight);
  EXPECT_NE(tight.error().message.find("memory limit of 16 bytes"), std::string::npos);
  const auto reader = Reader::open(path.str(), {.memory_limit = 99999});
  ASSERT_TRUE(reader) << reader.error().message;
  const auto raw = reader->read_block(0);
  ASSERT_FALSE(raw);
  EXPECT_NE(raw.error().message.find("memory limit of 99999 bytes, got 100000"), std::string::npos);
  EXPECT_TRUE(Reader::open(path.str(), {.memory_limit = 100000})->read_block(0));
}

}  // namespace
}  // namespace lode::store
