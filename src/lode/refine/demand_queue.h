#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "lode/refine/cut.h"

namespace lode {

/// The order of refinement: larger demands first, ties by smaller id.
struct Ranked {
  NodeId id{};
  float demand = 0;
  Cut::Place place = 0;

  [[nodiscard]] bool comes_before(const Ranked& other) const {
    return demand != other.demand ? demand > other.demand : id < other.id;
  }
};

/// A priority queue of nodes of a cut whose entries may have become stale: the reader asks the cut.
/// From the first in the order of refinement, or (IsReversed) from the last.
template <bool IsReversed>
class DemandQueue {
 public:
  [[nodiscard]] bool is_empty() const { return heap_.empty(); }
  [[nodiscard]] std::size_t size() const { return heap_.size(); }
  [[nodiscard]] const Ranked& top() const { return heap_.front(); }
  void clear() { heap_.clear(); }
  void push(const Ranked& entry) {
    heap_.push_back(entry);
    std::size_t i = heap_.size() - 1;
    for (; i > 0 && comes_first(entry, heap_[(i - 1) / kWays]); i = (i - 1) / kWays)
      heap_[i] = heap_[(i - 1) / kWays];
    heap_[i] = entry;
  }
  void pop() {
    const Ranked last = heap_.back();
    heap_.pop_back();
    if (heap_.empty()) return;
    std::size_t i = 0;
    for (std::size_t child = 1; child < heap_.size(); child = kWays * i + 1) {
      const std::size_t end = std::min(child + kWays, heap_.size());
      std::size_t best = child;
      for (std::size_t k = child + 1; k < end; ++k)
        if (comes_first(heap_[k], heap_[best])) best = k;
      if (!comes_first(heap_[best], last)) break;
      heap_[i] = heap_[best];
      i = best;
    }
    heap_[i] = last;
  }
  template <typename IsValid>
  void keep_if(const IsValid& is_valid) {
    std::erase_if(heap_, [&](const Ranked& entry) { return !is_valid(entry); });
    std::sort(heap_.begin(), heap_.end(),
              [](const Ranked& a, const Ranked& b) { return comes_first(a, b); });  // a heap, too
    heap_.erase(std::unique(heap_.begin(), heap_.end(),
                            [](const Ranked& a, const Ranked& b) { return a.id == b.id; }),
                heap_.end());
  }
  [[nodiscard]] std::size_t n_bytes() const { return heap_.capacity() * sizeof(Ranked); }

 private:
  static constexpr std::size_t kWays = 4;  ///< Siblings share a cache line; half the levels of 2.

  static bool comes_first(const Ranked& a, const Ranked& b) {
    return IsReversed ? b.comes_before(a) : a.comes_before(b);
  }

  std::vector<Ranked> heap_;
};

}  // namespace lode
