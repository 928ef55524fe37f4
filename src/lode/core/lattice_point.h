#pragma once

#include <cstdint>

namespace lode {

/// A node of a lattice: column and row.
struct LatticePoint {
  std::int32_t x = 0;
  std::int32_t y = 0;

  friend bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

}  // namespace lode
