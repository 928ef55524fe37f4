#include "lode/core/scalar_type.h"

#include <array>
#include <type_traits>
#include <utility>

namespace lode {

std::size_t size_of(ScalarType type) {
  return visit_scalar_type(type, []<typename T>() { return sizeof(T); });
}

bool is_floating(ScalarType type) {
  return visit_scalar_type(type, []<typename T>() { return std::is_floating_point_v<T>; });
}

bool is_valid(ScalarType type) { return type >= ScalarType::uint8 && type <= ScalarType::float64; }

std::string_view name_of(ScalarType type) {
  constexpr std::array<std::string_view, 11> kNames = {"?",     "uint8",   "int8",   "uint16",
                                                       "int16", "uint32",  "int32",  "uint64",
                                                       "int64", "float32", "float64"};
  return is_valid(type) ? kNames[static_cast<std::size_t>(type)] : kNames[0];
}

std::optional<ScalarType> scalar_type_from_name(std::string_view name) {
  using enum ScalarType;
  constexpr std::array<std::pair<std::string_view, ScalarType>, 47> kSpellings = {{
      {"uint8", uint8},
      {"uint8_t", uint8},
      {"uchar", uint8},
      {"unsigned char", uint8},
      {"unsigned_char", uint8},
      {"UInt8", uint8},
      {"int8", int8},
      {"int8_t", int8},
      {"char", int8},
      {"signed char", int8},
      {"Int8", int8},
      {"uint16", uint16},
      {"uint16_t", uint16},
      {"ushort", uint16},
      {"unsigned short", uint16},
      {"unsigned_short", uint16},
      {"UInt16", uint16},
      {"int16", int16},
      {"int16_t", int16},
      {"short", int16},
      {"Int16", int16},
      {"uint32", uint32},
      {"uint32_t", uint32},
      {"uint", uint32},
      {"unsigned int", uint32},
      {"unsigned_int", uint32},
      {"UInt32", uint32},
      {"int32", int32},
      {"int32_t", int32},
      {"int", int32},
      {"Int32", int32},
      {"uint64", uint64},
      {"uint64_t", uint64},
      {"ulong", uint64},
      {"UInt64", uint64},
      {"int64", int64},
      {"int64_t", int64},
      {"long", int64},
      {"Int64", int64},
      {"float32", float32},
      {"float", float32},
      {"Float32", float32},
      {"f32", float32},
      {"float64", float64},
      {"double", float64},
      {"Float64", float64},
      {"f64", float64},
  }};
  for (const auto& [spelling, type] : kSpellings)
    if (spelling == name) return type;
  return std::nullopt;
}

}  // namespace lode
