#include "lode/io/byte_stream.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

namespace lode::io {
namespace {

class FileStream final : public ByteStream {
 public:
  FileStream(InputFilePtr file, std::uint64_t offset, std::uint64_t n_bytes)
      : file_(std::move(file)),
        offset_(offset),
        n_left_(std::min(n_bytes, file_->size_from(offset))) {}

  Result<void> read(std::span<std::byte> out) override {
    LODE_CHECK(check(out.size()));
    LODE_CHECK(file_->read(offset_, out));
    advance(out.size());
    return {};
  }

  Result<void> skip(std::uint64_t n) override {
    LODE_CHECK(check(n));
    advance(n);
    return {};
  }

  std::uint64_t n_left() const override { return n_left_; }

 private:
  Result<void> check(std::uint64_t n) const {
    if (n <= n_left_) return {};
    return fail("{}: expected {} bytes from offset {}, got {}", file_->path(), n, offset_, n_left_);
  }
  void advance(std::uint64_t n) {
    offset_ += n;
    n_left_ -= n;
  }

  InputFilePtr file_;
  std::uint64_t offset_;
  std::uint64_t n_left_;
};

class MemoryStream final : public ByteStream {
 public:
  MemoryStream(std::string_view text, std::string path, std::shared_ptr<const void> owner)
      : text_(text), path_(std::move(path)), owner_(std::move(owner)) {}

  Result<void> read(std::span<std::byte> out) override {
    LODE_CHECK(check(out.size()));
    if (!out.empty()) std::memcpy(out.data(), text_.data(), out.size());
    text_.remove_prefix(out.size());
    return {};
  }

  Result<void> skip(std::uint64_t n) override {
    LODE_CHECK(check(n));
    text_.remove_prefix(static_cast<std::size_t>(n));
    return {};
  }

  std::uint64_t n_left() const override { return text_.size(); }

 private:
  Result<void> check(std::uint64_t n) const {
    if (n <= text_.size()) return {};
    return fail("{}: expected {} more bytes of data, got {}", path_, n, text_.size());
  }

  std::string_view text_;
  std::string path_;
  std::shared_ptr<const void> owner_;
};

constexpr int kPadding = 64;
constexpr int kSpace = 65;
constexpr int kBad = 66;

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  if (c == '=') return kPadding;
  return c == ' ' || (c >= '\t' && c <= '\r') ? kSpace : kBad;
}

class Base64Stream final : public ByteStream {
 public:
  Base64Stream(std::unique_ptr<ByteStream> text, std::string path)
      : text_(std::move(text)), path_(std::move(path)) {}

  Result<void> read(std::span<std::byte> out) override {
    std::size_t done = 0;
    while (done < out.size()) {
      if (next_ == n_ready_) LODE_CHECK(decode_group());
      while (next_ < n_ready_ && done < out.size()) out[done++] = ready_[next_++];
    }
    return {};
  }

  std::uint64_t n_left() const override {
    return (chunk_.size() - used_ + text_->n_left()) / 4 * 3 + (n_ready_ - next_);
  }

 private:
  Result<void> refill() {
    constexpr std::uint64_t kChunk = 1 << 16;
    chunk_.resize(static_cast<std::size_t>(std::min(kChunk, text_->n_left())));
    used_ = 0;
    if (chunk_.empty()) return fail("{}: the base64 data end too early", path_);
    return text_->read(std::as_writable_bytes(std::span(chunk_)));
  }

  Result<void> decode_group() {
    std::array<unsigned, 4> digits{};
    int n_digits = 0;
    int n_padding = 0;
    while (n_digits + n_padding < 4) {
      if (used_ == chunk_.size()) LODE_CHECK(refill());
      const int digit = base64_digit(chunk_[used_]);
      if (digit == kBad || (digit < kPadding && n_padding > 0))
        return fail("{}: expected base64 data, got byte {}", path_,
                    static_cast<int>(static_cast<unsigned char>(chunk_[used_])));
      ++used_;
      if (digit == kPadding) ++n_padding;
      if (digit < kPadding)
        digits[static_cast<std::size_t>(n_digits++)] = static_cast<unsigned>(digit);
    }
    if (n_padding > 2) return fail("{}: expected base64 data, got too much padding", path_);
    const unsigned bits = digits[0] << 18 | digits[1] << 12 | digits[2] << 6 | digits[3];
    for (std::size_t i = 0; i < 3; ++i)
      ready_[i] = static_cast<std::byte>(bits >> (16 - 8 * i) & 0xff);
    n_ready_ = static_cast<std::size_t>(3 - n_padding);
    next_ = 0;
    return {};
  }

  std::unique_ptr<ByteStream> text_;
  std::string path_;
  std::string chunk_;
  std::size_t used_ = 0;  ///< Of chunk_.
  std::array<std::byte, 3> ready_{};
  std::size_t n_ready_ = 0;
  std::size_t next_ = 0;
};

}  // namespace

Result<void> ByteStream::skip(std::uint64_t n) {
  constexpr std::uint64_t kPieceBytes = 1 << 16;
  std::vector<std::byte> sink(static_cast<std::size_t>(std::min(n, kPieceBytes)));
  while (n > 0) {
    const auto piece = static_cast<std::size_t>(std::min<std::uint64_t>(n, sink.size()));
    LODE_CHECK(read(std::span(sink).first(piece)));
    n -= piece;
  }
  return {};
}

std::unique_ptr<ByteStream> make_file_stream(InputFilePtr file, std::uint64_t offset,
                                             std::uint64_t n_bytes) {
  return std::make_unique<FileStream>(std::move(file), offset, n_bytes);
}

std::unique_ptr<ByteStream> make_file_stream(InputFilePtr file, std::uint64_t offset) {
  const std::uint64_t n_bytes = file->size_from(offset);
  return make_file_stream(std::move(file), offset, n_bytes);
}

std::unique_ptr<ByteStream> make_base64_stream(std::unique_ptr<ByteStream> text, std::string path) {
  return std::make_unique<Base64Stream>(std::move(text), std::move(path));
}

std::unique_ptr<ByteStream> make_memory_stream(std::string_view text, std::string path,
                                               std::shared_ptr<const void> owner) {
  return std::make_unique<MemoryStream>(text, std::move(path), std::move(owner));
}

}  // namespace lode::io
