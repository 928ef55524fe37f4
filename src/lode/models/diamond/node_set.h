#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Nodes that are to be refined whatever their error, by a bit for each sample, and with each all
/// that must come before it. Nodes with centres beyond the data need no mention: they reach across
/// its border (Shape::reaches_across), and so do those that come before them.
template <int D>
class NodeSet {
 public:
  explicit NodeSet(const Shape<D>& shape)
      : shape_(shape), bits_((n_points<D>(shape.dims) + 63) / 64) {}

  [[nodiscard]] bool contains(const Index<D>& centre) const {
    if (!shape_.is_sample(centre)) return false;
    const std::size_t at = linear_index<D>(shape_.dims, centre);
    return ((bits_[at / 64] >> (at % 64)) & 1U) != 0;
  }
  /// With its ancestors, in which on_new(centre) is called for each that was not there.
  template <typename OnNew>
  void insert(const Index<D>& centre, const OnNew& on_new) {
    std::vector<Index<D>> waiting{centre};
    while (!waiting.empty()) {
      const Index<D> p = waiting.back();
      waiting.pop_back();
      if (!shape_.is_sample(p) || common_exponent<D>(p) >= shape_.n_levels) continue;
      if (!set(p)) continue;
      on_new(p);
      for (const Index<D>& parent : parents<D>(diamond_at<D>(p), shape_.root_side()))
        waiting.push_back(parent);
    }
  }
  void clear() { std::fill(bits_.begin(), bits_.end(), 0); }

  /// Alone; false if it was there. `centre` is a sample.
  bool set(const Index<D>& centre) {
    const std::size_t at = linear_index<D>(shape_.dims, centre);
    const std::uint64_t bit = std::uint64_t{1} << (at % 64);
    if ((bits_[at / 64] & bit) != 0) return false;
    bits_[at / 64] |= bit;
    return true;
  }

 private:
  Shape<D> shape_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace lode::diamond
