#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace lode {

/// The sample types Lode reads, stores and extracts from. The numbers are part of the .lode format.
enum class ScalarType : std::uint8_t {
  uint8 = 1,
  int8 = 2,
  uint16 = 3,
  int16 = 4,
  uint32 = 5,
  int32 = 6,
  uint64 = 7,
  int64 = 8,
  float32 = 9,
  float64 = 10,
};

[[nodiscard]] std::size_t size_of(ScalarType type);
[[nodiscard]] bool is_floating(ScalarType type);
/// "uint8", "float32", ...
[[nodiscard]] std::string_view name_of(ScalarType type);
/// Accepts the names above and the usual spellings: uchar, short, ushort, int, float, double, ...
[[nodiscard]] std::optional<ScalarType> scalar_type_from_name(std::string_view name);
[[nodiscard]] bool is_valid(ScalarType type);

template <typename T>
inline constexpr ScalarType scalar_type_of = [] {
  if constexpr (std::is_same_v<T, std::uint8_t>)
    return ScalarType::uint8;
  else if constexpr (std::is_same_v<T, std::int8_t>)
    return ScalarType::int8;
  else if constexpr (std::is_same_v<T, std::uint16_t>)
    return ScalarType::uint16;
  else if constexpr (std::is_same_v<T, std::int16_t>)
    return ScalarType::int16;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return ScalarType::uint32;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return ScalarType::int32;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return ScalarType::uint64;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return ScalarType::int64;
  else if constexpr (std::is_same_v<T, float>)
    return ScalarType::float32;
  else if constexpr (std::is_same_v<T, double>)
    return ScalarType::float64;
}();

/// Calls f.template operator()<T>() with the C++ type of `type`.
template <typename F>
decltype(auto) visit_scalar_type(ScalarType type, F&& f) {
  switch (type) {
    case ScalarType::uint8: return f.template operator()<std::uint8_t>();
    case ScalarType::int8: return f.template operator()<std::int8_t>();
    case ScalarType::uint16: return f.template operator()<std::uint16_t>();
    case ScalarType::int16: return f.template operator()<std::int16_t>();
    case ScalarType::uint32: return f.template operator()<std::uint32_t>();
    case ScalarType::int32: return f.template operator()<std::int32_t>();
    case ScalarType::uint64: return f.template operator()<std::uint64_t>();
    case ScalarType::int64: return f.template operator()<std::int64_t>();
    case ScalarType::float32: return f.template operator()<float>();
    case ScalarType::float64: break;
  }
  return f.template operator()<double>();
}

}  // namespace lode
