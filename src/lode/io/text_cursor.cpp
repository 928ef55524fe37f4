#include "lode/io/text_cursor.h"

#include <algorithm>

namespace lode::io {
namespace {

bool is_space(int c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

}  // namespace

Result<void> TextCursor::fill() {
  constexpr std::uint64_t kChunk = 1 << 16;
  buffer_.resize(static_cast<std::size_t>(std::min(kChunk, stream_.n_left())));
  used_ = 0;
  return stream_.read(std::as_writable_bytes(std::span(buffer_.data(), buffer_.size())));
}

Result<int> TextCursor::next() {
  if (used_ == buffer_.size()) {
    LODE_CHECK(fill());
    if (buffer_.empty()) return -1;
  }
  ++position_;
  return static_cast<int>(static_cast<unsigned char>(buffer_[used_++]));
}

Result<std::optional<std::string>> TextCursor::line() {
  std::string text;
  LODE_TRY(int c, next());
  if (c < 0) return std::optional<std::string>();
  while (c >= 0 && c != '\n') {
    if (text.size() == kMaxLine)
      return fail("{}: expected a text header, got a line longer than {} bytes", path_, kMaxLine);
    text += static_cast<char>(c);
    LODE_TRY(c, next());
  }
  if (!text.empty() && text.back() == '\r') text.pop_back();
  return std::optional<std::string>(std::move(text));
}

Result<std::string_view> TextCursor::word() {
  word_.clear();
  LODE_TRY(int c, next());
  while (is_space(c)) {
    LODE_TRY(c, next());
  }
  while (c >= 0 && !is_space(c)) {
    if (word_.size() == kMaxWord)
      return fail("{}: expected text, got a word longer than {} bytes", path_, kMaxWord);
    word_ += static_cast<char>(c);
    LODE_TRY(c, next());
  }
  return std::string_view(word_);
}

Result<std::uint8_t> TextCursor::byte() {
  LODE_TRY(const int c, next());
  if (c < 0) return fail("{}: expected more than {} bytes, got the end", path_, position_);
  return static_cast<std::uint8_t>(c);
}

Result<bool> TextCursor::skip_line() {
  LODE_TRY(int c, next());
  const bool is_there = c >= 0;
  while (c >= 0 && c != '\n') {
    LODE_TRY(c, next());
  }
  return is_there;
}

Result<void> TextCursor::skip(std::uint64_t n) {
  const std::uint64_t buffered = std::min<std::uint64_t>(n, buffer_.size() - used_);
  used_ += static_cast<std::size_t>(buffered);
  LODE_CHECK(stream_.skip(n - buffered));
  position_ += n;
  return {};
}

}  // namespace lode::io
