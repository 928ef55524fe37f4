#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "lode/mappers/iso_part.h"
#include "lode/models/diamond/brick_samples.h"

namespace lode::diamond {

/// The vertices on edges inside one brick after another. The doubled middle of an edge is a point
/// of a lattice twice as fine, so an array over that finds each edge's vertex without search; it
/// fits in the cache, and only the entries used are cleared.
template <int D>
class BrickVertices {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::size_t kEdge = 2 * as_size(kBrickEdge<D>) + 1;

  explicit BrickVertices(double margin) : margin_(margin), vertices_(power(kEdge, D), kNone) {}

  /// `base`: the brick's lowest corner, in the lattice of the parts.
  void open(const Index<D>& base, const AxisMap<D>& axes, double isovalue, IsoPart<D>& part) {
    for (const std::uint32_t at : used_) vertices_[at] = kNone;
    used_.clear();
    isovalue_ = isovalue;
    part_ = &part;
    base_key_ = to_key(axes.to_grid(base));
    for (std::size_t i = 0; i < as_size(D); ++i)
      key_steps_[i] = LatticeKey{1} << (kKeyBits * axes.axis[i]);
  }

  /// Where the entry of an edge is, by the sum of its ends.
  [[nodiscard]] static std::size_t place(std::uint32_t doubled) {
    std::size_t at = 0;
    for (int axis = D - 1; axis >= 0; --axis)
      at = at * kEdge + as_size(BrickPoint::coordinate(doubled, axis));
    return at;
  }
  /// The same by the coordinates of the sum. Linear: places of two points add up to their edge's.
  [[nodiscard]] static constexpr std::size_t place(const Index<D>& doubled) {
    std::size_t at = 0;
    for (std::size_t i = as_size(D); i-- > 0;) at = at * kEdge + as_size(doubled[i]);
    return at;
  }
  [[nodiscard]] std::uint32_t operator[](std::size_t place) const { return vertices_[place]; }
  /// Of an entry that is kNone.
  void set(std::size_t place, std::uint32_t vertex) {
    used_.push_back(static_cast<std::uint32_t>(place));
    vertices_[place] = vertex;
  }

  std::uint32_t add(const BrickPoint& a, const BrickPoint& b, LatticeKey twin = 0) {
    return part_->add_point(key_of(a.packed), a.value, key_of(b.packed), b.value, isovalue_,
                            margin_, twin);
  }
  /// The same where the first end is known to have the smaller key.
  std::uint32_t add(LatticeKey first, double a, LatticeKey second, double b) {
    return part_->add_point({first, second, (isovalue_ - a) / (b - a)}, b - a, margin_);
  }

  [[nodiscard]] LatticeKey key_of(std::uint32_t packed) const {
    LatticeKey key = base_key_;
    for (int i = 0; i < D; ++i)
      key += as_size(BrickPoint::coordinate(packed, i)) * key_steps_[as_size(i)];
    return key;
  }
  [[nodiscard]] const std::array<LatticeKey, as_size(D)>& key_steps() const { return key_steps_; }
  [[nodiscard]] double isovalue() const { return isovalue_; }
  [[nodiscard]] IsoPart<D>& part() { return *part_; }

 private:
  double margin_;
  double isovalue_ = 0;
  std::vector<std::uint32_t> vertices_;  ///< By doubled edge middle.
  std::vector<std::uint32_t> used_;      ///< Their entries that are not kNone.
  IsoPart<D>* part_ = nullptr;
  LatticeKey base_key_ = 0;
  std::array<LatticeKey, as_size(D)> key_steps_{};
};

}  // namespace lode::diamond
