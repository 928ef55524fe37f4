#include "lode/io/vtk_legacy_arrays.h"

#include <array>
#include <utility>

#include "lode/io/text.h"
#include "lode/io/text_samples.h"
#include "lode/io/vtk_legacy_skip.h"

namespace lode::io {
namespace {

/// Names are written with %20 for a blank and the like.
std::string decoded_name(std::string_view name) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string result;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (name[i] == '%' && i + 2 < name.size()) {
      const std::string hex = to_lower(name.substr(i + 1, 2));
      const std::size_t high = kDigits.find(hex[0]);
      const std::size_t low = kDigits.find(hex[1]);
      if (high != std::string_view::npos && low != std::string_view::npos) {
        result += static_cast<char>(high * 16 + low);
        i += 2;
        continue;
      }
    }
    result += name[i];
  }
  return result;
}

Result<std::int64_t> parse_count(const std::string& path, const std::string& text) {
  const auto count = to_int64(text);
  if (!count || *count < 0) return fail("{}: expected a count, got {}", path, in_quotes(text));
  return *count;
}

/// Attributes of the form KEYWORD name type, with a fixed number of components.
std::int64_t fixed_components(const std::string& keyword) {
  constexpr std::array<std::pair<std::string_view, std::int64_t>, 6> kKinds = {
      {{"VECTORS", 3},
       {"NORMALS", 3},
       {"TENSORS", 9},
       {"TENSORS6", 6},
       {"GLOBAL_IDS", 1},
       {"PEDIGREE_IDS", 1}}};
  for (const auto& [name, n] : kKinds)
    if (keyword == name) return n;
  return 0;
}

/// The type of an attribute's values, or that they are no numbers.
Result<void> set_type(const LegacyFile& file, const std::string& name, LegacyArray& array) {
  using Content = LegacyArray::Content;
  constexpr std::array<std::pair<std::string_view, Content>, 4> kOthers = {
      {{"bit", Content::bits},
       {"string", Content::strings},
       {"utf8_string", Content::strings},
       {"variant", Content::variants}}};
  for (const auto& [spelling, content] : kOthers)
    if (equals_ignoring_case(name, spelling)) {
      array.content = content;
      return {};
    }
  LODE_TRY(array.type, legacy_type(file.cursor.path(), name));
  return {};
}

Error malformed(const LegacyFile& file, const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  return fail("{}: expected a complete attribute line before byte {}, got {}", file.cursor.path(),
              file.cursor.position(), in_quotes(line));
}

Result<LegacyArray> parse_scalars(LegacyFile& file, const std::vector<std::string>& words) {
  if (words.size() < 3 || words.size() > 4) return malformed(file, words);
  LegacyArray array{.name = decoded_name(words[1])};
  LODE_CHECK(set_type(file, words[2], array));
  if (words.size() == 4) {
    LODE_TRY(array.n_components, parse_count(file.cursor.path(), words[3]));
  }
  LODE_TRY(const auto table, next_words(file));
  if (table.size() != 2 || !equals_ignoring_case(table[0], "LOOKUP_TABLE"))
    return fail("{}: expected LOOKUP_TABLE after SCALARS {}", file.cursor.path(),
                in_quotes(array.name));
  return array;
}

/// COLOR_SCALARS name n and LOOKUP_TABLE name n.
Result<LegacyArray> parse_colors(LegacyFile& file, const std::vector<std::string>& words,
                                 std::int64_t n_components) {
  if (words.size() != 3) return malformed(file, words);
  return LegacyArray{.name = decoded_name(words[1]),
                     .type = ScalarType::uint8,
                     .n_components = n_components,
                     .text = LegacyArray::Text::fractions};
}

Result<LegacyArray> parse_texture(LegacyFile& file, const std::vector<std::string>& words) {
  if (words.size() != 4) return malformed(file, words);
  LegacyArray array{.name = decoded_name(words[1])};
  LODE_TRY(array.n_components, parse_count(file.cursor.path(), words[2]));
  LODE_CHECK(set_type(file, words[3], array));
  return array;
}

