#pragma once

// Marching the leaves of a selection's cut, brick by brick: of one isovalue, or of many, whose
// surfaces all lie in the leaves of one cut (see ManySelection).

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "lode/models/diamond/brick_isosurface.h"
#include "lode/models/diamond/brick_work.h"
#include "lode/models/diamond/isovalue_list.h"

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
  Index<D> brick;   ///< In the selection's model, whose lattice begins
  Index<D> origin;  ///< here in that of the parts.
  const AxisMap<D>& axes;
  /// By isovalue: whether its surface is to be marched.
  std::span<const std::uint8_t> is_wanted;
};

/// Marches leaves as they are found. One per worker.
template <int D>
class OneMarcher {
 public:
  template <typename Field>
  using Selected = Selection<D, Field>;

  template <typename Field>
  static Selected<Field> select(const Field& field, const IsovalueList& isovalues,
                                double tolerance) {
    LODE_EXPECTS(isovalues.size() == 1);
    return Selected<Field>(field, isovalues[0], tolerance);
  }

  OneMarcher(const Selection<D>& selection, const IsovalueList& /*isovalues*/,
             const LatticeFrame& frame)
      : traversal_(selection), mapper_(frame, selection.isovalue()) {}

  /// for_each_simplex(visit): those of the brick, in the lattice of the selection's model.
  template <typename ForEachSimplex>
  void march(const BrickPlace<D>& place, const ForEachSimplex& for_each_simplex,
             TraversalStats& stats, std::vector<BrickPiece<D>>& pieces) {
    StitchPart<D>& part = pieces.emplace_back().part;
    traversal_.open(place.brick);
    mapper_.open(traversal_, place.axes, place.origin, part.part);
    for_each_simplex([&](const Simplex<D>& s) {
      traversal_.visit(s, stats, [&](const BrickSimplex<D>& leaf) { mapper_.add(leaf); });
    });
    find_shared<D>(part, [&](const EdgePoint& p) { return is_on_brick_border<D>(place.axes, p); });
  }

 private:
  BrickTraversal<D> traversal_;
  BrickIsosurface<D> mapper_;
};

/// Which isovalues cross which leaves of a brick: numbers of leaves, by isovalue.
class Crossings {
 public:
  void clear() {
    low_.clear();
    high_.clear();
  }
  /// The next leaf is crossed by the isovalues number low .. high - 1.
  void add(std::size_t low, std::size_t high) {
    low_.push_back(static_cast<std::uint32_t>(low));
    high_.push_back(static_cast<std::uint32_t>(high));
  }
  /// Calls visit(isovalue, numbers of its leaves in order) for each that has any.
  template <typename Visit>
  void for_each(std::size_t n_isovalues, const Visit& visit) {
    first_.assign(n_isovalues + 1, 0);
    for (std::size_t leaf = 0; leaf < low_.size(); ++leaf)
      for (std::size_t i = low_[leaf]; i < high_[leaf]; ++i) ++first_[i + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    leaves_.resize(first_.back());
    next_.assign(first_.begin(), first_.end() - 1);
    for (std::size_t leaf = 0; leaf < low_.size(); ++leaf)
      for (std::size_t i = low_[leaf]; i < high_[leaf]; ++i)
        leaves_[next_[i]++] = static_cast<std::uint32_t>(leaf);
    for (std::size_t i = 0; i < n_isovalues; ++i)
      if (first_[i] < first_[i + 1])
        visit(i, std::span(leaves_).subspan(first_[i], first_[i + 1] - first_[i]));
  }

 private:
  std::vector<std::uint32_t> low_, high_;  ///< By leaf.
  std::vector<std::size_t> first_, next_;  ///< By isovalue.
  std::vector<std::uint32_t> leaves_;
};

/// Lists a brick's leaves, then marches each isovalue's. One per worker.
template <int D>
class ManyMarcher {
 public:
  template <typename Field>
  using Selected = ManySelection<D, Field>;

  template <typename Field>
  static Selected<Field> select(const Field& field, const IsovalueList& isovalues,
                                double tolerance) {
    return Selected<Field>(field, isovalues, tolerance);
  }

  ManyMarcher(const ManySelection<D>& selection, const IsovalueList& isovalues,
              const LatticeFrame& frame)
      : selection_(selection), isovalues_(isovalues), traversal_(selection), mapper_(frame, 0) {}

  /// As OneMarcher's; a piece for each isovalue that crosses the brick, ascending.
  template <typename ForEachSimplex>
  void march(const BrickPlace<D>& place, const ForEachSimplex& for_each_simplex,
             TraversalStats& stats, std::vector<BrickPiece<D>>& pieces) {
    leaves_.clear();
    crossings_.clear();
    traversal_.open(place.brick);
    for_each_simplex([&](const Simplex<D>& s) {
      traversal_.visit(s, stats, [&](const BrickSimplex<D>& leaf) { add(leaf); });
    });
    crossings_.for_each(
        isovalues_.size(), [&](std::size_t isovalue, std::span<const std::uint32_t> leaves) {
          if (place.is_wanted[isovalue] == 0) return;
          StitchPart<D>& part = pieces.emplace_back(BrickPiece<D>{isovalue, {}}).part;
          mapper_.set_isovalue(isovalues_[isovalue]);
          mapper_.open(traversal_, place.axes, place.origin, part.part);
          for (const std::uint32_t leaf : leaves) mapper_.add(leaves_[leaf]);
          find_shared<D>(part,
                         [&](const EdgePoint& p) { return is_on_brick_border<D>(place.axes, p); });
        });
  }

 private:
  void add(const BrickSimplex<D>& leaf) {
    std::size_t low = isovalues_.size();
    std::size_t high = 0;
    for (const BrickPoint& corner : leaf.corner) {
      const std::size_t rank = selection_.side(corner.value);
      low = std::min(low, rank);
      high = std::max(high, rank);
    }
    leaves_.push_back(leaf);
    crossings_.add(low, high);
  }

  const ManySelection<D>& selection_;
  const IsovalueList& isovalues_;
  BrickTraversal<D, ManySelection<D>> traversal_;
  BrickIsosurface<D, ManySelection<D>> mapper_;
  std::vector<BrickSimplex<D>> leaves_;  ///< Of a brick.
  Crossings crossings_;
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
