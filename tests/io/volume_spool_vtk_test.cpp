#include "lode/io/byte_stream.h"
#include "lode/io/vtk_xml_blocks.h"
#include "tests/io/volume_spool_files.h"

namespace lode::io {
namespace {

using test::kSpoolDims;
using test::noise;
using test::TempDir;

constexpr std::size_t kBytes = std::size_t{2} * 64 * 50 * 48;
const std::string kRaw = "<AppendedData encoding=\"raw\">_";
const std::string kEnd = "</AppendedData>";

/// Reads slices upwards, each of which takes 6400 bytes, until one fails.
std::pair<std::int32_t, std::string> first_failure(VolumeSource& source) {
  std::vector<std::byte> slice(std::size_t{2} * 64 * 50);
  for (std::int32_t z = 0; z < kSpoolDims[2]; ++z) {
    const auto status = source.read({{{0, 0, z}}, {{64, 50, z + 1}}}, slice);
    if (!status) return {z, status.error().message};
  }
  return {kSpoolDims[2], {}};
}

std::unique_ptr<VolumeSource> open_spooling(const std::string& path, const std::string& directory) {
  auto source = open_volume(path, test::spooling({}, directory));
  EXPECT_TRUE(source) << source.error().message;
  return source ? std::move(*source) : nullptr;
}

TEST(volume_spool_vtk, small_blocks_are_decoded_where_they_are_read_without_a_spool) {
  const TempDir dir;
  auto [header, blocks] = test::vtk_blocked(noise(kBytes), 32768);
  blocks[32800] = static_cast<char>(blocks[32800] ^ 0x55);  // the second block's first bytes
  const auto path =
      dir.write("a.vti", test::vtk_image({.root = test::kVtkZlib,
                                          .array = test::kVtkAppended,
                                          .appended = kRaw + header + blocks + kEnd}));
  const auto source = open_spooling(path, "/proc");
  ASSERT_NE(source, nullptr);
  const auto [z, message] = first_failure(*source);
  EXPECT_EQ(z, 32768 / 6400);
  EXPECT_NE(message.find(path), std::string::npos) << message;
  // Other blocks know nothing of it.
  std::vector<std::byte> last(std::size_t{2} * 64 * 50);
  const std::uint64_t before = source->io().n_file_bytes_read;
  EXPECT_TRUE(source->read({{{0, 0, 47}}, {{64, 50, 48}}}, last));
  EXPECT_LT(source->io().n_file_bytes_read - before, 2U * 33000);
}

TEST(volume_spool_vtk, large_blocks_fail_at_the_read_that_reaches_the_damage) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path("spool"));
  auto [header, blocks] = test::vtk_blocked(noise(kBytes), kBytes);
  const auto with = [&](const std::string& data) {
    return dir.write("a.vti", test::vtk_image({.root = test::kVtkZlib,
                                               .array = test::kVtkAppended,
                                               .appended = kRaw + header + data + kEnd}));
  };
  std::string damaged = blocks;
  damaged[damaged.size() - 1] = static_cast<char>(damaged.back() ^ 1);
  const auto source = open_spooling(with(damaged), dir.path("spool"));
  ASSERT_NE(source, nullptr);
  const auto [z, message] = first_failure(*source);
  EXPECT_EQ(z, 47);
  EXPECT_NE(message.find("damaged"), std::string::npos) << message;
  EXPECT_TRUE(std::filesystem::is_empty(dir.path("spool")));
}

TEST(volume_spool_vtk, files_that_are_too_short_are_refused_while_opening) {
  const TempDir dir;
  for (const test::SpoolSeed& seed : test::vtk_spool_seeds()) {
    const auto [name, bytes] = seed.make_files().front();
    const auto path = dir.write(name, bytes.substr(0, bytes.size() / 3 * 2));
    const auto source = open_volume(path, test::spooling({}, dir.path("")));
    ASSERT_FALSE(source) << name;
    EXPECT_NE(source.error().message.find(path), std::string::npos) << source.error().message;
  }
}

