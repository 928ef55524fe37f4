#pragma once

#include <cstdint>

namespace lode::tetra_mt {

/// A region's bit in masks: of its place among a mesh's, modulo 64.
[[nodiscard]] constexpr std::uint64_t region_bit(std::uint32_t region) {
  return std::uint64_t{1} << region % 64;
}
/// All that masks may have, of so many regions.
[[nodiscard]] constexpr std::uint64_t mask_of_all(std::uint32_t n_regions) {
  return n_regions < 64 ? region_bit(n_regions) - 1 : ~std::uint64_t{0};
}

}  // namespace lode::tetra_mt
