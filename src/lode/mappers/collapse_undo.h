#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/surface.h"
#include "lode/mappers/collapse_mesh.h"
#include "lode/mappers/surface_band.h"

namespace lode::simplification {

/// Which collapses go before one is taken back.
enum class UndoOrder {
  splits,  ///< Those without which the vertex cannot be split: few.
  stars    ///< All later ones at vertices of the star: where only this is asked for, from the first
           ///< one taken back on, each star is then the one that its collapse left.
};

/// A collapsed surface with the star of each vertex, from which collapses can be taken back one by
/// one: what is left is what the remaining ones make of the original. Each vertex stands for the
/// original ones that went into it, and triangles for the original ones whose corners have gone
/// into three vertices.
class CollapseUndo {
 public:
  /// `live`: triangles that are there, ascending. `band`: of the mesh's positions, if no sample
  /// outside it may change sides; or null. `near`: points stay attached where they are if they are
  /// no farther away than this.
  CollapseUndo(CollapseMesh& mesh, const Surface& original, std::span<const std::uint32_t> live,
               UndoOrder order, const SurfaceBand* band, float near);

  /// Takes `collapse` back, and before it those that the order asks for. Adds the triangles that
  /// come or change to `changed`, some more than once, and returns how many collapses it took.
  std::uint32_t undo(std::uint32_t collapse, std::vector<std::uint32_t>& changed);

  /// A sample outside the band may be in what a split would sweep, whatever else was taken back at
  /// its star, and it was not made. Not in the order of stars, where what each collapse swept is
  /// swept back.
  [[nodiscard]] bool is_stuck() const { return is_stuck_; }

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
  [[nodiscard]] std::uint32_t find_later_in_star(std::uint32_t collapse) const;
  [[nodiscard]] std::uint32_t apex_of(std::uint32_t dead, std::uint32_t kept) const;
  [[nodiscard]] bool may_sweep_back(std::uint32_t collapse) const;
  [[nodiscard]] bool is_of_removed(std::uint32_t vertex, std::uint32_t collapse) const;
  [[nodiscard]] Vec3d in_band(const Vec3f& position) const;
  void bring_back(std::uint32_t triangle);
  void split(const Collapse& collapse);
  void link(std::uint32_t v, std::uint32_t corner);
  void attach(std::uint32_t point, std::span<const std::uint32_t> triangles);

  CollapseMesh& mesh_;
  const Surface& original_;
  UndoOrder order_;
  const SurfaceBand* band_;
  float near_;
  UninitializedArray<std::uint32_t> first_;  ///< By vertex: the first of its corners.
  UninitializedArray<std::uint32_t> next_;   ///< By corner: 4 * triangle + k.
  std::vector<std::uint32_t> pending_;
  bool is_stuck_ = false;
};

}  // namespace lode::simplification
