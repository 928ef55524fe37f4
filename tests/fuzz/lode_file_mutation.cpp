#include "tests/fuzz/lode_file_mutation.h"

#include <algorithm>
#include <utility>

#include "lode/store/checksum.h"
#include "lode/store/codec.h"
#include "lode/store/directory.h"
#include "lode/store/header.h"

namespace lode::store {
namespace {

using Bytes = std::vector<std::byte>;

/// A valid file in parts.
struct OpenedFile {
  Directory directory;
  std::vector<Bytes> blocks;  ///< As stored.
};

std::optional<OpenedFile> open_file(std::span<const std::byte> file) {
  const auto header =
      decode_header(file.first(std::min(file.size(), kHeaderBytes)), file.size(), "");
  if (!header || header->directory_raw_size > (std::uint64_t{1} << 24)) return {};
  Bytes raw(header->directory_raw_size);
  if (!zstd_decompress(file.subspan(header->directory_offset), raw)) return {};
  auto directory = decode_directory(
      raw, {.path = "", .blocks_end = header->directory_offset, .memory_limit = 1 << 26});
  if (!directory) return {};
  OpenedFile opened{std::move(*directory), {}};
  for (const BlockEntry& block : opened.directory.blocks) {
    const auto stored = file.subspan(block.offset, block.stored_size);
    opened.blocks.emplace_back(stored.begin(), stored.end());
  }
  return opened;
}

Bytes close_file(const OpenedFile& opened, std::span<const std::byte> directory) {
  std::uint64_t end = kHeaderBytes;
  for (const Bytes& block : opened.blocks) end += block.size();
  const Bytes stored = zstd_compress(directory);
  const auto header = encode_header({.features = kKnownFeatures,
                                     .file_size = end + stored.size(),
                                     .directory_offset = end,
                                     .directory_stored_size = stored.size(),
                                     .directory_raw_size = directory.size(),
                                     .directory_checksum = checksum(stored)});
  Bytes file(header.begin(), header.end());
  for (const Bytes& block : opened.blocks) file.insert(file.end(), block.begin(), block.end());
  file.insert(file.end(), stored.begin(), stored.end());
  return file;
}

constexpr std::size_t kMoreBytes = 64;

void mutate(Bytes& bytes, const fuzz::MutateBytes& change) {
  const std::size_t size = bytes.size();
  bytes.resize(size + kMoreBytes);
  bytes.resize(change(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
}

/// What a block decodes to, with some of it changed but as long as before.
void mutate_block(BlockEntry& entry, Bytes& stored, const fuzz::MutateBytes& change) {
  if (entry.raw_size > (std::uint64_t{1} << 22)) return;
  Bytes raw(entry.raw_size);
  if (!decode_block(entry.codec, entry.element_size, stored, raw)) return;
  const std::size_t size = raw.size();
  mutate(raw, change);
  raw.resize(size);
  const EncodedBlock encoded = encode_block({raw, entry.element_size});
  stored = encoded.stored;
  entry.codec = encoded.codec;
  entry.stored_size = stored.size();
  entry.checksum = checksum(stored);
}

Bytes mutate_file(OpenedFile opened, std::minstd_rand& random, const fuzz::MutateBytes& change) {
  switch (random() % 3) {
    case 0: mutate(opened.directory.metadata, change); break;
    case 1: {
      Bytes directory = encode_directory(opened.directory);
      mutate(directory, change);
      return close_file(opened, directory);
    }
    default: {
      if (opened.blocks.empty()) break;
      const std::size_t i = random() % opened.blocks.size();
      mutate_block(opened.directory.blocks[i], opened.blocks[i], change);
    }
  }
  return close_file(opened, encode_directory(opened.directory));
}

}  // namespace
}  // namespace lode::store

namespace lode::fuzz {

std::optional<std::vector<std::byte>> mutate_lode_file(Input file, std::minstd_rand& random,
                                                       const MutateBytes& change) {
  auto opened = store::open_file(file);
  if (!opened) return {};
  return store::mutate_file(std::move(*opened), random, change);
}

}  // namespace lode::fuzz
