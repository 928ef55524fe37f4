#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/models/diamond/lattice.h"

namespace lode::diamond {

/// Which bricks of a field have to be looked at, again where something near has changed.
class DueBricks {
 public:
  enum State : std::uint8_t {
    unmet,  ///< Not before something far reaches it.
    done,
    due
  };

  /// is_met(brick): whether it is due at first, or else unmet.
  template <typename IsMet>
  DueBricks(const Index<3>& brick_dims, const IsMet& is_met)
      : dims_(brick_dims), states_(n_points<3>(brick_dims)) {
    for (std::size_t i = 0; i < states_.size(); ++i)
      states_[i] = is_met(point_of<3>(dims_, i)) ? due : unmet;
  }

  [[nodiscard]] std::vector<Index<3>> list_due() const {
    return list([](State state) { return state == due; });
  }
  /// Those that are done, or due.
  [[nodiscard]] std::vector<Index<3>> list_met() const {
    return list([](State state) { return state != unmet; });
  }
  [[nodiscard]] bool is_unmet(std::size_t brick) const { return states_[brick] == unmet; }
  void finish(const Index<3>& brick) { states_[linear_index<3>(dims_, brick)] = done; }
  /// Those in a state that have samples within `reach` of a point along each axis.
  void mark(const Index<3>& centre, std::int32_t reach, State state) {
    Index<3> lower;
    Index<3> n;
    for (std::size_t a = 0; a < 3; ++a) {
      lower[a] = std::max(centre[a] - reach, 0) / kBrickEdge<3>;
      n[a] = std::min((centre[a] + reach) / kBrickEdge<3> + 1, dims_[a]) - lower[a];
      if (n[a] <= 0) return;
    }
    for (std::size_t i = 0; i < n_points<3>(n); ++i) {
      State& own = states_[linear_index<3>(dims_, lower + point_of<3>(n, i))];
      if (own == state) own = due;
    }
  }

 private:
  template <typename IsListed>
  [[nodiscard]] std::vector<Index<3>> list(const IsListed& is_listed) const {
    std::vector<Index<3>> bricks;
    for (std::size_t i = 0; i < states_.size(); ++i)
      if (is_listed(states_[i])) bricks.push_back(point_of<3>(dims_, i));
    return bricks;
  }

  Index<3> dims_;
  std::vector<State> states_;
};

}  // namespace lode::diamond
