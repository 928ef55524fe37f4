#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "lode/refine/demand_queue.h"

namespace lode {

/// Candidates that wait for pages of their model's data, by page.
class Waiting {
 public:
  [[nodiscard]] bool is_empty() const { return by_page_.empty() && arrived_.empty(); }
  [[nodiscard]] bool has_arrived() const { return !arrived_.empty(); }

  [[nodiscard]] bool is_awaited(std::uint32_t page) const { return by_page_.contains(page); }
  /// True for the first that waits for it, or the most wanted so far.
  bool park(std::uint32_t page, const Ranked& entry) {
    Lot& lot = by_page_[page];
    lot.entries.push_back(entry);
    if (lot.entries.size() > 1 && !(entry.demand > lot.demand)) return false;
    lot.demand = entry.demand;
    return true;
  }
  void page_arrived(std::uint32_t page) {
    const auto lot = by_page_.find(page);
    if (lot == by_page_.end()) return;
    arrived_.push_back(std::move(lot->second.entries));
    by_page_.erase(lot);
  }
  /// Calls body for up to n_most entries whose pages have arrived, and forgets them.
  template <typename Body>
  void release(std::size_t n_most, const Body& body) {
    for (; n_most > 0 && !arrived_.empty(); --n_most) {
      const Ranked entry = arrived_.back().back();
      arrived_.back().pop_back();
      if (arrived_.back().empty()) arrived_.pop_back();
      body(entry);
    }
  }
  void clear() {
    by_page_.clear();
    arrived_.clear();
  }
  [[nodiscard]] std::size_t n_bytes() const {
    std::size_t n = 0;
    for (const auto& [page, lot] : by_page_)
      n += sizeof(Lot) + lot.entries.capacity() * sizeof(Ranked);
    for (const auto& entries : arrived_) n += entries.capacity() * sizeof(Ranked);
    return n;
  }

 private:
  struct Lot {
    std::vector<Ranked> entries;
    float demand = 0;
  };

  std::unordered_map<std::uint32_t, Lot> by_page_;
  std::vector<std::vector<Ranked>> arrived_;  ///< None empty.
};

}  // namespace lode
