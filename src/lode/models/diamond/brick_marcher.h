#pragma once

// Marching the leaves of selections' cuts, brick by brick.

#include <algorithm>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/row_marcher.h"

namespace lode::diamond {

/// Of one isovalue's surface, in one brick.
template <int D>
struct BrickPiece {
  std::size_t isovalue = 0;  ///< Its number.
  StitchPart<D> part;
};

/// Where a brick's piece of the cut is.
template <int D>
struct BrickPlace {
  Index<D> brick;   ///< In the selections' model, whose lattice begins
  Index<D> origin;  ///< here in that of the parts.
  const AxisMap<D>& axes;
};

/// Of one selection: by rows, or simplex by simplex where holes are near and in 2D.
template <int D>
class LeafMarcher {
 public:
  LeafMarcher(const Selection<D>& selection, const LatticeFrame& frame)
      : isovalue_(selection.isovalue()), traversal_(selection), rows_(selection, frame) {}

  void march(const BrickPlace<D>& place, std::span<const Simplex<D>> simplices,
             BrickIsosurface<D>& mapper, TraversalStats& stats, StitchPart<D>& part) {
    traversal_.open(place.brick);
    mapper.open(traversal_.samples(), place.axes, place.origin, isovalue_, part.part);
    if (!march_rows(simplices, mapper, stats))
      for (const Simplex<D>& s : simplices)
        traversal_.visit(s, stats, [&](const BrickSimplex<D>& leaf) { mapper.add(leaf); });
    find_shared<D>(part, OnBrickBorder<D>(place.axes));
  }
  /// Frees the samples of a brick that was traversed: of many isovalues' marchers they would be
  /// many.
  void forget_samples() { traversal_.forget_samples(); }
  [[nodiscard]] RowMarcher& rows() requires(D == 3) { return rows_; }

 private:
  bool march_rows(std::span<const Simplex<D>> simplices, BrickIsosurface<D>& mapper,
                  TraversalStats& stats) {
    if constexpr (D == 3)
      return rows_.march(traversal_.samples(), simplices, mapper, stats);
    else
      return false;
  }

  struct NoRows {
    NoRows(const Selection<D>& /*selection*/, const LatticeFrame& /*frame*/) {}
  };

  double isovalue_;
  BrickTraversal<D> traversal_;
  std::conditional_t<D == 3, RowMarcher, NoRows> rows_;
};

/// Of selections of one field by several isovalues. One per worker.
template <int D>
class BrickMarcher {
 public:
  BrickMarcher(std::span<const Selection<D>> selections, const LatticeFrame& frame)
      : selections_(selections), frame_(frame), marchers_(selections.size()), mapper_(frame) {}

  /// Which cells are to be marched in the style of cubes, by selection; empty: none.
  void set_cubes(std::span<const CubeCells> cubes) { cubes_ = cubes; }
  /// How far at most that has moved a vertex, in world units.
  [[nodiscard]] double farthest_move() const {
    double farthest = 0;
    if constexpr (D == 3)
      for (const auto& marcher : marchers_)
        if (marcher) farthest = std::max(farthest, marcher->rows().farthest_move());
    return farthest;
  }

  /// `simplices`: those of the brick, in the lattice of the selections' model, down to which one of
  /// the cuts is refined; is_wanted(isovalue): whether its surface is to be marched. Adds a piece
  /// for each isovalue that is wanted and crosses the brick, in order.
  template <typename IsWanted>
  void march(const BrickPlace<D>& place, std::span<const Simplex<D>> simplices,
             const IsWanted& is_wanted, TraversalStats& stats, std::vector<BrickPiece<D>>& pieces) {
    for (std::size_t i = 0; i < selections_.size(); ++i) {
      if (!is_wanted(i)) continue;
      auto& marcher = marchers_[i];
      if (!marcher) {
        marcher = std::make_unique<LeafMarcher<D>>(selections_[i], frame_);
        if constexpr (D == 3)
          if (!cubes_.empty()) marcher->rows().set_cubes(&cubes_[i]);
      }
      StitchPart<D> part;
      marcher->march(place, simplices, mapper_, stats, part);
      if (selections_.size() > 1) marcher->forget_samples();
      if (!part.part.cells.empty()) pieces.push_back({i, std::move(part)});
    }
  }

 private:
  std::span<const Selection<D>> selections_;
  LatticeFrame frame_;
  std::vector<std::unique_ptr<LeafMarcher<D>>> marchers_;  ///< By selection.
  BrickIsosurface<D> mapper_;
  std::span<const CubeCells> cubes_;
};

/// Of everything coarser than bricks what one isovalue crosses.
template <int D>
void march_coarse(const CoarseCut<D>& cut, double isovalue, const AxisMap<D>& axes,
                  const LatticeFrame& frame, StitchPart<D>& part) {
  SimplexIsosurface<D> mapper(frame, isovalue, part.part);
  for (const ActiveSimplex<D>& s : cut.leaves) {
    const auto [low, high] = std::ranges::minmax(s.value);
    if (low < isovalue && high >= isovalue) mapper.add(to_lattice<D>(axes, s.vertex, s.value));
  }
  find_shared<D>(part, [](const EdgePoint&) { return true; });
}

}  // namespace lode::diamond
