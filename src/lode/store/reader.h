#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/store/directory.h"
#include "lode/store/header.h"

namespace lode::store {

/// Whether a file must be as long as its header says. `any`: bytes may follow its end, as tools
/// that recover files leave them, or some be missing or too many between its blocks. Its directory
/// is then also looked for at the end, and each block as far off as that is, if it is not in its
/// place. Where there is none, what the blocks' indexes say takes its place.
enum class Length : std::uint8_t { as_said, any };

struct ReaderOptions {
  /// Bytes that the directory, or a block, may take when decoded; 0: four times the file and
  /// 64 MiB, which every valid file that Lode writes is far below.
  std::uint64_t memory_limit = 0;
  Length length = Length::as_said;
};

/// What has been read of a file, all readings counted: bytes with header and directory.
struct ReadCounts {
  std::uint64_t n_blocks = 0;
  std::uint64_t n_bytes = 0;
};

/// An open .lode file. Const members are safe from many threads.
class Reader {
 public:
  /// Reads and checks the header and the directory, no block. Fails, naming `path`, what was
  /// expected and what came, on anything but a whole file of a version and features that this
  /// program knows; with Length::any also on one without a directory, but with an index.
  [[nodiscard]] static Result<Reader> open(std::string path, const ReaderOptions& options = {});

  /// The name of the model that a file holds, of its header and as much of its directory as that
  /// takes, some kilobytes: what follows may be damaged, which open() says. Fails likewise.
  [[nodiscard]] static Result<std::string> model_of(std::string path);

  Reader(Reader&& other) noexcept;
  Reader& operator=(Reader&& other) noexcept;
  ~Reader();

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::uint64_t file_size() const { return header_.file_size; }
  [[nodiscard]] const std::string& model() const { return directory_.model; }
  [[nodiscard]] std::span<const std::byte> metadata() const { return directory_.metadata; }
  /// In the order of the file.
  [[nodiscard]] std::span<const BlockEntry> blocks() const { return directory_.blocks; }
  /// Whether there was no directory: of the blocks some may be missing, others cut off, and the
  /// metadata are what was known before the blocks were. Indexes are not among blocks().
  [[nodiscard]] bool is_rebuilt() const { return is_rebuilt_; }
  /// The header's feature bits; none where the directory was rebuilt.
  [[nodiscard]] std::uint64_t features() const { return header_.features; }
  /// Index into blocks(), in O(log n).
  [[nodiscard]] std::optional<std::size_t> find(const BlockKey& key) const;

  /// Reads block i, checks its checksum, decodes it.
  [[nodiscard]] Result<std::vector<std::byte>> read_block(std::size_t i) const;
  /// The same into `out`, of blocks()[i].raw_size bytes.
  [[nodiscard]] Result<void> read_block(std::size_t i, std::span<std::byte> out) const;

  /// Since it was opened, by all threads.
  [[nodiscard]] ReadCounts reads() const { return {n_blocks_read_, n_bytes_read_}; }

  /// Tells the system that a block will be read soon; returns at once.
  void will_read(std::size_t i) const;

  /// Reads and checks every byte of the file anew: header, directory and, decoding them, all
  /// blocks, which together cover it without gap or overlap. Reports the first fault in the
  /// order of the file. Not for a directory that was rebuilt.
  [[nodiscard]] Result<void> check_all(Threads threads, Progress& progress) const;

 private:
  Reader(std::string path, int descriptor);
  [[nodiscard]] static Result<Reader> begin(std::string path);
  [[nodiscard]] Result<std::uint64_t> size_on_disk() const;
  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> out) const;
  [[nodiscard]] Result<Header> load_header() const;
  [[nodiscard]] Result<void> check_directory_size(const Header& header) const;
  [[nodiscard]] Result<std::vector<std::byte>> load_directory(const Header& header) const;
  [[nodiscard]] Result<std::vector<std::byte>> find_directory();
  [[nodiscard]] Result<void> read_directory(std::uint64_t memory_limit);
  [[nodiscard]] Result<void> rebuild_directory(std::uint64_t memory_limit, const Error& why);
  [[nodiscard]] Result<void> read_stored(const BlockEntry& block, std::uint64_t offset,
                                         std::span<std::byte> out) const;
  [[nodiscard]] Error block_error(const BlockEntry& block, const std::string& what) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t memory_limit_ = 0;
  Length length_ = Length::as_said;
  std::uint64_t shift_ = 0;  ///< How far off the directory was, modulo 2^64.
  bool is_rebuilt_ = false;
  Header header_;
  Directory directory_;
  std::vector<std::size_t> order_;  ///< Of blocks, by key.
  mutable std::atomic<std::uint64_t> n_blocks_read_{0};
  mutable std::atomic<std::uint64_t> n_bytes_read_{0};
};

}  // namespace lode::store
