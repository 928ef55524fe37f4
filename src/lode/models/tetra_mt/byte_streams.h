#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/result.h"

namespace lode::tetra_mt {

/// Columns of bytes one after the other, each compressed for itself: how many bytes it takes, in
/// groups of 7 bits, the lowest first, all but the last with bit 7; then these. None: all zeros. As
/// many as there are: as they are. Else a zstd frame.
class StreamWriter {
 public:
  void add(std::span<const std::uint8_t> column);
  /// Numbers by byte: the lowest of all, then the next ones.
  template <typename T>
  void add_planes(std::span<const T> numbers) {
    std::vector<std::uint8_t> plane(numbers.size());
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      for (std::size_t i = 0; i < numbers.size(); ++i)
        plane[i] = static_cast<std::uint8_t>(numbers[i] >> (8 * b));
      add(plane);
    }
  }
  [[nodiscard]] std::vector<std::byte> take() && { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Takes what StreamWriter made from bytes that nobody vouches for.
class StreamReader {
 public:
  /// `bytes` must outlive the reader. what: the thing being read, for messages.
  StreamReader(std::span<const std::byte> bytes, std::string what)
      : bytes_(bytes), what_(std::move(what)) {}

  /// The next column, of n bytes; n is the caller's to bound.
  [[nodiscard]] Result<std::vector<std::uint8_t>> read(std::size_t n);
  template <typename T>
  [[nodiscard]] Result<std::vector<T>> read_planes(std::size_t n) {
    std::vector<T> numbers(n, 0);
    for (std::size_t b = 0; b < sizeof(T); ++b) {
      LODE_TRY(const auto plane, read(n));
      for (std::size_t i = 0; i < n; ++i)
        numbers[i] = static_cast<T>(numbers[i] | static_cast<T>(T{plane[i]} << (8 * b)));
    }
    return numbers;
  }
  [[nodiscard]] Result<void> expect_end() const;
  [[nodiscard]] const std::string& what() const { return what_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  std::string what_;
};

}  // namespace lode::tetra_mt
