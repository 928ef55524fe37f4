#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// Which of a surface's normals are zero, a bit each.
class ZeroNormals {
 public:
  ZeroNormals(std::span<const Vec3f> normals, Threads threads);

  [[nodiscard]] bool has(std::uint32_t v) const { return (words_[v / 64] >> v % 64 & 1) != 0; }

  /// visit(v), ascending.
  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (std::size_t word = 0; word < words_.size(); ++word)
      for (std::uint64_t bits = words_[word]; bits != 0; bits &= bits - 1)
        visit(static_cast<std::uint32_t>(64 * word) +
              static_cast<std::uint32_t>(std::countr_zero(bits)));
  }
  /// Triangles with a vertex among them, ascending; none is looked at where there is no such
  /// vertex.
  [[nodiscard]] std::vector<std::uint32_t> triangles_at(const Surface& surface,
                                                        Threads threads) const;

 private:
  std::vector<std::uint64_t> words_;
  bool is_any_ = false;
};

/// Twice a triangle's area, along its normal.
[[nodiscard]] inline Vec3f area_vector(const Surface& surface,
                                       const std::array<std::uint32_t, 3>& t) {
  return cross(surface.positions[t[1]] - surface.positions[t[0]],
               surface.positions[t[2]] - surface.positions[t[0]]);
}

/// Replaces zero normals by the area-weighted mean of the triangles round the vertex.
void fill_zero_normals(Surface& surface, Threads threads);

}  // namespace lode
