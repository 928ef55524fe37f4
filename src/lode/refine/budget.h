#pragma once

#include <cstdint>
#include <limits>

namespace lode {

/// How large the mesh of a cut may be.
struct Budget {
  std::uint64_t max_cells = std::numeric_limits<std::uint64_t>::max();  ///< Simplices.

  [[nodiscard]] bool is_limited() const {
    return max_cells != std::numeric_limits<std::uint64_t>::max();
  }
  friend bool operator==(const Budget&, const Budget&) = default;
};

/// What a new query has in common with the one before.
enum class FocusChange : std::uint8_t {
  changed,  ///< Perhaps nothing: candidates are looked for anew.
  same,     ///< Demand::touches is the same function: only tolerance, view or budget differ.
};

}  // namespace lode
