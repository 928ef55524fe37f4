#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace lode {

/// Sets of the numbers from 0 on that are joined, each named by its smallest (R. E. Tarjan,
/// "Efficiency of a good but not linear set union algorithm", Journal of the ACM 22 (2), 1975).
template <std::unsigned_integral Number = std::uint32_t>
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) {
    std::iota(parent_.begin(), parent_.end(), Number{0});
  }

  [[nodiscard]] Number find(Number i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(Number a, Number b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Number> parent_;
};

}  // namespace lode
