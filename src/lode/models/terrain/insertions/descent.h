#pragma once

#include <cstdint>
#include <vector>

#include "lode/models/terrain/insertions/history.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

[[nodiscard]] inline LatticeCorners corners_of(const History& history,
                                               const std::array<std::uint32_t, 3>& corner) {
  return {history.vertices[corner[0]], history.vertices[corner[1]], history.vertices[corner[2]]};
}

/// Down a history from one triangle to those of a later time.
class Descent {
 public:
  explicit Descent(const History& history) : history_(history), seen_(history.triangles.size()) {}

  /// Calls visit(t) for each triangle of the mesh of some nodes that meets(t), once since the last
  /// restart(), if t descends from `from`: is that itself or made in its place. What does not meet
  /// is not followed.
  template <typename Meets, typename Visit>
  void run(std::uint32_t from, const NodeSet& nodes, const Meets& meets, const Visit& visit) {
    push(from, meets);
    while (!open_.empty()) {
      const std::uint32_t t = open_.back();
      open_.pop_back();
      const std::uint32_t death = history_.triangles[t].death;
      if (!nodes.has(death)) {
        visit(t);
        continue;
      }
      for (std::uint32_t made = history_.first_made[death]; made < history_.first_made[death + 1];
           ++made)
        push(made, meets);
    }
  }
  void restart() {
    if (++round_ == 0) {
      seen_.assign(seen_.size(), 0);
      round_ = 1;
    }
  }

 private:
  template <typename Meets>
  void push(std::uint32_t t, const Meets& meets) {
    if (seen_[t] == round_) return;
    seen_[t] = round_;
    if (meets(t)) open_.push_back(t);
  }

  const History& history_;
  std::vector<std::uint32_t> seen_;  ///< By triangle: in which round it was.
  std::uint32_t round_ = 1;
  std::vector<std::uint32_t> open_;
};

}  // namespace lode::insertions
