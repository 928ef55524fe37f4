#pragma once

#include <vector>

#include "lode/mappers/iso_part.h"
#include "lode/mappers/march_simplex.h"
#include "lode/models/diamond/brick_traversal.h"

namespace lode::diamond {

/// Marching simplices inside one brick after another. The doubled middle of an edge is a point of a
/// lattice twice as fine, so an array over that finds each edge's vertex without search; it fits in
/// the cache, and only the entries used are cleared.
template <int D>
class BrickIsosurface {
 public:
  BrickIsosurface(const LatticeFrame& frame, double isovalue)
      : isovalue_(isovalue),
        margin_(frame.margin),
        is_mirrored_(frame.is_mirrored),
        vertices_(power(kEdge, D), kNone) {}

  /// What follows lies in the traversal's open brick and goes to `part`; `origin` is where the
  /// traversal's lattice begins in the part's.
  void open(const BrickTraversal<D>& traversal, const AxisMap<D>& axes, const Index<D>& origin,
            IsoPart<D>& part) {
    for (const std::uint32_t at : used_) vertices_[at] = kNone;
    used_.clear();
    traversal_ = &traversal;
    axes_ = axes;
    origin_ = origin;
    part_ = &part;
  }

  void add(const BrickSimplex<D>& s) {
    std::size_t inside = 0;
    for (std::size_t i = 0; i <= as_size(D); ++i)
      inside |= (s.corner[i].value >= isovalue_ ? std::size_t{1} : 0) << i;
    march_simplex<D>(
        inside, s.is_positive == is_mirrored_,
        [&](std::size_t i, std::size_t j) { return vertex_on(s.corner[i], s.corner[j]); },
        [&](const auto& cell) { part_->cells.push_back(cell); });
  }

 private:
  static constexpr std::size_t kEdge = 2 * as_size(kBrickEdge<D>) + 1;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  std::uint32_t vertex_on(const BrickPoint& a, const BrickPoint& b) {
    std::size_t at = 0;
    for (int i = D - 1; i >= 0; --i)
      at = at * kEdge + as_size(BrickPoint::coordinate(a.packed + b.packed, i));
    std::uint32_t& vertex = vertices_[at];
    if (vertex != kNone) return vertex;
    used_.push_back(static_cast<std::uint32_t>(at));
    vertex = part_->add_point(key_of(a), a.value, key_of(b), b.value, isovalue_, margin_);
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
  const BrickTraversal<D>* traversal_ = nullptr;
  AxisMap<D> axes_;
  Index<D> origin_;
  IsoPart<D>* part_ = nullptr;
};

}  // namespace lode::diamond
