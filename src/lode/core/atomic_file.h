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

/// What is left of a large output that does not come to its end.
enum class Unfinished : std::uint8_t {
  nothing,
  part,  ///< AtomicFile::part_path(output), where it is made in several parts; an earlier one goes.
  resume,  ///< The same; what an earlier one has of the same input is not made again.
};

/// An output file that appears whole or not at all: written to a temporary beside `path`, then
/// flushed, fsynced and renamed by commit(). Without commit() the temporary goes; where the file
/// system can (O_TMPFILE), it has no name until then, and goes even when the process is killed.
class AtomicFile {
 public:
  /// Fails, naming `path`, when its directory cannot be written to.
  [[nodiscard]] static Result<AtomicFile> create(std::string path);
  /// The temporary is part_path(path), and stays without commit(), for who wants to go on with it:
  /// the first `n_kept` bytes of an earlier one are kept. Fails when it has fewer, or when another
  /// process is writing it.
  [[nodiscard]] static Result<AtomicFile> open_part(std::string path, std::uint64_t n_kept);
  /// Removes what open_part() has left of `path`, unless another process is writing it.
  static void remove_part(const std::string& path);
  [[nodiscard]] static std::string part_path(const std::string& path) { return path + ".part"; }

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
  /// Fills `out` from bytes already written, or kept by open_part().
  [[nodiscard]] Result<void> read_at(std::uint64_t offset, std::span<std::byte> out);
  /// Returns when all that was written so far outlasts a loss of power.
  [[nodiscard]] Result<void> sync();
  /// Bytes appended so far.
  [[nodiscard]] std::uint64_t size() const { return size_; }
  [[nodiscard]] Result<void> commit() { return commit(Progress()); }
  /// Fails when `progress` is cancelled before the rename.
  [[nodiscard]] Result<void> commit(const Progress& progress);

 private:
  enum class Leftover : std::uint8_t { nameless, removed, kept };

  AtomicFile(std::string path, std::string temporary, int descriptor, Leftover leftover);
  [[nodiscard]] Result<void> flush();
  [[nodiscard]] Result<void> name_temporary();
  [[nodiscard]] Error system_error(const char* action) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
  Leftover leftover_ = Leftover::removed;
  std::uint64_t size_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace lode
