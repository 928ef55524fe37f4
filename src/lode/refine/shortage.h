#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "lode/refine/demand_queue.h"

namespace lode {

/// What an engine knows of candidates for whose pages there is no memory.
struct Shortage {
  std::vector<Ranked> blocked;   ///< Until something that is wanted less goes.
  float blocked_demand = 0;      ///< The largest of them: nothing that is wanted less is applied.
  std::uint64_t free_then = 0;   ///< What was free when the last one was blocked.
  std::vector<Ranked> hopeless;  ///< Nothing that is wanted less is left to go.
  std::uint64_t room_then = 0;   ///< How much could be held then.

  /// For a query, from a cut of so many nodes.
  void start(std::size_t n_nodes) {
    blocked.clear();
    blocked_demand = 0;
    hopeless.clear();
    n_asked_.clear();
    n_exchanges_ = kExchanges + 4 * n_nodes;
  }
  /// Whether a page may be asked for again: where chains need more pages at once than fit, they
  /// would take them from each other for ever.
  [[nodiscard]] bool may_ask(std::uint32_t page) { return n_asked_[page]++ < kAsks; }
  void forget_asked() { n_asked_.clear(); }
  /// Whether one more node may be undone for others.
  [[nodiscard]] bool may_exchange() { return n_exchanges_ > 0 && n_exchanges_-- > 0; }
  [[nodiscard]] std::size_t n_bytes() const {
    return (blocked.capacity() + hopeless.capacity()) * sizeof(Ranked) +
           n_asked_.size() * 4 * sizeof(std::uint64_t);
  }

 private:
  static constexpr int kAsks = 4;
  static constexpr std::uint64_t kExchanges = 100'000;

  std::unordered_map<std::uint32_t, int> n_asked_;
  std::uint64_t n_exchanges_ = kExchanges;
};

}  // namespace lode