Result<std::vector<LegacyArray>> parse_field(LegacyFile& file,
                                             const std::vector<std::string>& words) {
  if (words.size() != 3) return malformed(file, words);
  LODE_TRY(const std::int64_t n, parse_count(file.cursor.path(), words[2]));
  std::vector<LegacyArray> arrays;
  for (std::int64_t i = 0; i < n; ++i) {
    LODE_TRY(auto line, next_words(file));
    while (!line.empty() && line[0] == "METADATA") {
      LODE_CHECK(skip_metadata(file));
      LODE_TRY(line, next_words(file));
    }
    if (line.size() != 4) return malformed(file, line);
    LegacyArray array{.name = decoded_name(line[0])};
    LODE_TRY(array.n_components, parse_count(file.cursor.path(), line[1]));
    LODE_TRY(array.n_tuples, parse_count(file.cursor.path(), line[2]));
    LODE_CHECK(set_type(file, line[3], array));
    LODE_CHECK(skip_array(file, array));
    arrays.push_back(std::move(array));
  }
  return arrays;
}

/// The one array of an attribute other than FIELD; keyword in upper case.
Result<LegacyArray> parse_single(LegacyFile& file, const std::string& keyword,
                                 const std::vector<std::string>& words) {
  if (keyword == "SCALARS") return parse_scalars(file, words);
  if (keyword == "TEXTURE_COORDINATES") return parse_texture(file, words);
  if (keyword == "LOOKUP_TABLE") return parse_colors(file, words, 4);
  if (words.size() != 3) return malformed(file, words);
  if (keyword == "COLOR_SCALARS") {
    LODE_TRY(const std::int64_t n, parse_count(file.cursor.path(), words[2]));
    return parse_colors(file, words, n);
  }
  LegacyArray array{.name = decoded_name(words[1]), .n_components = fixed_components(keyword)};
  LODE_CHECK(set_type(file, words[2], array));
  return array;
}

bool is_single(const std::string& keyword) {
  return keyword == "SCALARS" || keyword == "TEXTURE_COORDINATES" || keyword == "LOOKUP_TABLE" ||
         keyword == "COLOR_SCALARS" || fixed_components(keyword) > 0;
}

std::string to_upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

/// Colours written as fractions of 255, as bytes.
Result<std::unique_ptr<SampleStore>> load_colors(const InputFilePtr& file, const LegacyArray& array,
                                                 const SampleStorage& storage) {
  constexpr ScalarType kText = ScalarType::float32;
  const auto n = static_cast<std::size_t>(array.n_bytes);
  LODE_TRY(const auto store, load_text({.file = file,
                                        .offset = array.offset,
                                        .type = kText,
                                        .n_bytes = array.n_bytes * size_of(kText)},
                                       storage));
  LODE_TRY(const auto fractions, read_doubles(*store, kText, native_byte_order(), n));
  std::vector<std::byte> bytes(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(fractions[i] >= 0 && fractions[i] <= 1))
      return fail("{}: expected colours from 0 to 1 in {}, got {}", file->path(),
                  in_quotes(array.name), fractions[i]);
    bytes[i] = static_cast<std::byte>(255.0 * fractions[i] + 0.5);  // as VTK rounds
  }
  return make_memory_store(std::move(bytes));
}

/// The number in "# vtk DataFile Version 5.1", without its fraction.
Result<std::int64_t> major_version(const std::string& path, std::string_view magic) {
  constexpr std::string_view kMagic = "# vtk DataFile Version";
  if (!magic.starts_with(kMagic))
    return fail("{}: expected '# vtk DataFile Version', got {}", path, in_quotes(magic));
  const auto version = to_double(trimmed(magic.substr(kMagic.size())));
  return version && *version >= 0 && *version < 100 ? static_cast<std::int64_t>(*version) : 0;
}

}  // namespace

