#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "lode/mappers/lattice_key.h"
#include "lode/models/diamond/brick_traversal.h"
#include "lode/models/diamond/isovalue_list.h"

namespace lode::diamond {

/// An edge of a cut that parts may share, with the ranks of its ends: of edges with one key, one
/// counts.
struct SharedEdge {
  LatticeKey key;  ///< Of the doubled middle; with kTwin of the second arc of a pinched edge.
  std::uint32_t low;
  std::uint32_t high;
};

/// Adds each key's edge once.
inline void add_shared_edges(std::vector<SharedEdge>& edges, CrossingSums& sums) {
  const auto by_key = [](const SharedEdge& a, const SharedEdge& b) { return a.key < b.key; };
  std::sort(edges.begin(), edges.end(), by_key);
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (i == 0 || edges[i].key != edges[i - 1].key) sums.add_edge(edges[i].low, edges[i].high);
}

/// Counts what many isovalues' surfaces have in leaf simplices, inside one brick after another.
/// Edges on a brick's border belong to the brick beyond it in the direction of lower coordinates;
/// those between corners of bricks, which coarser simplices may have too, go to a list, and so do
/// all on borders where there are holes, as these may take the other brick's simplices away.
template <int D>
class LeafCounter {
 public:
  using Traversal = BrickTraversal<D, ManySelection<D>>;

  LeafCounter(const ManySelection<D>& selection, std::size_t n_isovalues)
      : selection_(selection),
        has_holes_(selection.model().has_holes()),
        is_seen_(power(kEdge, D)),
        sums_(n_isovalues) {}

  /// What follows lies in the traversal's open brick.
  void open(const Traversal& traversal, const Index<D>& brick) {
    for (const std::uint32_t at : seen_) is_seen_[at] = false;
    seen_.clear();
    traversal_ = &traversal;
    for (std::size_t i = 0; i < as_size(D); ++i) is_first_[i] = brick[i] == 0;
  }

  void add(const BrickSimplex<D>& s) {
    std::array<std::size_t, as_size(D) + 1> rank;
    for (std::size_t i = 0; i < rank.size(); ++i) rank[i] = selection_.side(s.corner[i].value);
    for (std::size_t i = 0; i < rank.size(); ++i)
      for (std::size_t j = i + 1; j < rank.size(); ++j)
        if (rank[i] != rank[j])
          add_edge(s, i, j, std::min(rank[i], rank[j]), std::max(rank[i], rank[j]));
    std::sort(rank.begin(), rank.end());
    sums_.add_simplex(rank);
  }

  [[nodiscard]] const CrossingSums& sums() const { return sums_; }
  [[nodiscard]] const std::vector<SharedEdge>& shared() const { return shared_; }

 private:
  static constexpr std::size_t kEdge = 2 * as_size(kBrickEdge<D>) + 1;

  void add_edge(const BrickSimplex<D>& s, std::size_t i, std::size_t j, std::size_t low,
                std::size_t high) {
    const BrickPoint& a = s.corner[i];
    const BrickPoint& b = s.corner[j];
    const std::uint32_t doubled = a.packed + b.packed;
    std::size_t at = 0;
    for (int axis = D - 1; axis >= 0; --axis)
      at = at * kEdge + as_size(BrickPoint::coordinate(doubled, axis));
    if (is_seen_[at]) return;
    if (traversal_->samples().is_pinched(a, b)) {
      share(a, b, low, high, is_second(s, i, j) ? kTwin : 0);
      return;  // each arc comes with simplices of its own
    }
    is_seen_[at] = true;
    seen_.push_back(static_cast<std::uint32_t>(at));
    const Place place = place_of(a, b);
    if (place.is_corners || (has_holes_ && place.is_border))
      share(a, b, low, high, 0);
    else if (!place.is_below)
      sums_.add_edge(low, high);
  }

  struct Place {
    bool is_border = false;  ///< On a face of the brick,
    bool is_below = false;   ///< one that another brick has too, at lower coordinates;
    bool is_corners = true;  ///< or between two of its corners.
  };
  [[nodiscard]] Place place_of(const BrickPoint& a, const BrickPoint& b) const {
    Place place;
    for (int axis = 0; axis < D; ++axis) {
      const std::int32_t x = BrickPoint::coordinate(a.packed, axis);
      const std::int32_t y = BrickPoint::coordinate(b.packed, axis);
      place.is_corners = place.is_corners && x % kBrickEdge<D> == 0 && y % kBrickEdge<D> == 0;
      if (x != y || x % kBrickEdge<D> != 0) continue;
      place.is_border = true;
      place.is_below = place.is_below || (x == 0 && !is_first_[as_size(axis)]);
    }
    return place;
  }

  void share(const BrickPoint& a, const BrickPoint& b, std::size_t low, std::size_t high,
             LatticeKey twin) {
    const AxisMap<D>& axes = selection_.model().axes;
    const LatticeKey key = to_key(axes.to_grid(traversal_->samples().global(a.packed))) +
                           to_key(axes.to_grid(traversal_->samples().global(b.packed)));
    shared_.push_back(
        {key | twin, static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(high)});
  }

  /// Of the arcs round a pinched edge the one that a simplex lies in.
  [[nodiscard]] bool is_second(const BrickSimplex<D>& s, std::size_t i, std::size_t j) const {
    if constexpr (D == 3) {
      std::array<Index<3>, 4> corners;
      for (std::size_t c = 0; c < corners.size(); ++c)
        corners[c] = traversal_->samples().global(s.corner[c].packed);
      return is_in_second_arc(corners, corners[i], corners[j]);
    }
    return false;
  }

  const ManySelection<D>& selection_;
  bool has_holes_;
  std::vector<std::uint8_t> is_seen_;  ///< By doubled edge middle.
  std::vector<std::uint32_t> seen_;    ///< Those that are.
  std::array<bool, as_size(D)> is_first_{};
  const Traversal* traversal_ = nullptr;
  CrossingSums sums_;
  std::vector<SharedEdge> shared_;
};

}  // namespace lode::diamond
