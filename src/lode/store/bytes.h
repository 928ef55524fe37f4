#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "lode/core/result.h"

namespace lode::store {

static_assert(std::endian::native == std::endian::little,
              "the .lode format is little-endian and copied to memory as it is");

/// Numbers that the format stores as they lie in memory.
template <typename T>
concept Storable = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// Appends little-endian numbers, strings and arrays to a byte vector.
class ByteWriter {
 public:
  template <Storable T>
  void write(T value) {
    write_all(std::span<const T>(&value, 1));
  }
  /// The values alone; the count is the caller's to store.
  template <Storable T>
  void write_all(std::span<const T> values) {
    write_bytes(std::as_bytes(values));
  }
  void write_bytes(std::span<const std::byte> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  }
  /// A u32 length, then the bytes of the string.
  void write_string(std::string_view text) {
    LODE_EXPECTS(text.size() <= UINT32_MAX);
    write(static_cast<std::uint32_t>(text.size()));
    write_bytes(std::as_bytes(std::span(text.data(), text.size())));
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }
  [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Takes little-endian numbers, strings and arrays from bytes that nobody vouches for. Every
/// read is checked against what is left before anything is allocated; errors start with `what`.
class ByteReader {
 public:
  /// `bytes` must outlive the reader. what: the thing being read, "FILE: directory".
  ByteReader(std::span<const std::byte> bytes, std::string what)
      : bytes_(bytes), what_(std::move(what)) {}

  template <Storable T>
  [[nodiscard]] Result<T> read() {
    LODE_TRY(const auto taken, read_bytes(sizeof(T)));
    T value;
    std::memcpy(&value, taken.data(), sizeof(T));
    return value;
  }
  template <Storable T>
  [[nodiscard]] Result<std::vector<T>> read_all(std::uint64_t n) {
    if (n > n_left() / sizeof(T)) return shortage(n, sizeof(T));
    std::vector<T> values(static_cast<std::size_t>(n));
    const std::size_t size = values.size() * sizeof(T);
    if (size > 0) std::memcpy(values.data(), bytes_.data() + position_, size);
    position_ += size;
    return values;
  }
  /// A view of the next `n` bytes.
  [[nodiscard]] Result<std::span<const std::byte>> read_bytes(std::uint64_t n) {
    if (n > n_left()) return shortage(n, 1);
    const auto taken = bytes_.subspan(position_, static_cast<std::size_t>(n));
    position_ += taken.size();
    return taken;
  }
  /// What write_string wrote.
  [[nodiscard]] Result<std::string> read_string() {
    LODE_TRY(const std::uint32_t n, read<std::uint32_t>());
    LODE_TRY(const auto taken, read_bytes(n));
    return std::string(reinterpret_cast<const char*>(taken.data()), taken.size());
  }
  /// Fails when bytes are left over.
  [[nodiscard]] Result<void> expect_end() const {
    if (n_left() == 0) return {};
    return fail("{}: expected the end at byte {}, got {} more bytes", what_, position_, n_left());
  }

  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t n_left() const { return bytes_.size() - position_; }

 private:
  [[nodiscard]] Error shortage(std::uint64_t n, std::size_t size) const {
    return fail("{}: expected {} items of {} bytes at byte {}, got only {} bytes", what_, n, size,
                position_, n_left());
  }

  std::span<const std::byte> bytes_;
  std::string what_;
  std::size_t position_ = 0;
};

}  // namespace lode::store
