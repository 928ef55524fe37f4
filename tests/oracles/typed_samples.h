#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "lode/core/volume.h"

namespace lode::oracles {

/// A volume of zeros.
[[nodiscard]] inline Volume empty_volume(const RegularGrid& grid, ScalarType type) {
  Volume volume{{.grid = grid, .type = type, .field_name = {}, .nodata = {}}, {}};
  volume.samples.resize(static_cast<std::size_t>(grid.n_samples()) * size_of(type));
  return volume;
}

/// The samples of a volume of type T, for writing.
template <typename T>
[[nodiscard]] std::span<T> typed_samples(Volume& volume) {
  LODE_EXPECTS(scalar_type_of<T> == volume.info.type);
  return {reinterpret_cast<T*>(volume.samples.data()), volume.samples.size() / sizeof(T)};
}

/// value as T; integer types round to nearest (half away from zero) and clamp.
template <typename T>
[[nodiscard]] T to_sample(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    const double rounded = std::round(value);
    // The largest 64-bit integers round up to a power of two that T cannot hold: hence >=.
    if (rounded >= static_cast<double>(std::numeric_limits<T>::max()))
      return std::numeric_limits<T>::max();
    if (rounded <= static_cast<double>(std::numeric_limits<T>::lowest()))
      return std::numeric_limits<T>::lowest();
    return static_cast<T>(rounded);
  }
}

}  // namespace lode::oracles
