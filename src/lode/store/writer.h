#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/atomic_file.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/store/codec.h"
#include "lode/store/directory.h"

namespace lode::store {

struct KeyedBlock {
  BlockKey key;
  EncodedBlock block;
};

/// Writes a .lode file that appears whole or not at all. Blocks lie in the file in the order of
/// append(), which is the caller's business. One thread at a time.
class Writer {
 public:
  /// Fails when the output cannot be created. model: whose blocks these are, "diamond3d".
  [[nodiscard]] static Result<Writer> create(std::string path, std::string_view model,
                                             std::span<const std::byte> metadata);

  /// Writes to AtomicFile::part_path(path), which stays until finish(): after the blocks that are
  /// there, as blocks() of an earlier writer said when it had synced them. Fails where they are not
  /// as they were written. Metadata is empty.
  [[nodiscard]] static Result<Writer> open_part(std::string path, std::string_view model,
                                                std::vector<BlockEntry> blocks, Progress& progress);

  [[nodiscard]] Result<void> append(const BlockKey& key, const EncodedBlock& block);
  /// Appends an index of these blocks, by which they are found where the directory is lost, then
  /// the blocks. Nothing where there are none.
  [[nodiscard]] Result<void> append_run(std::span<const KeyedBlock> blocks);
  /// Returns when all blocks so far outlast a loss of power.
  [[nodiscard]] Result<void> sync() { return file_.sync(); }
  [[nodiscard]] std::span<const BlockEntry> blocks() const { return directory_.blocks; }
  /// What indexes from now on say of the model; it must not depend on what comes after them.
  void set_early_metadata(std::span<const std::byte> metadata);
  /// Replaces the metadata, for what is known only after the blocks.
  void set_metadata(std::span<const std::byte> metadata);
  /// Adds feature bits to what the header says that a reader must understand.
  void require(std::uint64_t features) { features_ |= features; }
  /// Writes the directory and the header and renames the file into place; the size of the file.
  /// Fails when two blocks have one key, or `progress` is cancelled before the rename. Nothing may
  /// be called afterwards.
  [[nodiscard]] Result<std::uint64_t> finish(const Progress& progress);
  [[nodiscard]] Result<std::uint64_t> finish() { return finish(Progress()); }

 private:
  Writer(std::string path, AtomicFile file, Directory directory);
  [[nodiscard]] Result<void> append(BlockEntry entry, std::span<const std::byte> stored);

  std::string path_;
  AtomicFile file_;
  Directory directory_;
  std::vector<std::byte> early_metadata_;
  std::uint64_t features_ = 0;
  std::int32_t n_indexes_ = 0;
  bool is_finished_ = false;
};

}  // namespace lode::store
