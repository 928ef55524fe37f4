#pragma once

#include <cstdint>

#include "lode/core/vec.h"

namespace lode {

/// A point of the sample lattice, packed 21 bits a coordinate, x lowest. The sum of two keys is
/// the key of their doubled midpoint: every edge of a hierarchy has its own.
using LatticeKey = std::uint64_t;

inline constexpr int kKeyBits = 21;
inline constexpr std::uint64_t kKeyMask = (std::uint64_t{1} << kKeyBits) - 1;
/// In the key of an edge (its doubled midpoint, and its first end): of two vertices there the
/// second.
inline constexpr LatticeKey kTwin = LatticeKey{1} << (3 * kKeyBits);

[[nodiscard]] constexpr LatticeKey to_key(const Index3& p) {
  return static_cast<std::uint64_t>(p[0]) | static_cast<std::uint64_t>(p[1]) << kKeyBits |
         static_cast<std::uint64_t>(p[2]) << (2 * kKeyBits);
}

[[nodiscard]] constexpr Index3 to_point(LatticeKey key) {
  return {{static_cast<std::int32_t>(key & kKeyMask),
           static_cast<std::int32_t>((key >> kKeyBits) & kKeyMask),
           static_cast<std::int32_t>((key >> (2 * kKeyBits)) & kKeyMask)}};
}

}  // namespace lode
