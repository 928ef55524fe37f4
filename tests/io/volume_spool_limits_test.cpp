#include "lode/io/text.h"
#include "tests/io/volume_spool_files.h"

namespace lode::io {
namespace {

using test::noise;
using test::read_box;
using test::spooling;
using test::SpoolSeed;
using test::TempDir;

/// A gzipped raw volume whose stream is `bytes` though the layout promises `n` of them.
struct Promise {
  TempDir dir;
  ReadOptions options;
  std::string path;

  Promise(const std::string& compressed, std::int32_t n) : path(dir.write("a.raw.gz", compressed)) {
    std::filesystem::create_directory(dir.path("spool"));
    options = spooling({}, dir.path("spool"));
    options.raw = RawLayout{.dims = {{n, 1, 1}}};
  }

  /// Expects all but the last byte to be there, and the read of that one to fail with `words`.
  void expect_failure_at_the_last_byte(const std::string& words) const {
    const auto source = open_volume(path, options);
    ASSERT_TRUE(source) << source.error().message;
    const std::int32_t n = options.raw->dims[0];
    (void)read_box(**source, {{{0, 0, 0}}, {{n - 1, 1, 1}}});
    std::vector<std::byte> last(1);
    for (int i = 0; i < 2; ++i) {
      const auto status = (*source)->read({{{n - 1, 0, 0}}, {{n, 1, 1}}}, last);
      ASSERT_FALSE(status);
      EXPECT_NE(status.error().message.find(path), std::string::npos) << status.error().message;
      EXPECT_NE(status.error().message.find(words), std::string::npos) << status.error().message;
    }
    (void)read_box(**source, {{{0, 0, 0}}, {{n - 1, 1, 1}}});
    EXPECT_TRUE(std::filesystem::is_empty(dir.path("spool")));
  }
};

TEST(volume_spool_end, says_what_opening_said_when_the_last_byte_is_read) {
  const std::string bytes = noise(300'000);
  std::string damaged = test::gzipped(bytes);
  damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);
  Promise(test::gzipped(bytes), 300'001).expect_failure_at_the_last_byte("hold 300000");
  Promise(test::gzipped(bytes), 299'999).expect_failure_at_the_last_byte("hold more");
  Promise(damaged, 300'000).expect_failure_at_the_last_byte("damaged");
}

TEST(volume_spool_end, refuses_while_opening_what_deflate_cannot_hold) {
  const Promise promise(test::gzipped("x"), 2'000'000'000);
  test::expect_failure(promise.path, {"promises"}, promise.options);
}

TEST(volume_spool_end, names_the_directory_that_is_full) {
  const Promise promise(test::gzipped(noise(600'000)), 600'000);
  const auto source = open_volume(promise.path, promise.options);
  ASSERT_TRUE(source) << source.error().message;
  std::vector<std::byte> out(600'000);
  const test::FileSizeLimit limit(300'000);
  const auto status = (*source)->read({{{0, 0, 0}}, {{600'000, 1, 1}}}, out);
  ASSERT_FALSE(status);
  for (const std::string& part : {promise.path, promise.dir.path("spool"),
                                  std::string("cannot be "
                                              "written")})
    EXPECT_NE(status.error().message.find(part), std::string::npos) << status.error().message;
}

TEST(volume_spool_text, is_refused_beyond_the_limit_with_a_way_out) {
  const TempDir dir;
  std::string numbers;
  for (int i = 0; i < 24; ++i) numbers += fmt::format("{} ", i);
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: ";
  const std::string paths[] = {
      dir.write("a.nrrd", nrrd + "ascii\n\n" + numbers),
      dir.write("b.nrrd", nrrd + "hex\n\n" + std::string(96, 'a')),
      dir.write("a.mha",
                "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nBinaryData = False\n"
                "ElementDataFile = LOCAL\n" +
                    numbers),
      dir.write("a.vtk",
                "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n"
                "DIMENSIONS 4 3 2\nPOINT_DATA 24\nSCALARS v short 1\nLOOKUP_TABLE t\n" +
                    numbers)};
  for (const std::string& path : paths) {
    ReadOptions options;
    options.memory_limit = 48;
    EXPECT_EQ(test::samples_of<std::int16_t>(path, options).size(), 24U);
    options.memory_limit = 47;
    test::expect_failure(path,
                         {" samples of 48 bytes cannot be streamed within a memory limit of 47 "
                          "bytes; convert to raw NRRD"},
                         options);
  }
}

TEST(volume_spool_parts, are_opened_once_to_see_whether_all_are_there) {
  for (const SpoolSeed& seed : test::part_spool_seeds()) {
    const TempDir dir;
    std::string path;
    const test::SpoolFiles files = seed.make_files();
    for (const auto& [name, bytes] : files) path = dir.write(name, bytes);
    const auto& last = files[files.size() - 2];
    std::filesystem::remove(dir.path(last.first));
    const ReadOptions options = spooling({}, dir.path(""));
    const auto gone = open_volume(path, options);
    ASSERT_FALSE(gone);
    EXPECT_NE(gone.error().message.find(last.first + ": cannot be opened"), std::string::npos);
    dir.write(last.first, last.second.substr(0, last.second.size() / 2));
    const auto cut = test::read_volume(path, options);
    ASSERT_FALSE(cut);
    EXPECT_NE(cut.error().message.find(last.first), std::string::npos) << cut.error().message;
  }
}

TEST(volume_spool_parts, of_text_are_refused_beyond_the_limit) {
  const TempDir dir;
  dir.write("a1", "1 2 3 4");
  dir.write("a2", "5 6 7 8");
  const auto path = dir.write("a.nhdr",
                              "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 2\nencoding: text\n"
                              "data file: a%d 1 2 1\n");
  ReadOptions options;
  options.memory_limit = 16;
  EXPECT_EQ(test::samples_of<std::int16_t>(path, options).at(7), 8);
  options.memory_limit = 15;
  const auto source = open_volume(path, options);
  ASSERT_FALSE(source);
  EXPECT_NE(source.error().message.find("text samples of 16 bytes"), std::string::npos);
}

TEST(volume_spool_text, sizes_have_three_digits) {
  EXPECT_EQ(format_bytes(999), "999 bytes");
  EXPECT_EQ(format_bytes(512'000'000), "512 MB");
  EXPECT_EQ(format_bytes(12'400'000'000), "12.4 GB");
  EXPECT_EQ(format_bytes(999'999), "1 MB");
  EXPECT_EQ(format_bytes(std::numeric_limits<std::uint64_t>::max()), "18.4 EB");
}

}  // namespace
}  // namespace lode::io
