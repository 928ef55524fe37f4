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
  /// Bit i: whether the point at `first` + i along the first axis is in the set; n <= 64 of them.
  [[nodiscard]] std::uint64_t row(const Index<D>& first, std::int32_t n) const {
    for (std::size_t i = 1; i < static_cast<std::size_t>(D); ++i)
      if (first[i] >= shape_.dims[i]) return 0;
    n = std::min(n, shape_.dims[0] - first[0]);
    if (n <= 0) return 0;
    const std::size_t at = linear_index<D>(shape_.dims, first);
    std::uint64_t bits = bits_[at / 64] >> (at % 64);
    if (at % 64 != 0 && at / 64 + 1 < bits_.size()) bits |= bits_[at / 64 + 1] << (64 - at % 64);
    return n == 64 ? bits : bits & ((std::uint64_t{1} << n) - 1);
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
