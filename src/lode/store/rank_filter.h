#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace lode::store {

/// Elements of few different values, as measurements of 12 bits that were scaled to floating-point
/// numbers: the values, ascending as unsigned numbers, and which of them each element is.
struct RankedElements {
  std::vector<std::byte> values;
  std::vector<std::byte> ranks;  ///< u16.
};

/// None where more than a quarter of the elements, or 65536, differ. Elements of 4 or 8 bytes.
[[nodiscard]] std::optional<RankedElements> rank_elements(std::span<const std::byte> raw,
                                                          std::size_t element_size);

/// The inverse; false where a rank has no value. `ranks` holds 2 bytes for each element of `raw`.
[[nodiscard]] bool restore_ranked(const RankedElements& ranked, std::size_t element_size,
                                  std::span<std::byte> raw);

}  // namespace lode::store
