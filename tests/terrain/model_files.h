#pragma once

// Files of models that go with a test, and lies in them.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"

namespace lode::test {

/// A file that goes with the test.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name)
      : path_(testing::TempDir() + "lode_model_" + std::to_string(::getpid()) + "_" + name) {}
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  ~ScratchFile() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Changes raw bytes of blocks, which are parts of columns, or pages; the metadata are column 0.
using Change =
    std::function<void(std::uint32_t column, std::uint32_t part, std::vector<std::byte>& bytes)>;

/// A file of the same blocks, changed, with checksums that are right.
inline void rewrite(const std::string& from, const std::string& to, const Change& change) {
  const auto reader = store::Reader::open(from);
  ASSERT_TRUE(reader);
  std::vector<std::byte> metadata(reader->metadata().begin(), reader->metadata().end());
  change(0, 0, metadata);
  auto writer = store::Writer::create(to, reader->model(), metadata);
  ASSERT_TRUE(writer);
  for (std::size_t i = 0; i < reader->blocks().size(); ++i) {
    const store::BlockEntry& block = reader->blocks()[i];
    auto bytes = reader->read_block(i);
    ASSERT_TRUE(bytes);
    change(block.key.kind, static_cast<std::uint32_t>(block.key.position[0]), *bytes);
    ASSERT_TRUE(writer->append(block.key, store::encode_block({.raw = *bytes, .size = 1})));
  }
  ASSERT_TRUE(writer->finish());
}

template <typename T>
void put(std::vector<std::byte>& bytes, std::size_t at, T value) {
  ASSERT_LE(at + sizeof(T), bytes.size());
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

}  // namespace lode::test
