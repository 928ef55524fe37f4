#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

namespace lode::diamond {

/// The smallest T that is >= isovalue; nothing when every T is smaller.
template <typename T>
[[nodiscard]] std::optional<T> threshold_of(double isovalue) {
  if constexpr (std::is_integral_v<T>) {
    const double up = std::ceil(isovalue);
    if (up > static_cast<double>(std::numeric_limits<T>::max())) return {};
    return static_cast<T>(std::max(up, static_cast<double>(std::numeric_limits<T>::lowest())));
  } else {
    T t = static_cast<T>(isovalue);
    if (static_cast<double>(t) < isovalue)
      t = std::nextafter(t, std::numeric_limits<T>::infinity());
    return t;
  }
}

/// A box of rows of at least 32 samples each, and where their sign words go.
template <typename T>
struct SignRows {
  const T* samples;
  std::size_t row_step;    ///< In samples.
  std::size_t slice_step;  ///< In samples.
  std::uint32_t* words;
  std::size_t word_row_step;
  std::size_t word_slice_step;
  std::int32_t n_rows;
  std::int32_t n_slices;
  std::size_t next =
      0;  ///< How many samples on those are that will be read next, and are fetched; 0: none.
};

/// Sets bit x of each row's word: whether sample x is at least `threshold`. Bound by reading
/// samples.
void find_signs(const SignRows<std::uint8_t>& rows, std::uint8_t threshold);
void find_signs(const SignRows<std::uint16_t>& rows, std::uint16_t threshold);
void find_signs(const SignRows<std::int16_t>& rows, std::int16_t threshold);
void find_signs(const SignRows<float>& rows, float threshold);
void find_signs(const SignRows<double>& rows, double threshold);

}  // namespace lode::diamond
