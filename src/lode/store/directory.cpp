#include "lode/store/directory.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "lode/store/bytes.h"

namespace lode::store {
namespace {

/// Bytes of one block over all columns.
constexpr std::uint64_t kEntryBytes = 5 * 4 + 2 * 8 + 2 * 1 + 8;

/// One column: the same number of every block. Columns of like bytes compress best.
template <typename T, typename Get>
void write_column(ByteWriter& out, std::span<const BlockEntry> blocks, Get get) {
  std::vector<T> column(blocks.size());
  std::ranges::transform(blocks, column.begin(), get);
  out.write_all(std::span<const T>(column));
}

template <typename T, typename Set>
Result<void> read_column(ByteReader& in, std::span<BlockEntry> blocks, Set set) {
  LODE_TRY(const auto column, in.read_all<T>(blocks.size()));
  for (std::size_t i = 0; i < blocks.size(); ++i) set(blocks[i], column[i]);
  return {};
}

Result<void> read_columns(ByteReader& in, std::span<BlockEntry> blocks) {
  LODE_CHECK(read_column<std::uint32_t>(
      in, blocks, [](BlockEntry& b, std::uint32_t kind) { b.key.kind = kind; }));
  LODE_CHECK(read_column<std::uint32_t>(
      in, blocks, [](BlockEntry& b, std::uint32_t level) { b.key.level = level; }));
  for (std::size_t axis = 0; axis < 3; ++axis)
    LODE_CHECK(read_column<std::int32_t>(
        in, blocks, [axis](BlockEntry& b, std::int32_t p) { b.key.position[axis] = p; }));
  LODE_CHECK(read_column<std::uint64_t>(
      in, blocks, [](BlockEntry& b, std::uint64_t size) { b.stored_size = size; }));
  LODE_CHECK(read_column<std::uint64_t>(
      in, blocks, [](BlockEntry& b, std::uint64_t size) { b.raw_size = size; }));
  LODE_CHECK(read_column<std::uint8_t>(
      in, blocks, [](BlockEntry& b, std::uint8_t codec) { b.codec = static_cast<Codec>(codec); }));
  LODE_CHECK(read_column<std::uint8_t>(
      in, blocks, [](BlockEntry& b, std::uint8_t size) { b.element_size = size; }));
  return read_column<std::uint64_t>(in, blocks,
                                    [](BlockEntry& b, std::uint64_t sum) { b.checksum = sum; });
}

Result<void> check_entry(const BlockEntry& block, const DirectoryContext& context) {
  const auto refuse = [&](const std::string& what) {
    return fail("{}: {} at offset {}: {}", context.path, describe(block.key), block.offset, what);
  };
  if (static_cast<std::uint8_t>(block.codec) > kLastCodec)
    return refuse(
        fmt::format("expected codec 0 to {}, got {}", kLastCodec, static_cast<int>(block.codec)));
  if (!is_element_size(block.element_size))
    return refuse(
        fmt::format("expected elements of 1, 2, 4 or 8 bytes, got {}", block.element_size));
  if (block.raw_size > kMaxBlockBytes)
    return refuse(
        fmt::format("expected at most {} bytes decoded, got {}", kMaxBlockBytes, block.raw_size));
  const bool is_plausible = block.codec == Codec::none
                                ? block.stored_size == block.raw_size
                                : block.stored_size <= block.raw_size &&
                                      block.raw_size / kMaxZstdRatio <= block.stored_size;
  if (!is_plausible)
    return refuse(fmt::format("codec {} cannot make {} bytes of {} stored ones",
                              static_cast<int>(block.codec), block.raw_size, block.stored_size));
  if (block.stored_size > context.blocks_end - block.offset)
    return refuse(fmt::format("expected it to end before the directory at {}, got {} bytes",
                              context.blocks_end, block.stored_size));
  return {};
}

/// Offsets follow from the sizes, so gaps and overlaps cannot be expressed.
Result<void> place_blocks(std::span<BlockEntry> blocks, const DirectoryContext& context) {
  std::uint64_t offset = context.blocks_begin;
  for (BlockEntry& block : blocks) {
    block.offset = offset;
    LODE_CHECK(check_entry(block, context));
    offset += block.stored_size;
  }
  return {};
}

}  // namespace

std::string describe(const BlockKey& key) {
  return fmt::format("block (kind {}, level {}, position {} {} {})", key.kind, key.level,
                     key.position[0], key.position[1], key.position[2]);
}

std::vector<std::byte> encode_directory(const Directory& directory) {
  ByteWriter out;
  out.write_string(directory.model);
  out.write(static_cast<std::uint64_t>(directory.metadata.size()));
  out.write_bytes(directory.metadata);
  const std::span<const BlockEntry> blocks = directory.blocks;
  out.write(static_cast<std::uint64_t>(blocks.size()));
  write_column<std::uint32_t>(out, blocks, [](const BlockEntry& b) { return b.key.kind; });
  write_column<std::uint32_t>(out, blocks, [](const BlockEntry& b) { return b.key.level; });
  for (std::size_t axis = 0; axis < 3; ++axis)
    write_column<std::int32_t>(out, blocks,
                               [axis](const BlockEntry& b) { return b.key.position[axis]; });
  write_column<std::uint64_t>(out, blocks, [](const BlockEntry& b) { return b.stored_size; });
  write_column<std::uint64_t>(out, blocks, [](const BlockEntry& b) { return b.raw_size; });
  write_column<std::uint8_t>(
      out, blocks, [](const BlockEntry& b) { return static_cast<std::uint8_t>(b.codec); });
  write_column<std::uint8_t>(out, blocks, [](const BlockEntry& b) { return b.element_size; });
  write_column<std::uint64_t>(out, blocks, [](const BlockEntry& b) { return b.checksum; });
  return std::move(out).take();
}

Result<Directory> decode_run(std::span<const std::byte> bytes, const DirectoryContext& context) {
  ByteReader in(bytes, fmt::format("{}: directory", context.path));
  Directory directory;
  LODE_TRY(directory.model, in.read_string());
  LODE_TRY(const auto metadata_size, in.read<std::uint64_t>());
  LODE_TRY(const auto metadata, in.read_bytes(metadata_size));
  directory.metadata.assign(metadata.begin(), metadata.end());
  LODE_TRY(const auto n_blocks, in.read<std::uint64_t>());
  if (n_blocks != in.n_left() / kEntryBytes || in.n_left() % kEntryBytes != 0)
    return fail("{}: directory: expected {} bytes for each of {} blocks, got {} bytes for all",
                context.path, kEntryBytes, n_blocks, in.n_left());
  if (n_blocks > context.memory_limit / kEntryMemory)
    return fail(
        "{}: directory: expected at most {} blocks within the memory limit of {} bytes, "
        "got {}",
        context.path, context.memory_limit / kEntryMemory, context.memory_limit, n_blocks);
  directory.blocks.resize(static_cast<std::size_t>(n_blocks));
  LODE_CHECK(read_columns(in, directory.blocks));
  LODE_CHECK(in.expect_end());
  LODE_CHECK(place_blocks(directory.blocks, context));
  return directory;
}

Result<Directory> decode_directory(std::span<const std::byte> bytes,
                                   const DirectoryContext& context) {
  LODE_TRY(auto directory, decode_run(bytes, context));
  const std::uint64_t end =
      directory.blocks.empty() ? context.blocks_begin : end_of(directory.blocks);
  if (end != context.blocks_end)
    return fail("{}: expected the blocks to end at the directory, offset {}, got {}", context.path,
                context.blocks_end, end);
  return directory;
}

std::uint64_t end_of(std::span<const BlockEntry> blocks) {
  return blocks.empty() ? kHeaderBytes : blocks.back().offset + blocks.back().stored_size;
}

std::vector<std::size_t> order_by_key(std::span<const BlockEntry> blocks) {
  std::vector<std::size_t> order(blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return std::pair(blocks[a].key, a) < std::pair(blocks[b].key, b);
  });
  return order;
}

Result<void> check_keys_differ(std::span<const BlockEntry> blocks,
                               std::span<const std::size_t> order, const std::string& path) {
  for (std::size_t i = 1; i < order.size(); ++i)
    if (blocks[order[i - 1]].key == blocks[order[i]].key)
      return fail("{}: expected each block once, got {} at offsets {} and {}", path,
                  describe(blocks[order[i]].key), blocks[order[i - 1]].offset,
                  blocks[order[i]].offset);
  return {};
}

}  // namespace lode::store
