#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/mappers/collapse_mesh.h"

namespace lode::simplification {

/// A collapsed surface with the star of each vertex, from which collapses can be taken back one by
/// one: what is left is what the remaining ones make of the original.
class CollapseUndo {
 public:
  /// `near`: points stay attached where they are if they are no farther away than this.
  CollapseUndo(CollapseMesh& mesh, std::span<const Vec3f> original, float near);

  /// Takes `collapse` back, and before it all later ones at vertices of its star. Adds the
  /// triangles that come or change to `changed`, some more than once, and returns how many
  /// collapses it took.
  std::uint32_t undo(std::uint32_t collapse, std::vector<std::uint32_t>& changed);

  /// The last collapse that made a triangle what it is; kNone of an original one.
  [[nodiscard]] std::uint32_t maker(std::uint32_t triangle) const;

  /// Calls visit(triangle) for those round a vertex.
  template <typename Visit>
  void for_each_around(std::uint32_t v, const Visit& visit) const {
    for (std::uint32_t c = first_[v]; c != kNone; c = next_[c]) visit(c >> 2);
  }

 private:
  void undo_one(const Collapse& collapse, std::vector<std::uint32_t>& changed);
  [[nodiscard]] std::uint32_t find_later(std::uint32_t collapse) const;
  void move_fan(const Collapse& collapse);
  [[nodiscard]] std::uint32_t find_spoke(std::uint32_t v, std::uint32_t k, std::uint32_t end) const;
  void move_corner(std::uint32_t triangle, std::uint32_t from, std::uint32_t to);
  void link(std::uint32_t v, std::uint32_t corner);
  void attach(std::uint32_t point, std::span<const std::uint32_t> triangles);

  CollapseMesh& mesh_;
  std::span<const Vec3f> original_;
  float near_;
  UninitializedArray<std::uint32_t> first_;  ///< By vertex: the first of its corners.
  UninitializedArray<std::uint32_t> next_;   ///< By corner: 4 * triangle + k.
  std::vector<std::uint32_t> pending_;
};

}  // namespace lode::simplification
