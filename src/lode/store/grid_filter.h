#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace lode::store {

/// The grid that a block's elements lie on, x fastest.
struct ElementGrid {
  std::array<std::uint16_t, 3> n{};  ///< Points per axis.
  /// Points whose coordinates are all even are left out.
  bool lacks_even_points = false;

  [[nodiscard]] std::uint64_t n_elements() const {
    std::uint64_t all = 1;
    std::uint64_t even = 1;
    for (const std::uint64_t points : n) {
      all *= points;
      even *= (points + 1) / 2;
    }
    return lacks_even_points ? all - even : all;
  }
};

/// What is subtracted from all elements before they are predicted: the smallest, as signed or as
/// unsigned numbers, whichever are closer together.
[[nodiscard]] std::uint64_t find_origin(std::span<const std::byte> raw, std::size_t element_size);

/// Predicts each element from six neighbours that come before it, and writes the byte planes of
/// the coded differences; docs/format.md, section 4. `raw` and `planes` hold grid.n_elements().
void predict_grid(std::span<const std::byte> raw, std::size_t element_size, const ElementGrid& grid,
                  std::uint64_t origin, std::span<std::byte> planes);

/// The inverse, of any bytes.
void restore_grid(std::span<const std::byte> planes, std::size_t element_size,
                  const ElementGrid& grid, std::uint64_t origin, std::span<std::byte> raw);

}  // namespace lode::store
