#include <gtest/gtest.h>

#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "tests/store/python_reader.h"
#include "tests/store/test_file.h"

namespace lode::store {
namespace {

PythonOutcome run_reader(const std::string& path) {
  return run_python(LODE_INDEPENDENT_READER, path);
}

/// What the Python reader prints for a file: the last number is the checksum of the raw bytes.
std::string expected_listing(const std::string& path, std::span<const TestBlock> blocks) {
  const auto reader = Reader::open(path);
  if (!reader) return reader.error().message;
  std::string text = "model test model\nmetadata 13\n";
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const BlockEntry& b = reader->blocks()[i];
    const BlockKey& key = blocks[i].key;
    text +=
        fmt::format("{} {} {} {} {} {} {} {} {} {} {:016x}\n", key.kind, key.level, key.position[0],
                    key.position[1], key.position[2], b.offset, b.stored_size, b.raw_size,
                    static_cast<int>(b.codec), b.element_size, checksum(blocks[i].raw));
  }
  return text;
}

TEST(independent_reader, decodes_every_block_of_a_file_from_the_format_document_alone) {
  const TestPath path("independent.lode");
  const auto blocks = small_blocks();
  write_file(path.str(), blocks);
  const PythonOutcome run = run_reader(path.str());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(run.output, expected_listing(path.str(), blocks));
}

TEST(independent_reader, finds_a_flipped_byte) {
  const TestPath path("independent_flipped.lode");
  write_file(path.str(), small_blocks());
  auto bytes = load_file(path.str());
  for (const std::size_t offset : {std::size_t{70}, kHeaderBytes + 3, bytes.size() - 1}) {
    auto flipped = bytes;
    flipped[offset] ^= std::byte{2};
    save_file(path.str(), flipped);
    const PythonOutcome run = run_reader(path.str());
    EXPECT_EQ(run.exit_code, 1) << offset << ": " << run.output;
    EXPECT_NE(run.output.find("checksum"), std::string::npos) << run.output;
  }
}

}  // namespace
}  // namespace lode::store
