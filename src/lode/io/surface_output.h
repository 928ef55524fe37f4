#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lode/core/atomic_file.h"
#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/surface.h"
#include "lode/core/uninitialized_array.h"

namespace lode::io {

// The binary formats are little-endian; arrays and records are copied to them as they lie.
static_assert(std::endian::native == std::endian::little);

/// The word that starts the comment in which PLY and OBJ files note a surface's origin.
inline constexpr std::string_view kOriginNote = "lode_origin";

[[nodiscard]] inline bool has_origin(const Surface& surface) {
  return surface.origin != Vec3d{{0, 0, 0}};
}

/// What positions and origins are relative to, added.
[[nodiscard]] inline Vec3d world_place(const Surface& surface, const Vec3f& place) {
  return surface.origin + Vec3d{{place[0], place[1], place[2]}};
}

/// `text` with control characters turned into spaces, so that it stays inside one comment line.
[[nodiscard]] inline std::string to_one_line(std::string_view text) {
  std::string line(text);
  for (char& c : line)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  return line;
}

/// Copies a value to `out` and moves `out` past it.
template <typename T>
inline void put(std::byte*& out, const T& value) {
  std::memcpy(out, &value, sizeof(T));
  out += sizeof(T);
}

/// The file that a writer fills: an AtomicFile that reports the phase "writing" piece by piece, and
/// fails once it is cancelled.
class SurfaceOutput {
 public:
  /// n_bytes: the size the file will have, as far as it is known; only the progress hangs on it,
  /// which with 0 is not reported. threads: what write_records() may use.
  [[nodiscard]] static Result<SurfaceOutput> create(const std::string& path, std::uint64_t n_bytes,
                                                    Progress& progress, Threads threads);

  /// Appends bytes.
  [[nodiscard]] Result<void> write(std::span<const std::byte> bytes);
  [[nodiscard]] Result<void> write(std::string_view text) {
    return write(std::as_bytes(std::span(text.data(), text.size())));
  }
  /// Overwrites bytes already written.
  [[nodiscard]] Result<void> write_at(std::uint64_t offset, std::string_view text) {
    return file_.write_at(offset, std::as_bytes(std::span(text.data(), text.size())));
  }
  [[nodiscard]] Result<void> commit() { return file_.commit(progress_); }
  [[nodiscard]] Threads threads() const { return threads_; }

 private:
  SurfaceOutput(AtomicFile file, std::uint64_t n_bytes, Progress& progress, Threads threads)
      : file_(std::move(file)), n_bytes_(n_bytes), progress_(progress), threads_(threads) {}

  AtomicFile file_;
  std::uint64_t n_bytes_;
  Progress& progress_;
  Threads threads_;
};

// An Output takes bytes by write(), and has threads(): a SurfaceOutput, or a PatchedSpool.

/// Appends a whole array as it lies in memory.
template <typename T, typename Output>
[[nodiscard]] Result<void> write_array(Output& file, std::span<const T> values) {
  return file.write(std::as_bytes(values));
}

/// Appends n records of record_bytes each, filled in by fill(i, out), which the output's threads
/// call at once, in pieces large enough to bypass the file's own buffer.
template <typename Output, typename Fill>
[[nodiscard]] Result<void> write_records(Output& file, std::size_t n, std::size_t record_bytes,
                                         const Fill& fill) {
  constexpr std::size_t kPieceBytes = std::size_t{2} << 20;
  constexpr std::size_t kPart = 4096;  // records that one thread fills in
  const std::size_t n_per_piece = kPieceBytes / record_bytes;
  UninitializedArray<std::byte> piece(std::min(n, n_per_piece) * record_bytes);
  for (std::size_t first = 0; first < n; first += n_per_piece) {
    const std::size_t n_records = std::min(n_per_piece, n - first);
    parallel_for((n_records + kPart - 1) / kPart, file.threads(), 1, [&](std::size_t part, int) {
      const std::size_t end = std::min(n_records, (part + 1) * kPart);
      for (std::size_t i = part * kPart; i < end; ++i)
        fill(first + i, piece.data() + i * record_bytes);
    });
    LODE_CHECK(file.write(std::span<const std::byte>(piece.data(), n_records * record_bytes)));
  }
  return {};
}

}  // namespace lode::io
