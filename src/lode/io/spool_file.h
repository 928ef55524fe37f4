#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/io/input_file.h"

namespace lode::io {

/// Bytes appended to a file that has no name: only this process reaches it, and the file system
/// takes it back when it is closed, however the process ends. The last bytes appended stay in a
/// small buffer, from which they are also read.
class SpoolFile {
 public:
  /// How the file loses its name: at birth where the file system can do that, else right after.
  enum class Birth { nameless_if_possible, unlinked };

  /// A file in `directory`, whose name messages start with. Bytes written and read count in
  /// `tally`. Fails when the directory is missing or cannot be written.
  [[nodiscard]] static Result<SpoolFile> create(const std::string& directory, IoTallyPtr tally,
                                                Birth birth = Birth::nameless_if_possible);

  SpoolFile(SpoolFile&& other) noexcept;
  SpoolFile(const SpoolFile&) = delete;
  SpoolFile& operator=(const SpoolFile&) = delete;
  SpoolFile& operator=(SpoolFile&&) = delete;
  ~SpoolFile();

  /// Fails when the disk is full, and then has appended nothing.
  [[nodiscard]] Result<void> append(std::span<const std::byte> bytes);
  /// Fills `out` from `offset`; all of it must have been appended.
  [[nodiscard]] Result<void> read(std::uint64_t offset, std::span<std::byte> out) const;
  [[nodiscard]] std::uint64_t size() const { return n_written_ + buffer_.size(); }
  /// For another program that fills it, of which then nothing is to be appended here.
  [[nodiscard]] int descriptor() const { return descriptor_; }

 private:
  SpoolFile(std::string directory, IoTallyPtr tally);
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> read_written(std::uint64_t offset, std::span<std::byte> out) const;

  std::string directory_;
  IoTallyPtr tally_;
  int descriptor_ = -1;
  std::uint64_t n_written_ = 0;
  std::vector<std::byte> buffer_;  ///< What comes behind the written bytes.
};

}  // namespace lode::io
