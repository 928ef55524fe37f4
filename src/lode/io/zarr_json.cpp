#include "lode/io/zarr_json.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "lode/io/input_file.h"
#include "lode/io/text.h"

namespace lode::io {
namespace {

using nlohmann::json;

/// Parsed JSON takes some twenty times the memory of its text, and recursion takes stack.
constexpr std::uint64_t kMaxJsonBytes = std::uint64_t{8} << 20;
constexpr int kMaxJsonDepth = 64;

bool is_nested_too_deeply(std::string_view text) {
  int depth = 0;
  bool is_in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (is_in_string) {
      if (c == '\\') ++i;
      if (c == '"') is_in_string = false;
    } else if (c == '"') {
      is_in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxJsonDepth) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

bool is_int64(const json& value) {
  if (!value.is_number_integer()) return false;
  return !value.is_number_unsigned() ||
         value.get<std::uint64_t>() <= std::numeric_limits<std::int64_t>::max();
}

}  // namespace

Result<json> read_json_object(const std::string& path) {
  LODE_TRY(const InputFilePtr file, InputFile::open(path));
  if (file->size() > kMaxJsonBytes)
    return fail("{}: expected at most {} bytes of metadata, got {}", path, kMaxJsonBytes,
                file->size());
  std::string text(static_cast<std::size_t>(file->size()), '\0');
  LODE_CHECK(file->read(0, std::as_writable_bytes(std::span(text))));
  if (is_nested_too_deeply(text))
    return fail("{}: expected JSON nested at most {} levels deep, got more", path, kMaxJsonDepth);
  json value = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (value.is_discarded()) return fail("{}: expected JSON, got something else", path);
  if (!value.is_object())
    return fail("{}: expected a JSON object, got {}", path, quoted_json(value));
  return value;
}

const json* find_member(const json& object, std::string_view key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

bool json_is(const json& value, std::string_view text) {
  const auto* const held = value.get_ptr<const std::string*>();
  return held != nullptr && *held == text;
}

Result<std::string> json_text(const std::string& path, const json& object, std::string_view key) {
  const json* value = find_member(object, key);
  if (value == nullptr || !value->is_string())
    return fail("{}: expected text for {}, got {}", path, key, quoted_json(value));
  return value->get<std::string>();
}

Result<std::vector<std::int64_t>> json_whole_numbers(const std::string& path, const json& object,
                                                     std::string_view key, std::size_t max_size) {
  const json* value = find_member(object, key);
  bool is_good = value != nullptr && value->is_array() && value->size() <= max_size;
  if (is_good)
    for (const json& each : *value) is_good = is_good && is_int64(each);
  if (!is_good)
    return fail("{}: expected a list of at most {} whole numbers for {}, got {}", path, max_size,
                key, quoted_json(value));
  return value->get<std::vector<std::int64_t>>();
}

std::string quoted_json(const json& value) {
  return in_quotes(value.dump(-1, ' ', false, json::error_handler_t::replace));
}

std::string quoted_json(const json* value) {
  return value == nullptr ? "nothing" : quoted_json(*value);
}

}  // namespace lode::io
