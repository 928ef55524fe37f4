#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "lode/core/result.h"
#include "lode/io/input_file.h"

namespace lode::io {

/// Bytes read once, front to back.
class ByteStream {
 public:
  virtual ~ByteStream() = default;

  /// Fills `out`, or fails.
  [[nodiscard]] virtual Result<void> read(std::span<std::byte> out) = 0;
  /// Passes over `n` bytes, or fails; unless overridden it reads them.
  [[nodiscard]] virtual Result<void> skip(std::uint64_t n);
  /// An upper bound of the bytes to come; exact for files.
  [[nodiscard]] virtual std::uint64_t n_left() const = 0;
};

/// `n_bytes` of a file from `offset`, cut at the file's end.
[[nodiscard]] std::unique_ptr<ByteStream> make_file_stream(InputFilePtr file, std::uint64_t offset,
                                                           std::uint64_t n_bytes);
/// A file from `offset` to its end.
[[nodiscard]] std::unique_ptr<ByteStream> make_file_stream(InputFilePtr file, std::uint64_t offset);

/// The bytes that base64 text stands for. Whitespace is skipped, and padding may occur between
/// groups, as where several encodings were joined. What follows the bytes that are read need not be
/// base64. `path` is what messages name.
[[nodiscard]] std::unique_ptr<ByteStream> make_base64_stream(std::unique_ptr<ByteStream> text,
                                                             std::string path);

/// Text in memory as it is; it outlives the stream, or is part of `owner`.
[[nodiscard]] std::unique_ptr<ByteStream> make_memory_stream(
    std::string_view text, std::string path, std::shared_ptr<const void> owner = nullptr);

}  // namespace lode::io
