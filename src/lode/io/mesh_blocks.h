#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "lode/core/mesh.h"

namespace lode::io {

/// The cells of one region, as formats have them that keep cells in blocks.
struct MeshBlock {
  std::int32_t tag = 1;  ///< Positive, and different from other blocks'.
  /// The region's, or "region -2", and different from other blocks'; empty where the mesh has none.
  std::string name;
  std::span<const std::uint32_t> cells;  ///< Ascending.
};

/// A mesh's cells by region, ascending.
class MeshBlocks {
 public:
  explicit MeshBlocks(const SimplexMesh& mesh);
  MeshBlocks(const MeshBlocks&) = delete;
  MeshBlocks& operator=(const MeshBlocks&) = delete;

  [[nodiscard]] std::span<const MeshBlock> blocks() const { return blocks_; }
  /// All of them, block by block.
  [[nodiscard]] std::span<const std::uint32_t> cells() const { return cells_; }
  /// Whether tags are the regions' numbers: these are positive and fit. Else they go from 1 on.
  [[nodiscard]] bool has_region_tags() const { return has_region_tags_; }

 private:
  std::vector<std::uint32_t> cells_;  ///< Block by block.
  std::vector<MeshBlock> blocks_;
  bool has_region_tags_ = false;
};

/// The corners of a mesh's cells, all of one kind: 4 for tetrahedra, 3 for triangles.
[[nodiscard]] inline std::span<const std::uint32_t> simplex_corners(const SimplexMesh& mesh,
                                                                    std::size_t cell) {
  if (mesh.triangles.empty()) return mesh.tetrahedra[cell];
  return mesh.triangles[cell];
}

[[nodiscard]] inline std::size_t n_simplex_corners(const SimplexMesh& mesh) {
  return mesh.triangles.empty() ? 4 : 3;
}

/// Of an attribute's errors in files.
[[nodiscard]] inline std::string error_name(const Attribute& attribute) {
  return "error_" + attribute.name;
}

/// Whether attributes have a value for each vertex, and an error for each cell or none at all.
[[nodiscard]] bool has_whole_attributes(const SimplexMesh& mesh);

/// Copies a number to `out`, most significant byte first, and moves `out` past it.
template <typename T>
inline void put_big(std::byte*& out, T value) {
  std::memcpy(out, &value, sizeof(T));
  for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(out[i], out[sizeof(T) - 1 - i]);
  out += sizeof(T);
}

}  // namespace lode::io
