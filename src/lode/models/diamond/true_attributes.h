#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "lode/core/atomic_extremes.h"
#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/world_error.h"

namespace lode::diamond {

/// Attributes of one level's nodes as recomputed, laid out as NodeLevel's.
struct TrueLevel {
  std::vector<double> error, low, high;
  std::vector<double> error_inside;  ///< Where simplices only touch the data, no samples count.
  std::vector<double> world;         ///< Shares of the level's longest edge.

  explicit TrueLevel(std::size_t n)
      : error(n, 0.0), low(n, kEndless), high(n, -kEndless), error_inside(n, 0.0), world(n, 0.0) {}
  static constexpr double kEndless = std::numeric_limits<double>::infinity();

  void join(std::size_t at, double e, double l, double h) {
    raise_to(error[at], e);
    raise_to(high[at], h);
    lower_to(low[at], l);
  }
};

/// Whether the inside of a node's domain meets the data: no simplex needs the others.
template <int D>
bool meets_data(const Shape<D>& shape, const Diamond<D>& d) {
  return shape.overlaps_data(bounds_of(d));
}

/// Where a node's attributes are stored; -1 where they are not.
template <int D>
std::ptrdiff_t place_of(const Shape<D>& shape, const Diamond<D>& d) {
  if ((d.level == 0 && d.tier > 0) || !meets_data<D>(shape, d)) return -1;
  Index<D> dims;
  Index<D> q;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    dims[i] = d.level == 0 ? shape.n_cubes(0, static_cast<int>(i)) : shape.grid_dims(d.level)[i];
    q[i] = d.level == 0 ? d.centre[i] >> 1 : d.centre[i] >> d.level;
    if (d.centre[i] < 0 || q[i] >= dims[i]) return -1;
  }
  return static_cast<std::ptrdiff_t>(linear_index<D>(dims, q));
}

/// Finds the own attributes of every stored node, brick by brick and level by level.
template <int D>
class OwnAttributes {
 public:
  OwnAttributes(const Model<D>& model, std::vector<TrueLevel>& levels)
      : model_(model), levels_(levels), scales_(model) {}

  void add_brick(const Index<D>& brick) const {
    for (int level = 0; level < model_.shape.n_levels; ++level) {
      const std::int32_t side = std::int32_t{2} << level;
      const std::int32_t step = std::min(side, kBrickEdge<D>);
      Index<D> n;
      for (std::size_t i = 0; i < as_size(D); ++i) n[i] = kBrickEdge<D> / step;
      for (std::size_t i = 0; i < n_points<D>(n); ++i) {
        const Index<D> lower = brick * kBrickEdge<D> + point_of<D>(n, i) * step;
        add_box(level, lower, step);
      }
    }
  }

