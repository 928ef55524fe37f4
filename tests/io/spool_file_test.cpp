#include "lode/io/spool_file.h"

#include <random>

#include "lode/io/packed_spool.h"
#include "tests/io/volume_spool_files.h"

namespace lode::io {
namespace {

using test::TempDir;

std::vector<std::byte> numbered(std::size_t n) {
  std::vector<std::byte> bytes(n);
  for (std::size_t i = 0; i < n; ++i) bytes[i] = static_cast<std::byte>(i * 2654435761U >> 24);
  return bytes;
}

class spool_file : public testing::TestWithParam<SpoolFile::Birth> {};

TEST_P(spool_file, gives_back_what_was_appended_in_any_pieces) {
  const TempDir dir;
  const auto tally = std::make_shared<IoTally>();
  auto spool = SpoolFile::create(dir.path(""), tally, GetParam());
  ASSERT_TRUE(spool) << spool.error().message;
  const auto bytes = numbered(500'000);
  std::size_t done = 0;
  for (std::size_t piece = 1; done < bytes.size(); piece = piece * 3 % 100'003) {
    const std::size_t n = std::min(piece, bytes.size() - done);
    ASSERT_TRUE(spool->append(std::span(bytes).subspan(done, n)));
    done += n;
    ASSERT_EQ(spool->size(), done);
    std::vector<std::byte> last(std::min<std::size_t>(done, 70'000));
    ASSERT_TRUE(spool->read(done - last.size(), last));
    ASSERT_TRUE(std::equal(last.begin(), last.end(), bytes.data() + done - last.size()));
  }
  std::vector<std::byte> all(bytes.size());
  ASSERT_TRUE(spool->read(0, all));
  EXPECT_EQ(all, bytes);
  EXPECT_LE(tally->n_spool_bytes_written, bytes.size());
  EXPECT_GE(tally->n_spool_bytes_written + 70'000, bytes.size());
}

TEST_P(spool_file, has_no_name) {
  const TempDir dir;
  auto spool = SpoolFile::create(dir.path(""), std::make_shared<IoTally>(), GetParam());
  ASSERT_TRUE(spool) << spool.error().message;
  ASSERT_TRUE(spool->append(numbered(300'000)));
  EXPECT_TRUE(std::filesystem::is_empty(dir.path("")));
}

TEST_P(spool_file, names_the_directory_that_takes_no_file) {
  const TempDir dir;
  const std::string directories[] = {dir.path("gone"), dir.write("file", "x"), "/proc"};
  for (const std::string& directory : directories) {
    const auto spool = SpoolFile::create(directory, std::make_shared<IoTally>(), GetParam());
    ASSERT_FALSE(spool) << directory;
    EXPECT_NE(spool.error().message.find(directory), std::string::npos) << spool.error().message;
  }
}

TEST_P(spool_file, names_the_directory_when_it_is_full_and_keeps_what_fitted) {
  const TempDir dir;
  auto spool = SpoolFile::create(dir.path(""), std::make_shared<IoTally>(), GetParam());
  ASSERT_TRUE(spool) << spool.error().message;
  const auto bytes = numbered(400'000);
  ASSERT_TRUE(spool->append(bytes));
  {
    const test::FileSizeLimit limit(500'000);
    const auto status = spool->append(bytes);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find(dir.path("")), std::string::npos)
        << status.error().message;
    EXPECT_NE(status.error().message.find("cannot be written"), std::string::npos);
  }
  EXPECT_EQ(spool->size(), bytes.size());
  std::vector<std::byte> kept(bytes.size());
  ASSERT_TRUE(spool->read(0, kept));
  EXPECT_EQ(kept, bytes);
}

INSTANTIATE_TEST_SUITE_P(births, spool_file,
                         testing::Values(SpoolFile::Birth::nameless_if_possible,
                                         SpoolFile::Birth::unlinked));

/// Bytes that shrink in some blocks and do not in others.
std::vector<std::byte> partly_random(std::size_t n) {
  std::vector<std::byte> bytes(n);
  std::mt19937 random(20261123);
  for (std::size_t i = 0; i < n; ++i)
    bytes[i] = static_cast<std::byte>(i / 150'000 % 2 == 0 ? i / 100 : random() >> 24);
  return bytes;
}

TEST(packed_spool, gives_back_what_was_appended_in_any_pieces_and_writes_less) {
  const TempDir dir;
  const auto tally = std::make_shared<IoTally>();
  auto spool = PackedSpool::create(dir.path(""), tally);
  ASSERT_TRUE(spool) << spool.error().message;
  const auto bytes = partly_random(1'000'000);
  std::mt19937 random(7);
  std::size_t done = 0;
  for (std::size_t piece = 1; done < bytes.size(); piece = piece * 3 % 200'003) {
    const std::size_t n = std::min(piece, bytes.size() - done);
    ASSERT_TRUE(spool->append(std::span(bytes).subspan(done, n)));
    done += n;
    ASSERT_EQ(spool->size(), done);
    for (int i = 0; i < 5; ++i) {
      const std::size_t begin = random() % done;
      std::vector<std::byte> some(random() % (done - begin + 1));
      ASSERT_TRUE(spool->read(begin, some));
      ASSERT_TRUE(std::equal(some.begin(), some.end(), bytes.data() + begin));
    }
  }
  std::vector<std::byte> all(bytes.size());
  ASSERT_TRUE(spool->read(0, all));
  EXPECT_EQ(all, bytes);
  EXPECT_LT(tally->n_spool_bytes_written, bytes.size() * 2 / 3);
  EXPECT_TRUE(std::filesystem::is_empty(dir.path("")));
}

TEST(packed_spool, names_the_directory_when_it_is_full_and_keeps_what_fitted) {
  const TempDir dir;
  auto spool = PackedSpool::create(dir.path(""), std::make_shared<IoTally>());
  ASSERT_TRUE(spool) << spool.error().message;
  std::vector<std::byte> bytes(400'000);
  std::mt19937 random(20261123);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random() >> 24);
  ASSERT_TRUE(spool->append(bytes));
  {
    const test::FileSizeLimit limit(500'000);
    const auto status = spool->append(bytes);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find(dir.path("")), std::string::npos)
        << status.error().message;
  }
  ASSERT_GE(spool->size(), bytes.size());
  std::vector<std::byte> kept(bytes.size());
  ASSERT_TRUE(spool->read(0, kept));
  EXPECT_EQ(kept, bytes);
  std::vector<std::byte> more(static_cast<std::size_t>(spool->size()) - bytes.size());
  ASSERT_TRUE(spool->read(bytes.size(), more));
  EXPECT_TRUE(std::equal(more.begin(), more.end(), bytes.begin()));
}

}  // namespace
}  // namespace lode::io
