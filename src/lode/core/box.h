#pragma once

#include <algorithm>
#include <cstdint>

#include "lode/core/vec.h"

namespace lode {

/// Samples lower <= p < upper, per axis.
struct IndexBox {
  Index3 lower;
  Index3 upper;

  friend constexpr bool operator==(const IndexBox&, const IndexBox&) = default;
  [[nodiscard]] constexpr Index3 dims() const { return upper - lower; }
  [[nodiscard]] constexpr bool is_empty() const {
    return upper[0] <= lower[0] || upper[1] <= lower[1] || upper[2] <= lower[2];
  }
  [[nodiscard]] constexpr std::int64_t n_samples() const {
    if (is_empty()) return 0;
    const Index3 d = dims();
    return std::int64_t{d[0]} * d[1] * d[2];
  }
  [[nodiscard]] constexpr bool contains(const Index3& p) const {
    return p[0] >= lower[0] && p[1] >= lower[1] && p[2] >= lower[2] && p[0] < upper[0] &&
           p[1] < upper[1] && p[2] < upper[2];
  }
  [[nodiscard]] constexpr bool contains(const IndexBox& b) const {
    return b.is_empty() || (contains(b.lower) && contains(b.upper - Index3{{1, 1, 1}}));
  }
};

[[nodiscard]] constexpr IndexBox intersection(const IndexBox& a, const IndexBox& b) {
  IndexBox r;
  for (std::size_t i = 0; i < 3; ++i) {
    r.lower[i] = std::max(a.lower[i], b.lower[i]);
    r.upper[i] = std::min(a.upper[i], b.upper[i]);
  }
  return r;
}

/// Points lower <= p <= upper in world units, per axis.
struct Box3d {
  Vec3d lower;
  Vec3d upper;

  friend constexpr bool operator==(const Box3d&, const Box3d&) = default;
};

}  // namespace lode
