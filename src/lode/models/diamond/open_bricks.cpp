#include "lode/models/diamond/open_bricks.h"

#include <cmath>

namespace lode::diamond {

/// How many steps of the lattice an axis's coordinate may change by within the distance; no more
/// than matters. Round a window a brick is seen; what an own triangle is proven by may be as far
/// from it as the other end of that.
void OpenBricks::find_reach(const RegularGrid& grid, double distance) {
  const Vec3d first = grid.to_index({});
  for (std::size_t i = 0; i < 3; ++i) {
    double squared = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      Vec3d p;
      p[j] = 1;
      const double change = grid.to_index(p)[i] - first[i];
      squared += change * change;
    }
    const double steps = std::ceil(std::sqrt(squared) * distance * (1 + 1e-6)) + 1;
    const auto at_most = [&](std::int32_t most) {
      return static_cast<std::int32_t>(std::min<double>(most, steps));
    };
    seen_[i] = at_most(kBrickEdge<3>);
    reach_[i] = at_most(kChunkEdge<3> + kBrickEdge<3>);
  }
}

void OpenBricks::open_near(const Index<3>& centre) {
  const std::int32_t h = std::int32_t{1} << common_exponent<3>(centre);
  LatticeBox<3> near;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t reach = h + reach_[i];
    near.lower[i] = std::min(std::max(centre[i] - reach, 0) / kBrickEdge<3>, dims_[i] - 1);
    near.upper[i] = std::min((centre[i] + reach) / kBrickEdge<3>, dims_[i] - 1) + 1;
  }
  const Index<3> n = near.upper - near.lower;
  for (std::size_t i = 0; i < n_points<3>(n); ++i) {
    State& state = states_[linear_index<3>(dims_, near.lower + point_of<3>(n, i))];
    state.is_open = state.is_met;
  }
}

double OpenBricks::share_closed() const {
  const auto n = std::ranges::count_if(states_, [](const State& state) { return state.is_open; });
  return 1 - static_cast<double>(n) / static_cast<double>(states_.size());
}

LatticeBox<3> OpenBricks::of_chunk(const Index<3>& chunk) const {
  constexpr std::int32_t kBricks = kChunkEdge<3> / kBrickEdge<3>;
  LatticeBox<3> box{chunk * kBricks, (chunk + all_equal<3>(1)) * kBricks};
  for (std::size_t i = 0; i < 3; ++i) box.upper[i] = std::min(box.upper[i], dims_[i]);
  return box;
}

LatticeBox<3> OpenBricks::widened(LatticeBox<3> box) const {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::max(box.lower[i] - 1, 0);
    box.upper[i] = std::min(box.upper[i] + 1, dims_[i]);
  }
  return box;
}

}  // namespace lode::diamond
