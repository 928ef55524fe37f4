#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "lode/core/result.h"

namespace lode::io {

/// The JSON object in a metadata file. Fails, naming the file, when it is missing, larger than
/// 8 MiB, nested deeper than 64 levels, no JSON or no object.
[[nodiscard]] Result<nlohmann::json> read_json_object(const std::string& path);

/// The member `key` of an object; null where there is none or `object` is something else.
[[nodiscard]] const nlohmann::json* find_member(const nlohmann::json& object, std::string_view key);

/// Whether a value is this text. (Its == would make JSON of the text, and end the program where
/// there is no memory for that.)
[[nodiscard]] bool json_is(const nlohmann::json& value, std::string_view text);

/// The text under `key`; fails, naming `path` and the key, when it is missing or no text.
[[nodiscard]] Result<std::string> json_text(const std::string& path, const nlohmann::json& object,
                                            std::string_view key);

/// The list of whole numbers under `key`, at most `max_size` of them; fails as json_text does.
[[nodiscard]] Result<std::vector<std::int64_t>> json_whole_numbers(const std::string& path,
                                                                   const nlohmann::json& object,
                                                                   std::string_view key,
                                                                   std::size_t max_size);

/// A value as it stands in a file, in quotes and cut after 60 characters, for messages.
[[nodiscard]] std::string quoted_json(const nlohmann::json& value);
/// "nothing" for null.
[[nodiscard]] std::string quoted_json(const nlohmann::json* value);

}  // namespace lode::io
