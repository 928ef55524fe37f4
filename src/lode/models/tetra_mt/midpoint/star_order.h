#pragma once

// The order of the tetrahedra round a vertex, which hierarchies and cuts share.

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <span>

namespace lode::tetra_mt::midpoint {

/// Tetrahedra round a vertex of which a node says whose they are: those of a sphere of kMaxLink.
inline constexpr std::size_t kMaxStar = 60;

/// The labels of a triangle, ascending: no two of a star are the same.
struct StarKey {
  std::uint64_t first;  ///< The smallest, and the next one.
  std::uint32_t last;

  friend auto operator<=>(const StarKey&, const StarKey&) = default;
};
[[nodiscard]] inline StarKey star_key(const std::array<std::uint32_t, 3>& labels) {
  const auto [low, high] = std::minmax(labels[0], labels[1]);
  const std::uint32_t middle = std::min(high, std::max(low, labels[2]));
  return {std::uint64_t{std::min(low, labels[2])} << 32 | middle, std::max(high, labels[2])};
}
[[nodiscard]] inline std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

/// A tetrahedron of a star.
struct StarTriangle {
  StarKey key;
  std::array<std::uint32_t, 3> corners;  ///< Labels of the others, turned as it is.
  std::uint32_t slot;
  bool is_second;  ///< It comes of, or goes to, the second end.
};

inline void sort_star(std::span<StarTriangle> star) {
  std::ranges::sort(star, {}, &StarTriangle::key);
}

}  // namespace lode::tetra_mt::midpoint
