#include "tests/store/test_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/header.h"
#include "lode/store/writer.h"

namespace lode::store {

TestPath::TestPath(const std::string& name)
    : path_((std::filesystem::temp_directory_path() /
             fmt::format("lode_store_{}_{}", ::getpid(), name))
                .string()) {}

TestPath::~TestPath() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::byte> pattern_bytes(Pattern pattern, std::size_t n_bytes,
                                     std::size_t element_size) {
  std::vector<std::byte> bytes(n_bytes);
  std::mt19937_64 random(n_bytes * 8 + element_size);
  for (std::size_t i = 0; i < n_bytes; i += element_size) {
    const auto index = static_cast<double>(i / element_size);
    std::uint64_t value = 0;
    switch (pattern) {
      case Pattern::constant: value = 0x0807060504030201; break;
      case Pattern::ramp: value = 1000000000000 - 3 * (i / element_size); break;
      case Pattern::random: value = random(); break;
      case Pattern::noise: value = 0x4142434445464700 + random() % 200; break;
      case Pattern::wave:
        value = static_cast<std::uint64_t>(std::llround(100 * std::sin(index / 20)) +
                                           static_cast<std::int64_t>(random() % 4));
        break;
    }
    std::memcpy(bytes.data() + i, &value, std::min(element_size, n_bytes - i));
  }
  return bytes;
}

std::vector<std::byte> grid_bytes(const ElementGrid& grid, std::size_t element_size) {
  std::vector<std::byte> bytes;
  std::mt19937_64 random(grid.n_elements());
  for (int z = 0; z < grid.n[2]; ++z)
    for (int y = 0; y < grid.n[1]; ++y)
      for (int x = 0; x < grid.n[0]; ++x) {
        if (grid.lacks_even_points && ((x | y | z) & 1) == 0) continue;
        const double wave =
            60 * std::sin(0.1 * x) + 40 * std::cos(0.2 * y) + 20 * std::sin(0.3 * z);
        const auto value = static_cast<std::uint64_t>(std::llround(wave)) + random() % 2;
        for (std::size_t b = 0; b < element_size; ++b)
          bytes.push_back(static_cast<std::byte>(value >> (8 * b) & 0xFF));
      }
  return bytes;
}

std::vector<std::byte> few_values(const ElementGrid& grid, std::size_t element_size) {
  const auto levels = grid_bytes(grid, 1);
  std::vector<std::byte> bytes(levels.size() * element_size);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double value = 0.1 * (static_cast<int>(levels[i]) / 16);
    const auto narrow = static_cast<float>(value);
    if (element_size == sizeof(double))
      std::memcpy(bytes.data() + i * sizeof(double), &value, sizeof(double));
    else
      std::memcpy(bytes.data() + i * element_size, &narrow, element_size);
  }
  return bytes;
}

std::vector<TestBlock> small_blocks() {
  constexpr ElementGrid kWhole{{9, 6, 3}};
  constexpr ElementGrid kLacking{{6, 17, 2}, true};
  return {
      {{1, 3, {{0, 0, 0}}}, 1, pattern_bytes(Pattern::constant, 300, 1)},
      {{1, 2, {{-5, 70000, 2}}}, 2, pattern_bytes(Pattern::ramp, 401, 2)},
      {{1, 2, {{-5, 70000, -2}}}, 4, pattern_bytes(Pattern::wave, 403, 4)},
      {{0, 0, {{1, 2, 3}}}, 8, pattern_bytes(Pattern::random, 77, 8)},
      {{2, 0, {{0, 0, 0}}}, 1, {}},
      {{2, 0, {{0, 0, 1}}}, 8, pattern_bytes(Pattern::noise, 323, 8)},
      {{7, 0, {{0, 1, 0}}}, 4, pattern_bytes(Pattern::constant, 513, 4)},
      {{8, 0, {{0, 0, 0}}}, 1, grid_bytes(kWhole, 1), kWhole},
      {{8, 1, {{0, 0, 0}}}, 2, grid_bytes(kLacking, 2), kLacking},
      {{8, 2, {{0, 0, 0}}}, 4, grid_bytes(kLacking, 4), kLacking},
      {{8, 3, {{0, 0, 0}}}, 8, grid_bytes(kWhole, 8), kWhole},
      {{9, 0, {{0, 0, 0}}}, 4, few_values(kLacking, 4), kLacking},
      {{9, 1, {{0, 0, 0}}}, 8, few_values(kWhole, 8), kWhole},
  };
}

std::vector<std::byte> to_bytes(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void write_file(const std::string& path, std::span<const TestBlock> blocks) {
  auto writer = Writer::create(path, "test model", to_bytes("some metadata"));
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  for (const TestBlock& block : blocks)
    ASSERT_TRUE(
        writer->append(block.key, encode_block({block.raw, block.element_size, block.grid})));
  const auto size = writer->finish();
  ASSERT_TRUE(size.has_value()) << size.error().message;
  ASSERT_EQ(*size, std::filesystem::file_size(path));
}

std::vector<std::byte> load_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return to_bytes(std::string(std::istreambuf_iterator<char>(in), {}));
}

void save_file(const std::string& path, std::span<const std::byte> bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
}

std::string open_and_check(const std::string& path) {
  const auto reader = Reader::open(path);
  if (!reader) return reader.error().message;
  Progress progress;
  const auto checked = reader->check_all({.count = 1}, progress);
  return checked ? "" : checked.error().message;
}

template <typename T>
void patch_header(std::vector<std::byte>& file, std::size_t offset, T value) {
  std::memcpy(file.data() + offset, &value, sizeof(T));
  const std::uint64_t sum = checksum(std::span(file).first(kHeaderBytes - 8));
  std::memcpy(file.data() + kHeaderBytes - 8, &sum, sizeof(sum));
}
template void patch_header(std::vector<std::byte>&, std::size_t, std::uint32_t);
template void patch_header(std::vector<std::byte>&, std::size_t, std::uint64_t);

std::vector<std::byte> forge_file(std::span<const std::byte> blocks,
                                  std::span<const std::byte> directory) {
  const auto stored = zstd_compress(directory);
  const auto header = encode_header({.features = 0,
                                     .file_size = kHeaderBytes + blocks.size() + stored.size(),
                                     .directory_offset = kHeaderBytes + blocks.size(),
                                     .directory_stored_size = stored.size(),
                                     .directory_raw_size = directory.size(),
                                     .directory_checksum = checksum(stored)});
  std::vector<std::byte> file(header.begin(), header.end());
  file.insert(file.end(), blocks.begin(), blocks.end());
  file.insert(file.end(), stored.begin(), stored.end());
  return file;
}

}  // namespace lode::store