  /// Those of the brick's cubes of side 2.
  void add_finest_worlds(const Index<D>& brick) const {
    const Index<D> lower = brick * kBrickEdge<D>;
    const Index<D> points = all_equal<D>(kBrickSamples<D>);
    std::vector<double> own(n_points<D>(points));
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Diamond<D> node = diamond_at<D>(lower + point_of<D>(points, i));
      if (node.level == 0 && meets_data<D>(model_.shape, node))
        own[i] = finest_own_world<D>(model_, node, scales_);
    }
    const Index<D> n = all_equal<D>(kBrickEdge<D> / 2);
    for (std::size_t i = 0; i < n_points<D>(n); ++i) {
      const Index<D> centre = brick * kBrickEdge<D> + point_of<D>(n, i) * 2 + all_equal<D>(1);
      const std::ptrdiff_t place = place_of<D>(model_.shape, diamond_at<D>(centre));
      if (place < 0) continue;
      double& world = levels_[0].world[static_cast<std::size_t>(place)];
      for (std::size_t k = 0; k < power(3, D); ++k) {
        const Index<D> step = point_of<D>(all_equal<D>(3), k) - all_equal<D>(1);
        world = std::max(world, own[linear_index<D>(points, centre + step - lower)]);
      }
    }
  }

 private:
  /// Adds the samples of a box of the lattice, which one cube of the level contains.
  void add_box(int level, const Index<D>& lower, std::int32_t edge) const {
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      if (lower[i] >= model_.shape.dims[i] - 1) return;
      dims[i] = std::min(edge, model_.shape.dims[i] - 1 - lower[i]) + 1;
    }
    const CanonicalCube<D> cube(lower, std::int32_t{2} << level);
    const int n_tiers = level == 0 ? 1 : D;
    for (std::size_t i = 0; i < n_points<D>(dims); ++i) {
      const Index<D> p = lower + point_of<D>(dims, i);
      const double f = model_.value_or_nan(p);
      const Index<D> u = cube.local(p);
      const auto values = interpolants_at<D>(u, cube.side, [&](const Index<D>& v) {
        return model_.value_or_nan(cube.global(v * (cube.side / 2)));
      });
      for (int tier = 0; tier < n_tiers; ++tier)
        add_sample(level, tier, cube, u, f, values[as_size(tier)]);
    }
  }

  /// `f`: the sample at u; `g`: what it is interpolated to.
  void add_sample(int level, int tier, const CanonicalCube<D>& cube, const Index<D>& u, double f,
                  double g) const {
    const double e = std::isnan(f) || std::isnan(g) ? 0 : std::abs(f - g);
    for (const Index<D>& centre : nodes_containing<D>(u, cube.side, tier)) {
      const Diamond<D> node = diamond_at<D>(cube.global(centre));
      const std::ptrdiff_t at = place_of<D>(model_.shape, node);
      if (at < 0) continue;
      TrueLevel& own = levels_[as_size(level)];
      const auto i = static_cast<std::size_t>(at);
      // A sample of a simplex that has a hole: beyond the data there are none.
      const bool is_at_hole = std::isnan(f) != std::isnan(g) && is_in_data(node);
      const double error = is_at_hole ? TrueLevel::kEndless : e;
      raise_to(own.error[i], error);
      if (!std::isnan(f)) own.join(i, 0, f, f);
      if (error > own.error_inside[i] && reaches_into_data(cube, u, tier, centre))
        raise_to(own.error_inside[i], error);
    }
  }

  /// Whether a node that has the sample u has a simplex there with more of the data: points beside
  /// u that lie on no simplex's border tell.
  [[nodiscard]] bool reaches_into_data(const CanonicalCube<D>& cube, const Index<D>& u, int tier,
                                       const Index<D>& centre) const {
    const Index<D> last = model_.shape.dims - all_equal<D>(1);
    const Index<D> p = cube.global(u);
    int n_last = 0;
    for (std::size_t i = 0; i < as_size(D); ++i) n_last += p[i] == last[i] ? 1 : 0;
    if (n_last < 2) return true;
    constexpr std::int32_t kScale = 8;  // steps stay on the same side of borders without u
    for (std::size_t k = 0; k < power(2 * D + 1, D); ++k) {
      const Index<D> step = point_of<D>(all_equal<D>(2 * D + 1), k) - all_equal<D>(D);
      Index<D> beside = u * kScale;
      std::uint32_t lengths = 0;
      bool is_inside = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        beside[i] += step[i] * cube.sign[i];
        lengths |= 1U << std::abs(step[i]);
        is_inside = is_inside && beside[i] >= 0 && beside[i] <= cube.side * kScale &&
                    (p[i] < last[i] || step[i] < 0);
      }
      if (lengths != (2U << D) - 2 || !is_inside) continue;  // each of 1 .. D once
      if (nodes_round<D>(beside, cube.side * kScale)[as_size(tier)] == centre * kScale) return true;
    }
    return false;
  }

  [[nodiscard]] bool is_in_data(const Diamond<D>& node) const {
    const LatticeBox<D> box = bounds_of(node);
    return model_.shape.is_sample(box.lower) && model_.shape.is_sample(box.upper);
  }

  const Model<D>& model_;
  std::vector<TrueLevel>& levels_;
  WorldScales<D> scales_;
};

}  // namespace lode::diamond
