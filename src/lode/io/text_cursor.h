#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "lode/core/result.h"
#include "lode/io/byte_stream.h"

namespace lode::io {

/// Reads lines and whitespace-separated words from a byte stream, counting the bytes used, so
/// that binary data can follow text. A line or word longer than its limit fails: binary garbage
/// is noticed early and never collected in memory.
class TextCursor {
 public:
  static constexpr std::size_t kMaxLine = std::size_t{1} << 16;
  static constexpr std::size_t kMaxWord = 512;

  /// `path` is what messages name.
  TextCursor(ByteStream& stream, std::string path) : stream_(stream), path_(std::move(path)) {}

  /// The next line without its end (\n or \r\n); nothing at the end of the stream.
  [[nodiscard]] Result<std::optional<std::string>> line();
  /// The next word; the one separator after it is used up. Empty at the end of the stream.
  /// Valid until the next call.
  [[nodiscard]] Result<std::string_view> word();
  /// The next byte, or fails.
  [[nodiscard]] Result<std::uint8_t> byte();
  /// Skips a line of any length; false at the end of the stream.
  [[nodiscard]] Result<bool> skip_line();
  /// Skips n bytes, or fails.
  [[nodiscard]] Result<void> skip(std::uint64_t n);
  /// Bytes used so far.
  [[nodiscard]] std::uint64_t position() const { return position_; }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  /// The next byte, or -1 at the end.
  [[nodiscard]] Result<int> next();
  [[nodiscard]] Result<void> fill();

  ByteStream& stream_;
  std::string path_;
  std::string buffer_;
  std::size_t used_ = 0;
  std::uint64_t position_ = 0;
  std::string word_;
};

}  // namespace lode::io
