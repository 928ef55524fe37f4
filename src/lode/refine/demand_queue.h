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
    std::push_heap(heap_.begin(), heap_.end(), comes_later);
  }
  void pop() {
    std::pop_heap(heap_.begin(), heap_.end(), comes_later);
    heap_.pop_back();
  }
  template <typename IsValid>
  void keep_if(const IsValid& is_valid) {
    std::erase_if(heap_, [&](const Ranked& entry) { return !is_valid(entry); });
    std::sort(heap_.begin(), heap_.end(),
              [](const Ranked& a, const Ranked& b) { return comes_later(b, a); });  // a heap, too
    heap_.erase(std::unique(heap_.begin(), heap_.end(),
                            [](const Ranked& a, const Ranked& b) { return a.id == b.id; }),
                heap_.end());
  }
  [[nodiscard]] std::size_t n_bytes() const { return heap_.capacity() * sizeof(Ranked); }

 private:
  static bool comes_later(const Ranked& a, const Ranked& b) {
    return IsReversed ? a.comes_before(b) : b.comes_before(a);
  }

  std::vector<Ranked> heap_;
};

}  // namespace lode
