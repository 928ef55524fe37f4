#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"
#include "lode/core/scalar_type.h"
#include "lode/io/image.h"
#include "lode/io/sample_storage.h"
#include "lode/io/text_cursor.h"

namespace lode::io {

/// An array somewhere in a legacy VTK file.
struct LegacyArray {
  enum class Text { numbers, fractions };  ///< fractions: of 255, for colours, which are bytes.
  enum class Content { numbers, bits, strings, variants };  ///< All but numbers are passed over.

  std::string name;
  ScalarType type = ScalarType::uint8;
  std::int64_t n_components = 1;
  std::int64_t n_tuples = 0;
  std::uint64_t offset = 0;   ///< In the file, of its numbers.
  std::uint64_t n_bytes = 0;  ///< As numbers of `type`, whether text or binary.
  Text text = Text::numbers;  ///< What stands for the numbers in an ASCII file.
  Content content = Content::numbers;
};

enum class LegacyEncoding { ascii, binary };

/// A legacy VTK file being parsed.
struct LegacyFile {
  TextCursor cursor;
  LegacyEncoding encoding = LegacyEncoding::ascii;
  std::int64_t n_components = 1;  ///< Of the array before, whose METADATA may follow.
};

/// What the first lines of a legacy VTK file say.
struct LegacyPreamble {
  std::int64_t version = 0;  ///< Without its fraction; 0 where there is no number.
  std::string dataset;       ///< As written; empty where the line is malformed.
};

/// Parses them, and sets the file's encoding.
[[nodiscard]] Result<LegacyPreamble> parse_legacy_preamble(LegacyFile& file);

/// The next line that is not blank, as words; empty at the end of the file.
[[nodiscard]] Result<std::vector<std::string>> next_words(LegacyFile& file);

/// "unsigned_char", "vtktypeint64", ... as the legacy format spells them.
[[nodiscard]] Result<ScalarType> legacy_type(const std::string& path, const std::string& name);

/// What one attribute line and its data are: no array for those that only have to be skipped,
/// several for a FIELD.
struct LegacyAttribute {
  bool is_known = false;
  std::vector<LegacyArray> arrays;   ///< Of numbers.
  std::vector<std::string> skipped;  ///< The names of others.
};

/// Parses SCALARS, VECTORS, FIELD and so on, whose first line is `words`, with n_tuples values.
[[nodiscard]] Result<LegacyAttribute> parse_legacy_attribute(LegacyFile& file,
                                                             const std::vector<std::string>& words,
                                                             std::int64_t n_tuples);

/// The byte order that a loaded array has: text is decoded to this machine's.
[[nodiscard]] ByteOrder legacy_byte_order(LegacyEncoding encoding);

/// Finds or decodes the numbers of an array whose place skip_array() noted.
[[nodiscard]] Result<std::unique_ptr<SampleStore>> load_legacy_array(const InputFilePtr& file,
                                                                     LegacyEncoding encoding,
                                                                     const LegacyArray& array,
                                                                     const SampleStorage& storage);

}  // namespace lode::io
