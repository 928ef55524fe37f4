#include "lode/store/writer.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lode/store/block_index.h"
#include "lode/store/checksum.h"
#include "lode/store/header.h"

namespace lode::store {

Writer::Writer(std::string path, AtomicFile file, Directory directory)
    : path_(std::move(path)),
      file_(std::move(file)),
      directory_(std::move(directory)),
      n_indexes_(static_cast<std::int32_t>(std::ranges::count_if(
          directory_.blocks, [](const BlockEntry& b) { return is_index(b.key); }))) {}

Result<Writer> Writer::create(std::string path, std::string_view model,
                              std::span<const std::byte> metadata) {
  LODE_TRY(AtomicFile file, AtomicFile::create(path));
  // Zeros until finish(): what an interruption leaves is not a .lode file.
  LODE_CHECK(file.write(std::array<std::byte, kHeaderBytes>{}));
  Writer writer(std::move(path), std::move(file),
                Directory{std::string(model), {metadata.begin(), metadata.end()}, {}});
  return writer;
}

namespace {

/// Whether the blocks of an earlier writer are as it wrote them: what is on a disk may change, and
/// nobody would look at it before the file is whole.
Result<void> check_kept(AtomicFile& file, const std::string& path,
                        std::span<const BlockEntry> blocks, Progress& progress) {
  if (blocks.empty()) return {};
  const std::uint64_t n_bytes = blocks.back().offset + blocks.back().stored_size;
  std::vector<std::byte> bytes;
  for (const BlockEntry& block : blocks) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("checking", static_cast<double>(block.offset) / static_cast<double>(n_bytes),
                    n_bytes);
    bytes.resize(static_cast<std::size_t>(block.stored_size));
    LODE_CHECK(file.read_at(block.offset, bytes));
    if (checksum(bytes) != block.checksum)
      return fail(
          "{}: {} at offset {} is not as it was written; build without --resume to begin again",
          AtomicFile::part_path(path), describe(block.key), block.offset);
  }
  return {};
}

}  // namespace

Result<Writer> Writer::open_part(std::string path, std::string_view model,
                                 std::vector<BlockEntry> blocks, Progress& progress) {
  const std::uint64_t n_kept = blocks.empty() ? 0 : end_of(blocks);
  LODE_TRY(AtomicFile file, AtomicFile::open_part(path, n_kept));
  LODE_CHECK(check_kept(file, path, blocks, progress));
  if (blocks.empty()) LODE_CHECK(file.write(std::array<std::byte, kHeaderBytes>{}));
  Writer writer(std::move(path), std::move(file),
                Directory{std::string(model), {}, std::move(blocks)});
  return writer;
}

namespace {

/// Where it lies is not known yet.
BlockEntry entry_of(const BlockKey& key, const EncodedBlock& block) {
  return {.key = key,
          .stored_size = block.stored.size(),
          .raw_size = block.raw_size,
          .checksum = checksum(block.stored),
          .codec = block.codec,
          .element_size = block.element_size};
}

}  // namespace

Result<void> Writer::append(BlockEntry entry, std::span<const std::byte> stored) {
  LODE_EXPECTS(!is_finished_ && entry.raw_size <= kMaxBlockBytes);
  entry.offset = file_.size();
  directory_.blocks.push_back(entry);
  return file_.write(stored);
}

Result<void> Writer::append(const BlockKey& key, const EncodedBlock& block) {
  return append(entry_of(key, block), block.stored);
}

Result<void> Writer::append_run(std::span<const KeyedBlock> blocks) {
  if (blocks.empty()) return {};
  Directory run{directory_.model, early_metadata_, {}};
  for (const auto& [key, block] : blocks) run.blocks.push_back(entry_of(key, block));
  const std::vector<std::byte> index = encode_index(encode_directory(run), file_.size());
  const BlockEntry entry{.key = {kIndexKind, 0, {{n_indexes_++, 0, 0}}},
                         .stored_size = index.size(),
                         .raw_size = index.size(),
                         .checksum = checksum(index)};
  LODE_CHECK(append(entry, index));
  for (std::size_t i = 0; i < blocks.size(); ++i)
    LODE_CHECK(append(run.blocks[i], blocks[i].block.stored));
  return {};
}

void Writer::set_early_metadata(std::span<const std::byte> metadata) {
  early_metadata_.assign(metadata.begin(), metadata.end());
}

void Writer::set_metadata(std::span<const std::byte> metadata) {
  LODE_EXPECTS(!is_finished_);
  directory_.metadata.assign(metadata.begin(), metadata.end());
}

Result<std::uint64_t> Writer::finish(const Progress& progress) {
  LODE_EXPECTS(!is_finished_);
  is_finished_ = true;
  LODE_CHECK(check_keys_differ(directory_.blocks, order_by_key(directory_.blocks), path_));
  const auto raw = encode_directory(directory_);
  const auto stored = zstd_compress(raw);
  if (std::ranges::any_of(directory_.blocks,
                          [](const BlockEntry& b) { return b.codec >= Codec::predicted_zstd; }))
    require(kFeaturePredicted);
  const Header header{.features = features_,
                      .file_size = file_.size() + stored.size(),
                      .directory_offset = file_.size(),
                      .directory_stored_size = stored.size(),
                      .directory_raw_size = raw.size(),
                      .directory_checksum = checksum(stored)};
  LODE_CHECK(file_.write(stored));
  LODE_CHECK(file_.write_at(0, encode_header(header)));
  LODE_CHECK(file_.commit(progress));
  return header.file_size;
}

}  // namespace lode::store
