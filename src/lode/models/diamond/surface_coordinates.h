#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/box.h"
#include "lode/core/parallel.h"
#include "lode/core/regular_grid.h"
#include "lode/core/surface.h"
#include "lode/models/diamond/cell_pieces.h"

namespace lode::diamond {

/// Where a surface's vertices lie in the lattice, and in which planes it may end.
class SurfaceCoordinates {
 public:
  SurfaceCoordinates(const RegularGrid& grid, const Surface& surface,
                     const std::optional<Box3d>& clip, Threads threads);

  [[nodiscard]] std::size_t size() const { return index_.size(); }
  /// Index coordinates of a vertex, moved onto the lattice's border where rounding put it outside.
  [[nodiscard]] const Vec3d& operator[](std::uint32_t vertex) const { return index_[vertex]; }
  /// Vertex lies outside the lattice or the clip box by more than rounding.
  [[nodiscard]] bool is_outside(std::uint32_t vertex) const {
    return (planes_[vertex] & kOutside) != 0;
  }
  /// The border planes of the lattice that a vertex lies in: bit 2·axis for the lower, the next for
  /// the upper.
  [[nodiscard]] unsigned border_planes(std::uint32_t vertex) const {
    return planes_[vertex] & unsigned{kBorderPlanes};
  }
  /// All these vertices lie in one border plane of the lattice.
  [[nodiscard]] bool are_on_border(std::span<const std::uint32_t> vertices) const {
    return (common_planes(vertices) & kBorderPlanes) != 0;
  }
  /// All these vertices lie in one plane of the clip box.
  [[nodiscard]] bool are_on_clip(std::span<const std::uint32_t> vertices) const {
    return (common_planes(vertices) & kClipPlanes) != 0;
  }
  [[nodiscard]] Piece piece_of(std::span<const std::uint32_t> vertices) const {
    Piece piece;
    for (const std::uint32_t vertex : vertices) piece.add(index_[vertex]);
    return piece;
  }

  /// How far, per axis and in index units, writing a vertex in float32 may have moved it: two
  /// units in the last place of the largest coordinate, and the rounding of to_index.
  [[nodiscard]] const Vec3d& rounding() const { return rounding_; }
  /// The part of it that to_index itself may add, the largest of the axes.
  [[nodiscard]] double check_rounding() const { return check_rounding_; }

 private:
  static constexpr std::uint16_t kBorderPlanes = 0x003f;
  static constexpr std::uint16_t kClipPlanes = 0x0fc0;
  static constexpr std::uint16_t kOutside = 0x8000;

  void find_rounding(const RegularGrid& grid, const Surface& surface);
  void place(const RegularGrid& grid, const Vec3d& world, const std::optional<Box3d>& clip,
             std::uint32_t vertex);
  [[nodiscard]] std::uint16_t common_planes(std::span<const std::uint32_t> vertices) const {
    std::uint16_t planes = 0xffff;
    for (const std::uint32_t vertex : vertices) planes &= planes_[vertex];
    return planes;
  }

  std::vector<Vec3d> index_;
  std::vector<std::uint16_t> planes_;  ///< Two bits an axis: lattice border, then clip box.
  Vec3d rounding_;
  Vec3d world_rounding_;
  double clip_rounding_ = 0;
  double check_rounding_ = 0;
};

}  // namespace lode::diamond
