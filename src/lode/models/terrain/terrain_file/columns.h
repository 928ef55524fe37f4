#pragma once

// Columns of numbers in blocks, each of kPart but the last.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "lode/core/result.h"
#include "lode/store/bytes.h"
#include "lode/store/codec.h"
#include "lode/store/reader.h"
#include "lode/store/writer.h"

namespace lode::terrain_file {

/// Numbers in a block.
inline constexpr std::uint32_t kPart = 1U << 16;

/// Which column a block is of: its kind, and a level where there are several.
struct ColumnKey {
  std::uint32_t kind = 0;
  std::uint32_t level = 0;

  [[nodiscard]] store::BlockKey block(std::uint64_t part) const {
    return {kind, level, {{static_cast<std::int32_t>(part), 0, 0}}};
  }
};

/// number(i) of the n numbers of a column.
template <typename T, typename Number>
Result<void> append_column(const ColumnKey& column, std::uint64_t n, const Number& number,
                           store::Writer& writer) {
  std::vector<T> part;
  for (std::uint64_t first = 0; first < n; first += kPart) {
    part.clear();
    for (std::uint64_t i = first; i < std::min<std::uint64_t>(n, first + kPart); ++i)
      part.push_back(number(i));
    LODE_CHECK(writer.append(
        column.block(first / kPart),
        store::encode_block({.raw = std::as_bytes(std::span<const T>(part)), .size = sizeof(T)})));
  }
  return {};
}

/// One block of a column of n numbers.
template <typename T>
Result<std::vector<T>> read_part(const store::Reader& reader, const ColumnKey& column,
                                 std::uint64_t n, std::uint64_t part) {
  const store::BlockKey key = column.block(part);
  const auto at = reader.find(key);
  if (!at) return fail("{}: expected {}, found none", reader.path(), store::describe(key));
  LODE_TRY(const std::vector<std::byte> bytes, reader.read_block(*at));
  store::ByteReader in(bytes, reader.path() + ": " + store::describe(key));
  LODE_TRY(std::vector<T> numbers,
           in.read_all<T>(std::min<std::uint64_t>(kPart, n - part * kPart)));
  LODE_CHECK(in.expect_end());
  return numbers;
}

/// All n numbers of a column. Blocks are there before memory is asked for.
template <typename T>
Result<std::vector<T>> read_column(const store::Reader& reader, const ColumnKey& column,
                                   std::uint64_t n) {
  std::vector<T> numbers;
  for (std::uint64_t first = 0; first < n; first += kPart) {
    LODE_TRY(const std::vector<T> part, read_part<T>(reader, column, n, first / kPart));
    numbers.insert(numbers.end(), part.begin(), part.end());
  }
  return numbers;
}

}  // namespace lode::terrain_file
