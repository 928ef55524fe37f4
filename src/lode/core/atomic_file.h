#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"

namespace lode {

/// An output file that appears whole or not at all: written to a temporary beside `path`, then
/// flushed, fsynced and renamed by commit(). Destruction without commit() removes the temporary.
class AtomicFile {
 public:
  /// Fails, naming `path`, when its directory cannot be written to.
  [[nodiscard]] static Result<AtomicFile> create(std::string path);

  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  /// Appends bytes (buffered).
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text) {
    return write(std::as_bytes(std::span(text.data(), text.size())));
  }
  /// Overwrites bytes already written, at `offset` from the start.
  [[nodiscard]] Result<void> write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Bytes appended so far.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] Result<void> commit() { return commit(Progress()); }
  /// Fails when `progress` is cancelled before the rename.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  AtomicFile(std::string path, std::string temporary, int descriptor);
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Error system_error(const char* action) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace lode
