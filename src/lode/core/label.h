#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lode {

// Names that people gave to parts of meshes.

inline constexpr std::size_t kMaxLabelBytes = 4096;

/// What is wrong with a text as a label; nothing where it is UTF-8 of up to kMaxLabelBytes without
/// control characters.
[[nodiscard]] std::optional<std::string> label_fault(std::string_view text);

/// A label of any bytes: blanks for control characters, "?" for bytes that are no UTF-8, and of a
/// text that is longer its beginning with "..." behind. A label stays as it is.
[[nodiscard]] std::string to_label(std::string_view text);

}  // namespace lode