TEST(volume_spool_vtk, blocks_of_another_size_than_promised_are_named) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path("spool"));
  const auto [header, blocks] = test::vtk_blocked(noise(kBytes), kBytes);
  const auto short_block = test::zlibbed(noise(kBytes - 1));
  const auto long_block = test::zlibbed(noise(kBytes) + "x");
  for (const std::string& block : {short_block, long_block}) {
    const std::string table = test::bytes_of<std::uint32_t>(
        {1, static_cast<std::uint32_t>(kBytes), 0, static_cast<std::uint32_t>(block.size())});
    const auto path =
        dir.write("a.vti", test::vtk_image({.root = test::kVtkZlib,
                                            .array = test::kVtkAppended,
                                            .appended = kRaw + table + block + kEnd}));
    const auto whole = test::read_volume(path);
    ASSERT_FALSE(whole);
    const auto source = open_spooling(path, dir.path("spool"));
    ASSERT_NE(source, nullptr);
    const auto [z, message] = first_failure(*source);
    EXPECT_EQ(z, 47);
    EXPECT_NE(message.find("expected a compressed block of 307200 bytes, got"), std::string::npos)
        << message;
  }
}

TEST(volume_spool_vtk, base64_fails_at_the_read_that_reaches_a_foreign_character) {
  const TempDir dir;
  std::filesystem::create_directory(dir.path("spool"));
  const std::string counted =
      test::bytes_of<std::uint32_t>({static_cast<std::uint32_t>(kBytes)}) + noise(kBytes);
  std::string text = test::base64(counted);
  text[text.size() / 2 + 100] = '*';
  const auto path = dir.write(
      "a.vti", test::vtk_image({.array = test::kVtkAppended,
                                .appended = "<AppendedData encoding=\"base64\">_" + text + kEnd}));
  const auto source = open_spooling(path, dir.path("spool"));
  ASSERT_NE(source, nullptr);
  const auto [z, message] = first_failure(*source);
  EXPECT_EQ(z, 24);
  EXPECT_NE(message.find("base64 data, got byte 42"), std::string::npos) << message;
}

TEST(volume_spool_vtk, text_and_large_xml_are_refused_beyond_the_limit) {
  const TempDir dir;
  std::string numbers;
  for (std::size_t i = 0; i < kBytes / 2; ++i) numbers += "7 ";
  const auto text = dir.write("a.vti", test::vtk_image({.content = numbers}));
  ReadOptions options;
  options.memory_limit = kBytes - 1;
  test::expect_failure(text, {"text samples of 307 kB", "limit of 307 kB", "raw NRRD"}, options);
  options.memory_limit = kBytes;
  EXPECT_TRUE(test::read_volume(text, options));
  const auto large =
      dir.write("b.vti", test::vtk_image({.content = numbers + std::string(2'000'000, ' ')}));
  test::expect_failure(large, {"XML text of more than 1.05 MB", "307 kB", "raw appended"}, options);
}

TEST(vtk_blocks, may_be_of_any_sizes_that_add_up) {
  // Two empty blocks, then one that is longer than the others.
  const std::string empty = test::zlibbed("");
  const std::string last = test::zlibbed("0123456789");
  const auto size = [](const std::string& block) {
    return static_cast<std::uint32_t>(block.size());
  };
  const std::string data =
      test::bytes_of<std::uint32_t>({3, 0, 10, size(empty), size(empty), size(last)}) + empty +
      empty + last;
  auto stream = make_memory_stream(data, "a");
  const auto blocks = read_vtk_blocks("a", *stream, {}, 10);
  ASSERT_TRUE(blocks) << blocks.error().message;
  EXPECT_FALSE(blocks->are_small());
  const auto decoded = make_vtk_block_stream(std::move(stream), *blocks);
  std::string out(10, '\0');
  ASSERT_TRUE(decoded->read(std::as_writable_bytes(std::span(out))));
  EXPECT_EQ(out, "0123456789");
  EXPECT_EQ(decoded->n_left(), 0U);
}

}  // namespace
}  // namespace lode::io
