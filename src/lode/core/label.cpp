#include "lode/core/label.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace lode {
namespace {

std::uint32_t byte_at(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

/// Bytes of the character there; 0 where they are no UTF-8 (RFC 3629).
std::size_t character_bytes(std::string_view text, std::size_t at) {
  struct Form {
    std::uint32_t mask;
    std::uint32_t mark;
    std::uint32_t smallest;  ///< Shorter forms have what is below.
  };
  constexpr std::array<Form, 4> kForms{
      {{0x80, 0x00, 0}, {0xE0, 0xC0, 0x80}, {0xF0, 0xE0, 0x800}, {0xF8, 0xF0, 0x10000}}};
  constexpr std::uint32_t kLast = 0x10FFFF;
  for (std::size_t n = 1; n <= kForms.size(); ++n) {
    const Form& form = kForms[n - 1];
    if ((byte_at(text, at) & form.mask) != form.mark) continue;
    if (n > text.size() - at) return 0;
    std::uint32_t code = byte_at(text, at) & ~form.mask;
    for (std::size_t i = 1; i < n; ++i) {
      const std::uint32_t more = byte_at(text, at + i);
      if ((more & 0xC0U) != 0x80) return 0;
      code = code << 6 | (more & 0x3FU);
    }
    const bool is_surrogate = code >= 0xD800 && code < 0xE000;
    return code < form.smallest || code > kLast || is_surrogate ? 0 : n;
  }
  return 0;
}

/// C0, DEL, and C1, which UTF-8 has as C2 80 to C2 9F.
bool is_control(std::string_view text, std::size_t at) {
  const std::uint32_t byte = byte_at(text, at);
  return byte < 0x20 || byte == 0x7F ||
         (byte == 0xC2 && at + 1 < text.size() && byte_at(text, at + 1) < 0xA0);
}

}  // namespace

std::optional<std::string> label_fault(std::string_view text) {
  if (text.size() > kMaxLabelBytes)
    return fmt::format("{} bytes, more than {}", text.size(), kMaxLabelBytes);
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t n = character_bytes(text, at);
    if (n == 0) return fmt::format("byte {:#04x} at {}, which is no UTF-8", byte_at(text, at), at);
    if (is_control(text, at)) return fmt::format("a control character at byte {}", at);
    at += n;
  }
  return std::nullopt;
}

std::string to_label(std::string_view text) {
  constexpr std::string_view kMore = "...";
  std::string label;
  std::size_t n_kept = 0;  // what of it is left where more is behind
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t n = character_bytes(text, at);
    if (n == 0)
      label += '?';
    else if (is_control(text, at))
      label += ' ';
    else
      label += text.substr(at, n);
    at += std::max<std::size_t>(n, 1);
    if (label.size() > kMaxLabelBytes) return label.substr(0, n_kept).append(kMore);
    if (label.size() <= kMaxLabelBytes - kMore.size()) n_kept = label.size();
  }
  return label;
}

}  // namespace lode
