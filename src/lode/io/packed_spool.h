#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "lode/io/spool_file.h"

namespace lode::io {

/// Bytes appended to a nameless file (SpoolFile) in compressed blocks: scans shrink to a quarter,
/// and so does what goes to the disk and comes back. Compressing takes 2 ns a byte of a CT scan,
/// reading 0.5. The last bytes appended stay in memory, and so does the block read last: reads of
/// ascending offsets decode each block once. Beside those, eight bytes of memory a block.
class PackedSpool {
 public:
  static constexpr std::size_t kBlockBytes = std::size_t{1} << 16;

  /// As SpoolFile::create(); bytes written and read count in `tally` as they are in the file.
  [[nodiscard]] static Result<PackedSpool> create(const std::string& directory, IoTallyPtr tally);

  PackedSpool(PackedSpool&& other) noexcept;
  PackedSpool(const PackedSpool&) = delete;
  PackedSpool& operator=(const PackedSpool&) = delete;
  PackedSpool& operator=(PackedSpool&&) = delete;
  ~PackedSpool();

  /// Fails when the disk is full; size() says how much was appended.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);
  /// Fills `out` from `offset`; all of it must have been appended.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> out);
  /// Of what was appended.
  [[nodiscard]] std::uint64_t size() const { return ends_.size() * kBlockBytes + last_.size(); }

  /// Of the file.
  [[nodiscard]] std::uint64_t n_packed_bytes() const { return file_.size(); }

 private:
  struct Coder;

  PackedSpool(SpoolFile file, std::unique_ptr<Coder> coder);
  [[nodiscard]] Result<void> write_block(std::span<const std::byte> block);
  [[nodiscard]] std::uint64_t begin_of(std::size_t block) const {
    return block == 0 ? 0 : ends_[block - 1];
  }
  [[nodiscard]] std::size_t n_packed(std::size_t block) const {
    return static_cast<std::size_t>(ends_[block] - begin_of(block));
  }
  [[nodiscard]] Result<void> read_block(std::size_t block, std::span<std::byte> out);

  SpoolFile file_;
  std::unique_ptr<Coder> coder_;
  std::vector<std::uint64_t> ends_;  ///< Of blocks in the file.
  std::vector<std::byte> last_;      ///< What comes behind the blocks; less than one.
  std::vector<std::byte> joined_;    ///< The block that begins with it.
  std::vector<std::byte> cached_;    ///< The block read last, or nothing.
  std::size_t cached_block_ = 0;
  std::vector<std::byte> packed_;
};

}  // namespace lode::io
