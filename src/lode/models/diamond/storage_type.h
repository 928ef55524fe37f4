#pragma once

#include <cstddef>
#include <cstdint>

#include "lode/core/scalar_type.h"

namespace lode::diamond {

/// The types samples are held in. Others are widened to the next that holds them exactly (int8 to
/// int16; 32-bit integers to double); 64-bit integers become doubles, exact up to 53 bits.
[[nodiscard]] inline ScalarType storage_type(ScalarType type) {
  switch (type) {
    case ScalarType::uint8:
    case ScalarType::uint16:
    case ScalarType::int16:
    case ScalarType::float32: return type;
    case ScalarType::int8: return ScalarType::int16;
    default: return ScalarType::float64;
  }
}

/// Whether ranges of samples held in this type are exact. Others are rounded (see round_range()).
[[nodiscard]] inline bool has_exact_ranges(ScalarType storage) { return size_of(storage) == 1; }

/// Calls f.template operator()<T>() with the storage type of `type`.
template <typename F>
decltype(auto) visit_storage_type(ScalarType type, F&& f) {
  switch (storage_type(type)) {
    case ScalarType::uint8: return f.template operator()<std::uint8_t>();
    case ScalarType::uint16: return f.template operator()<std::uint16_t>();
    case ScalarType::int16: return f.template operator()<std::int16_t>();
    case ScalarType::float32: return f.template operator()<float>();
    default: return f.template operator()<double>();
  }
}

}  // namespace lode::diamond
