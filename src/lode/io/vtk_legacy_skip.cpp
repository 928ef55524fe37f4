// After vtkDataWriter and vtkDataReader of VTK 9.
#include "lode/io/vtk_legacy_skip.h"

#include <array>

#include "lode/io/text.h"

namespace lode::io {
namespace {

Result<void> skip_lines(LegacyFile& file, const LegacyArray& array, std::uint64_t n) {
  for (std::uint64_t i = 0; i < n; ++i) {
    LODE_TRY(const bool is_there, file.cursor.skip_line());
    if (!is_there)
      return fail("{}: expected {} lines for {}, got {}", file.cursor.path(), n,
                  in_quotes(array.name), i);
  }
  return {};
}

Result<void> skip_words(LegacyFile& file, const LegacyArray& array, std::uint64_t n) {
  for (std::uint64_t i = 0; i < n; ++i) {
    LODE_TRY(const std::string_view word, file.cursor.word());
    if (word.empty())
      return fail("{}: expected {} numbers for {}, got {}", file.cursor.path(), n,
                  in_quotes(array.name), i);
  }
  return {};
}

/// Each has its length before it: the first two bits say in how many bytes, 1 to 8, the first of
/// which is the most significant one.
Result<void> skip_binary_strings(LegacyFile& file, std::uint64_t n) {
  for (std::uint64_t i = 0; i < n; ++i) {
    LODE_TRY(const std::uint8_t first, file.cursor.byte());
    constexpr std::array<int, 4> kBytesAfter = {7, 3, 1, 0};
    std::uint64_t length = first & 0x3FU;
    for (int k = 0; k < kBytesAfter[first >> 6U]; ++k) {
      LODE_TRY(const std::uint8_t next, file.cursor.byte());
      length = length << 8U | next;
    }
    LODE_CHECK(file.cursor.skip(length));
  }
  return {};
}

}  // namespace

Result<void> skip_array(LegacyFile& file, LegacyArray& array) {
  using Content = LegacyArray::Content;
  file.n_components = array.n_components;
  array.offset = file.cursor.position();
  if (array.n_tuples == 0 || array.n_components == 0) return {};
  const bool is_binary = file.encoding == LegacyEncoding::binary;
  const bool is_numbers = array.content == Content::numbers;
  const std::array<std::int64_t, 2> counts = {array.n_tuples, array.n_components};
  LODE_TRY(const std::uint64_t n_bytes,
           checked_n_bytes(file.cursor.path(), counts, is_numbers ? size_of(array.type) : 1));
  const std::uint64_t n = is_numbers ? n_bytes / size_of(array.type) : n_bytes;
  if (is_numbers) array.n_bytes = n_bytes;
  if (array.content == Content::variants) return skip_lines(file, array, n);
  if (array.content == Content::strings)
    return is_binary ? skip_binary_strings(file, n) : skip_lines(file, array, n);
  if (!is_binary) return skip_words(file, array, n);
  return file.cursor.skip(is_numbers ? n_bytes : (n - 1) / 8 + 1);
}

Result<void> skip_metadata(LegacyFile& file) {
  std::int64_t n_keys = 0;  // to come
  while (true) {
    LODE_TRY(const auto line, file.cursor.line());
    if (!line && n_keys > 0)
      return fail("{}: expected {} more keys in METADATA, got the end", file.cursor.path(), n_keys);
    if (!line) return {};
    const auto words = split_words(*line);
    if (words.empty() && n_keys <= 0) return {};
    if (words.empty()) continue;  // a key's text
    if (words[0] == "NAME") --n_keys;
    if (equals_ignoring_case(words[0], "INFORMATION") && words.size() == 2)
      n_keys = to_int64(words[1]).value_or(0);
    if (!equals_ignoring_case(words[0], "COMPONENT_NAMES")) continue;
    for (std::int64_t i = 0; i < file.n_components; ++i) {
      LODE_TRY(const bool is_there, file.cursor.skip_line());
      if (!is_there) return {};
    }
  }
}

}  // namespace lode::io
