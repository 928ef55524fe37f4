#pragma once

#include <array>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/models/diamond/lattice_field.h"

namespace lode::diamond {

/// Samples of a box of a field, on a lattice of their own.
template <int D>
struct FlatField : LatticeField<D, FlatField<D>> {
  UninitializedArray<std::byte> samples;  ///< x fastest.

  [[nodiscard]] double value(const Index<D>& p) const {
    const std::size_t at = linear_index<D>(this->shape.dims, this->clamped(p));
    return visit_storage_type(this->storage, [&]<typename T>() {
      T sample;
      std::memcpy(&sample, samples.data() + at * sizeof(T), sizeof(T));
      return static_cast<double>(sample);
    });
  }
  /// See NearSamples.
  template <typename Near>
  void find_near(Near& near, const Index<D>& centre, std::int32_t /*reach*/, int level) const {
    std::array<std::ptrdiff_t, as_size(D)> steps{};
    std::ptrdiff_t step = std::ptrdiff_t{1} << level;
    for (std::size_t i = 0; i < as_size(D); ++i, step *= this->shape.dims[i - 1]) steps[i] = step;
    using T = std::remove_cvref_t<decltype(near.at(centre))>;
    near.found(
        reinterpret_cast<const T*>(samples.data()) + linear_index<D>(this->shape.dims, centre),
        steps);
  }
};

}  // namespace lode::diamond
