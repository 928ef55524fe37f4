#pragma once

#include <array>
#include <unordered_map>
#include <vector>

#include "lode/mappers/iso_part.h"
#include "lode/mappers/march_simplex.h"
#include "lode/models/diamond/brick_traversal.h"

namespace lode::diamond {

/// Marching simplices, leaves of a selection's cut, inside one brick after another. The doubled
/// middle of an edge is a point of a lattice twice as fine, so an array over that finds each edge's
/// vertex without search; it fits in the cache, and only the entries used are cleared.
template <int D, typename Selected = Selection<D>>
class BrickIsosurface {
 public:
  BrickIsosurface(const LatticeFrame& frame, double isovalue)
      : isovalue_(isovalue),
        margin_(frame.margin),
        is_mirrored_(frame.is_mirrored),
        vertices_(power(kEdge, D), kNone) {}

  /// What follows lies in the traversal's open brick and goes to `part`; `origin` is where the
  /// traversal's lattice begins in the part's.
  void open(const BrickTraversal<D, Selected>& traversal, const AxisMap<D>& axes,
            const Index<D>& origin, IsoPart<D>& part) {
    for (const std::uint32_t at : used_) vertices_[at] = kNone;
    used_.clear();
    twins_.clear();
    traversal_ = &traversal;
    axes_ = axes;
    origin_ = origin;
    part_ = &part;
  }

  /// Of what is opened next.
  void set_isovalue(double isovalue) { isovalue_ = isovalue; }

  void add(const BrickSimplex<D>& s) {
    std::size_t inside = 0;
    for (std::size_t i = 0; i <= as_size(D); ++i)
      inside |= (s.corner[i].value >= isovalue_ ? std::size_t{1} : 0) << i;
    march_simplex<D>(
        inside, s.is_positive == is_mirrored_,
        [&](std::size_t i, std::size_t j) { return vertex_on(s, i, j); },
        [&](const auto& cell) { part_->cells.push_back(cell); });
  }

 private:
  static constexpr std::size_t kEdge = 2 * as_size(kBrickEdge<D>) + 1;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kTwoThere = kNone - 1;  ///< See twins_.

  std::uint32_t vertex_on(const BrickSimplex<D>& s, std::size_t i, std::size_t j) {
    const BrickPoint& a = s.corner[i];
    const BrickPoint& b = s.corner[j];
    std::size_t at = 0;
    for (int axis = D - 1; axis >= 0; --axis)
      at = at * kEdge + as_size(BrickPoint::coordinate(a.packed + b.packed, axis));
    std::uint32_t& vertex = vertices_[at];
    if (vertex < kTwoThere) return vertex;
    if (vertex == kNone) {
      used_.push_back(static_cast<std::uint32_t>(at));
      if (!traversal_->is_pinched(a, b)) {
        vertex = part_->add_point(key_of(a), a.value, key_of(b), b.value, isovalue_, margin_);
        return vertex;
      }
      vertex = kTwoThere;
      twins_[static_cast<std::uint32_t>(at)] = {kNone, kNone};
    }
    return twin_on(s, i, j, twins_[static_cast<std::uint32_t>(at)]);
  }

  /// Of the two vertices of a pinched edge that of the simplex's arc.
  std::uint32_t twin_on(const BrickSimplex<D>& s, std::size_t i, std::size_t j,
                        std::array<std::uint32_t, 2>& twins) {
    bool is_second = false;
    if constexpr (D == 3) {
      std::array<Index<3>, 4> corners;
      for (std::size_t c = 0; c < corners.size(); ++c)
        corners[c] = traversal_->global(s.corner[c].packed);
      is_second = is_in_second_arc(corners, corners[i], corners[j]);
    }
    std::uint32_t& vertex = twins[is_second ? 1 : 0];
    if (vertex == kNone)
      vertex = part_->add_point(key_of(s.corner[i]), s.corner[i].value, key_of(s.corner[j]),
                                s.corner[j].value, isovalue_, margin_, is_second ? kTwin : 0);
    return vertex;
  }

  [[nodiscard]] LatticeKey key_of(const BrickPoint& p) const {
    return to_key(axes_.to_grid(traversal_->global(p.packed) + origin_));
  }

  double isovalue_;
  double margin_;
  bool is_mirrored_;
  std::vector<std::uint32_t> vertices_;  ///< By doubled edge middle.
  std::vector<std::uint32_t> used_;      ///< Their entries that are not kNone.
  /// By the same, where the entry is kTwoThere: one for each arc of simplices round the edge.
  std::unordered_map<std::uint32_t, std::array<std::uint32_t, 2>> twins_;
  const BrickTraversal<D, Selected>* traversal_ = nullptr;
  AxisMap<D> axes_;
  Index<D> origin_;
  IsoPart<D>* part_ = nullptr;
};

}  // namespace lode::diamond
