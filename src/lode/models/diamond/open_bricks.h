#pragma once

#include <algorithm>
#include <vector>

#include "lode/core/regular_grid.h"
#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The bricks of a volume in which surfaces are held against each other within a distance, window
/// by window: which of them are to be held (again).
class OpenBricks {
 public:
  struct State {
    bool is_met = false;   ///< By the surface, perhaps: others are never held.
    bool is_open = false;  ///< What it sees of the cut has changed since it was held,
    bool is_held = false;  ///< as it has been.
  };

  /// is_met(brick): whether it is to be held at all.
  template <typename IsMet>
  OpenBricks(const Shape<3>& shape, const RegularGrid& grid, double distance, const IsMet& is_met)
      : dims_(brick_counts<3>(shape)), states_(n_points<3>(dims_)) {
    find_reach(grid, distance);
    for (std::size_t i = 0; i < states_.size(); ++i)
      states_[i].is_met = states_[i].is_open = is_met(point_of<3>(dims_, i));
  }

  [[nodiscard]] const State& at(const Index<3>& brick) const {
    return states_[linear_index<3>(dims_, brick)];
  }
  void set_held(const Index<3>& brick) { states_[linear_index<3>(dims_, brick)].is_held = true; }
  void close(const Index<3>& brick) { states_[linear_index<3>(dims_, brick)].is_open = false; }
  /// Opens those that see how a new node changes the cut.
  void open_near(const Index<3>& centre);
  [[nodiscard]] double share_closed() const;

  /// Steps of the lattice round a window in which triangles of full resolution may prove something.
  [[nodiscard]] const Index<3>& seen() const { return seen_; }

  // Boxes of bricks, without their upper ends.
  [[nodiscard]] LatticeBox<3> of_chunk(const Index<3>& chunk) const;
  /// With a brick more on all sides.
  [[nodiscard]] LatticeBox<3> widened(LatticeBox<3> box) const;
  [[nodiscard]] std::vector<Index<3>> open_in(const LatticeBox<3>& box) const {
    return those_in(box, [&](const Index<3>& brick) { return at(brick).is_open; });
  }
  [[nodiscard]] std::vector<Index<3>> met_in(const LatticeBox<3>& box) const {
    return those_in(box, [&](const Index<3>& brick) { return at(brick).is_met; });
  }
  template <typename Is>
  [[nodiscard]] static std::vector<Index<3>> those_in(const LatticeBox<3>& box, const Is& is) {
    std::vector<Index<3>> bricks;
    const Index<3> n = box.upper - box.lower;
    for (std::size_t i = 0; i < n_points<3>(n); ++i)
      if (const Index<3> brick = box.lower + point_of<3>(n, i); is(brick)) bricks.push_back(brick);
    return bricks;
  }

 private:
  void find_reach(const RegularGrid& grid, double distance);

  Index<3> dims_;
  Index<3> seen_;
  Index<3> reach_;  ///< Round a new node's star.
  std::vector<State> states_;
};

}  // namespace lode::diamond