Result<LegacyPreamble> parse_legacy_preamble(LegacyFile& file) {
  const std::string& path = file.cursor.path();
  LegacyPreamble preamble;
  LODE_TRY(const auto magic, file.cursor.line());
  LODE_TRY(preamble.version, major_version(path, magic.value_or("")));
  LODE_TRY(const auto title, file.cursor.line());
  LODE_TRY(const auto encoding, next_words(file));
  const std::string name = encoding.empty() ? "" : to_lower(encoding[0]);
  if (name != "ascii" && name != "binary")
    return fail("{}: expected ASCII or BINARY on the third line, got {}", path, in_quotes(name));
  file.encoding = name == "binary" ? LegacyEncoding::binary : LegacyEncoding::ascii;
  LODE_TRY(const auto dataset, next_words(file));
  preamble.dataset = dataset.size() == 2 ? dataset[1] : "";
  return preamble;
}

Result<std::vector<std::string>> next_words(LegacyFile& file) {
  while (true) {
    LODE_TRY(const auto line, file.cursor.line());
    if (!line) return std::vector<std::string>();
    const auto words = split_words(*line);
    if (!words.empty()) return std::vector<std::string>(words.begin(), words.end());
  }
}

Result<ScalarType> legacy_type(const std::string& path, const std::string& name) {
  const std::string lower = to_lower(name);
  // VTK writes its ids as int whatever their size in memory.
  constexpr std::array<std::pair<std::string_view, ScalarType>, 5> kSpellings = {
      {{"signed_char", ScalarType::int8},
       {"unsigned_long", ScalarType::uint64},
       {"vtktypeint64", ScalarType::int64},
       {"vtktypeuint64", ScalarType::uint64},
       {"vtkidtype", ScalarType::int32}}};
  for (const auto& [spelling, type] : kSpellings)
    if (lower == spelling) return type;
  const auto type = scalar_type_from_name(lower);
  if (!type) return fail("{}: expected a numeric type, got {}", path, in_quotes(name));
  return *type;
}

Result<LegacyAttribute> parse_legacy_attribute(LegacyFile& file,
                                               const std::vector<std::string>& words,
                                               std::int64_t n_tuples) {
  const std::string keyword = to_upper(words[0]);
  LegacyAttribute attribute{.is_known = true, .arrays = {}, .skipped = {}};
  if (keyword == "METADATA") {
    LODE_CHECK(skip_metadata(file));
  } else if (keyword == "FIELD") {
    LODE_TRY(attribute.arrays, parse_field(file, words));
  } else if (is_single(keyword)) {
    LODE_TRY(LegacyArray array, parse_single(file, keyword, words));
    array.n_tuples = n_tuples;
    if (keyword == "LOOKUP_TABLE") {
      LODE_TRY(array.n_tuples, parse_count(file.cursor.path(), words[2]));
    }
    LODE_CHECK(skip_array(file, array));
    if (keyword != "LOOKUP_TABLE") attribute.arrays.push_back(std::move(array));
  } else {
    attribute.is_known = false;
  }
  for (const LegacyArray& array : attribute.arrays)
    if (array.content != LegacyArray::Content::numbers) attribute.skipped.push_back(array.name);
  std::erase_if(attribute.arrays, [](const LegacyArray& array) {
    return array.content != LegacyArray::Content::numbers;
  });
  return attribute;
}

ByteOrder legacy_byte_order(LegacyEncoding encoding) {
  return encoding == LegacyEncoding::binary ? ByteOrder::big : native_byte_order();
}

Result<std::unique_ptr<SampleStore>> load_legacy_array(const InputFilePtr& file,
                                                       LegacyEncoding encoding,
                                                       const LegacyArray& array,
                                                       const SampleStorage& storage) {
  if (encoding == LegacyEncoding::binary) return make_file_store(file, array.offset, array.n_bytes);
  if (array.text == LegacyArray::Text::fractions) return load_colors(file, array, storage);
  return load_text(
      {.file = file, .offset = array.offset, .type = array.type, .n_bytes = array.n_bytes},
      storage);
}

}  // namespace lode::io
