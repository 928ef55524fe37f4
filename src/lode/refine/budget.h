#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace lode {

/// How large the mesh of a cut may be.
struct Budget {
  std::uint64_t max_cells = std::numeric_limits<std::uint64_t>::max();  ///< Simplices.

  [[nodiscard]] bool is_limited() const {
    return max_cells != std::numeric_limits<std::uint64_t>::max();
  }
  /// That, or less: as many cells as so many bytes hold.
  [[nodiscard]] Budget within(std::uint64_t n_bytes, std::uint64_t bytes_per_cell) const {
    return {std::min(max_cells, std::max<std::uint64_t>(1, n_bytes / bytes_per_cell))};
  }
  friend bool operator==(const Budget&, const Budget&) = default;
};

/// What a new query has in common with the one before.
enum class FocusChange : std::uint8_t {
  changed,  ///< Perhaps nothing: candidates are looked for anew.
  same,     ///< Demand::touches is the same function: only tolerance, view or budget differ.
};

/// In which order nodes are applied that all are to be.
enum class ApplyOrder : std::uint8_t {
  best_first,     ///< By demand: whenever it is stopped, what was wanted most is there.
  nearest_first,  ///< What was discovered last, which lies near: in about half of the time.
};

}  // namespace lode
