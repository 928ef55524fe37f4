#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "lode/io/zarr_json.h"
#include "lode/io/zarr_metadata.h"

namespace lode::io {
namespace {

using nlohmann::json;

template <typename T>
std::optional<T> whole_fill(const json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    if (number > static_cast<std::uint64_t>(std::numeric_limits<T>::max())) return std::nullopt;
    return static_cast<T>(number);
  }
  if (value.is_number_integer()) {
    const auto number = value.get<std::int64_t>();  // negative: others are unsigned
    if (number < static_cast<std::int64_t>(std::numeric_limits<T>::min())) return std::nullopt;
    return static_cast<T>(number);
  }
  if (!value.is_number_float()) return std::nullopt;
  // 2^digits, which the conversion of max() may or may not round to, bounds T from above.
  const double number = value.get<double>();
  const double beyond = std::ldexp(1.0, std::numeric_limits<T>::digits);
  const double lowest = std::numeric_limits<T>::is_signed ? -beyond : 0;
  if (!(number >= lowest && number < beyond) || number != std::trunc(number)) return std::nullopt;
  return static_cast<T>(number);
}

/// The number whose bits the text "0x..." gives, the most significant first.
template <typename T>
std::optional<T> fill_of_bits(std::string_view text) {
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  if (!text.starts_with("0x") || text.size() != 2 + 2 * sizeof(T)) return std::nullopt;
  Bits bits = 0;
  const auto [end, error] = std::from_chars(text.data() + 2, text.data() + text.size(), bits, 16);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  T number;
  std::memcpy(&number, &bits, sizeof number);
  return number;
}

template <typename T>
std::optional<T> floating_fill(const json& value) {
  if (value.is_number()) {
    const auto number = static_cast<T>(value.get<double>());
    // JSON has no infinities: this was a number beyond the type.
    return std::isfinite(number) ? std::optional(number) : std::nullopt;
  }
  if (!value.is_string()) return std::nullopt;
  const auto& text = value.get_ref<const std::string&>();
  if (text == "NaN") return std::numeric_limits<T>::quiet_NaN();
  if (text == "Infinity") return std::numeric_limits<T>::infinity();
  if (text == "-Infinity") return -std::numeric_limits<T>::infinity();
  return fill_of_bits<T>(text);
}

}  // namespace

Result<ZarrFill> parse_zarr_fill(const std::string& path, ScalarType type, const json* value) {
  ZarrFill fill{};
  if (value == nullptr || value->is_null()) return fill;
  const bool is_good = visit_scalar_type(type, [&]<typename T>() {
    std::optional<T> number;
    if constexpr (std::is_floating_point_v<T>)
      number = floating_fill<T>(*value);
    else
      number = whole_fill<T>(*value);
    if (number) std::memcpy(fill.data(), &*number, sizeof(T));
    return number.has_value();
  });
  if (is_good) return fill;
  return fail("{}: expected a fill_value of type {}, got {}", path, name_of(type),
              quoted_json(*value));
}

}  // namespace lode::io
