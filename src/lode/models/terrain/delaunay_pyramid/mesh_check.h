#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/core/result.h"
#include "lode/models/terrain/delaunay_pyramid/pyramid.h"

namespace lode::delaunay_pyramid {

/// Looks at the meshes of some of a pyramid's levels, one after the other. Corners are vertices of
/// the level, and turn left.
class MeshCheck {
 public:
  /// The pyramid must outlive it.
  explicit MeshCheck(const Pyramid& pyramid) : pyramid_(pyramid) {}

  /// Fails, saying what was expected, where the level's mesh
  /// - has not as many triangles, or not all vertices, that the metadata say;
  /// - has triangles whose largest error is another one;
  /// - does not cover a domain once, edge to edge: see insertions::cover_cells_once() and
  ///   cover_part_once();
  /// - covers another domain than the first one that was looked at;
  /// - or, of a complete pyramid, has other neighbours than are kept.
  /// O(n log n) usually.
  [[nodiscard]] Result<void> check(std::size_t level);

 private:
  using Edge = std::array<std::uint32_t, 2>;

  [[nodiscard]] Result<void> check_counts(std::size_t level, const delaunay::Tin& mesh) const;
  [[nodiscard]] bool covers_once(const delaunay::Tin& mesh) const;
  /// The edges with nothing behind them, in order; those that go straight on at a vertex where no
  /// others end are one.
  [[nodiscard]] std::vector<Edge> outline_of(
      const delaunay::Tin& mesh, const std::vector<std::array<std::uint32_t, 3>>& twins) const;

  const Pyramid& pyramid_;
  std::vector<Edge> outline_;  ///< Of the first mesh.
};

}  // namespace lode::delaunay_pyramid
