#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "lode/core/volume.h"

namespace lode::oracles {

/// A volume of zeros.
[[nodiscard]] inline Volume empty_volume(const RegularGrid& grid, ScalarType type) {
  Volume volume{{.grid = grid, .type = type, .field_name = {}, .nodata = {}}, {}};
  volume.samples.resize(static_cast<std::size_t>(grid.n_samples()) * size_of(type));
  return volume;
}

/// field(p) at each sample p, x fastest, as T.
template <typename T, typename Field>
[[nodiscard]] Volume volume_of(const RegularGrid& grid, const Field& field) {
  std::vector<T> samples;
  samples.reserve(static_cast<std::size_t>(grid.n_samples()));
  Index3 p;
  for (p[2] = 0; p[2] < grid.dims[2]; ++p[2])
    for (p[1] = 0; p[1] < grid.dims[1]; ++p[1])
      for (p[0] = 0; p[0] < grid.dims[0]; ++p[0]) samples.push_back(static_cast<T>(field(p)));
  return make_volume<T>(grid, samples);
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
