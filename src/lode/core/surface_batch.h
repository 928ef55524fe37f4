#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/core/surface.h"

namespace lode {

/// A change of a surface whose vertices and cells lie in numbered slots, as graphics memory holds
/// them: the slots that change, and what they hold from then on. Lines of 2D data repeat their
/// second vertex.
struct SurfaceBatch {
  using Cell = std::array<std::uint32_t, 3>;
  /// What an unused slot holds; draws nothing.
  static constexpr Cell kRemoved{0, 0, 0};

  Vec3d origin;              ///< World position = origin + position.
  bool starts_over = false;  ///< All slots are unused before it.
  std::uint32_t n_vertex_slots = 0;
  std::uint32_t n_cell_slots = 0;
  std::vector<std::uint32_t> vertices;  ///< Slots of added vertices,
  std::vector<Vec3f> positions;         ///< where they are,
  std::vector<Vec3f> normals;           ///< and their normals, if asked for.
  std::vector<std::uint32_t> removed_vertices;
  std::vector<std::uint32_t> cells;  ///< Slots of cells that were added, removed or replaced,
  std::vector<Cell> corners;         ///< and what they hold now.
};

/// The surface that batches add up to, applied in the order in which they were taken.
class SurfaceMirror {
 public:
  void apply(const SurfaceBatch& batch);
  void clear() { *this = {}; }
  [[nodiscard]] std::size_t n_cells() const { return n_cells_; }
  [[nodiscard]] const std::vector<Vec3f>& positions() const { return positions_; }
  [[nodiscard]] const std::vector<SurfaceBatch::Cell>& cells() const { return cells_; }
  /// Without unused slots; cells and vertices in the order of their slots.
  [[nodiscard]] Surface to_surface() const;

 private:
  Vec3d origin_;
  std::vector<Vec3f> positions_;
  std::vector<Vec3f> normals_;
  std::vector<SurfaceBatch::Cell> cells_;
  std::size_t n_cells_ = 0;
};

}  // namespace lode
