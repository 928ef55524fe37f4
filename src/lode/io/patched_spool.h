#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/io/spool_file.h"

namespace lode::io {

/// Bytes that are appended to a nameless file, and read once; some may be replaced in between.
class PatchedSpool {
 public:
  /// The file comes to `directory` with the first bytes. threads: see write_records().
  PatchedSpool(std::string directory, Threads threads)
      : directory_(std::move(directory)), threads_(threads) {}

  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  static constexpr std::size_t kMostReplaced = 12;
  /// Reading will find these bytes at `offset`, so many at most. Not a second time the same ones.
  void replace(std::uint64_t offset, std::span<const std::byte> bytes);
  [[nodiscard]] Threads threads() const { return threads_; }

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

  std::string directory_;
  Threads threads_;
  std::uint64_t size_ = 0;
  std::optional<SpoolFile> file_;  ///< Once there are bytes.
  std::vector<Patch> patches_;
};

}  // namespace lode::io
