#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/core/vec.h"
#include "lode/models/tetra_mt/closed_mesh.h"

namespace lode::tetra_mt {

/// Points in boxes of about equal numbers.
struct SpaceBlocks {
  std::vector<std::uint32_t> points;  ///< Block by block.
  std::vector<std::size_t> begins;    ///< Of blocks, and of what would be the next.

  [[nodiscard]] std::size_t size() const { return begins.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t block) const {
    return std::span(points).subspan(begins[block], begins[block + 1] - begins[block]);
  }
};

/// Vertices of a mesh in boxes, and what of the mesh belongs to each.
struct MeshBlocks {
  SpaceBlocks vertices;
  std::vector<std::uint32_t> block_of;  ///< By vertex; kNone of those that are in none.
  std::vector<std::vector<std::uint32_t>>
      slots;  ///< By block: tetrahedra with one of its vertices.

  [[nodiscard]] std::size_t size() const { return vertices.size(); }
};

/// Halves what is larger than `max_size` along its longest side, again and again. `share`, between
/// 0 and 1: how much of it lies below the planes of the first three times, whose place decides on
/// all others'. A block's points are ascending.
[[nodiscard]] SpaceBlocks cut_in_blocks(std::span<const Vec3d> positions,
                                        std::vector<std::uint32_t> points, std::size_t max_size,
                                        double share, Threads threads);

/// Those of `vertices`, whatever else a tetrahedron has; of tetrahedra those that are not gone.
[[nodiscard]] MeshBlocks cut_mesh(std::span<const Vec3d> positions,
                                  std::vector<std::uint32_t> vertices,
                                  std::span<const Tetrahedron> tetrahedra, std::size_t max_size,
                                  double share, Threads threads);

}  // namespace lode::tetra_mt
