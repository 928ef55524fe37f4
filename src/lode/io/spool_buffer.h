#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/io/spool_file.h"

namespace lode::io {

/// Bytes that are appended, and read once: in memory as long as they are few, in a nameless file
/// beyond that.
class SpoolBuffer {
 public:
  /// The file would be in `directory`.
  SpoolBuffer(std::string directory, std::size_t memory_bytes)
      : directory_(std::move(directory)), memory_bytes_(memory_bytes) {}

  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  static constexpr std::size_t kMostReplaced = 12;
  /// Reading will find these bytes at `offset`, so many at most. Not a second time the same ones.
  void replace(std::uint64_t offset, std::span<const std::byte> bytes);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] bool is_on_disk() const { return file_.has_value(); }

  /// Calls use(bytes) for one piece after the other, of whole records.
  [[nodiscard]] Result<void> read(
      std::size_t record_bytes,
      const std::function<Result<void>(std::span<const std::byte>)>& use) const;

 private:
  struct Patch {
    std::uint64_t offset = 0;
    std::array<std::byte, kMostReplaced> bytes{};
    std::uint32_t n_bytes = 0;
  };

  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> out) const;

  std::string directory_;
  std::size_t memory_bytes_;
  std::uint64_t size_ = 0;
  std::vector<std::vector<std::byte>> chunks_;  ///< Full but for the last one.
  std::optional<SpoolFile> file_;               ///< Then all is there.
  std::vector<Patch> patches_;
};

}  // namespace lode::io
