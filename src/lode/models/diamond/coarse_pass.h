#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>

#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/interpolant_kernel.h"
#include "lode/models/diamond/own_errors.h"

namespace lode::diamond {

/// The nodes coarser than a plan's cube, one level at a time. F' of such a level is linear on each
/// Kuhn simplex of the cube, so the values at the cube's corners say all; they follow from the 3^D
/// values at the corners, edge middles and centres of the level's cube round it. `Field` is a
/// LatticeField that gives the samples at least of these levels.
template <int D, typename C, typename Field>
class CoarsePass {
 public:
  CoarsePass(const Field& field, double slack, const OwnErrors& own)
      : field_(field), slack_(slack), own_(own) {
    for (auto& corners : corners_) corners.resize(power(2, D) * kLanes);
    for (auto& errors : errors_) errors.resize(CubePlan<D>::instance().kuhn.size() * kLanes);
  }

  [[nodiscard]] int n_levels() const { return field_.shape.n_levels; }

  /// Whether samples from `low` to `high` in a cube of the hierarchy, smaller than the level's, may
  /// raise an error of the level above what is known by now.
  [[nodiscard]] bool can_raise(int level, const CanonicalCube<D>& cube, C low, C high) {
    const CanonicalCube<D> coarse = coarse_cube(cube, level);
    find_vertices(coarse);
    PerTier<std::array<C, power(2, D)>> bounds;
    for (std::size_t corner = 0; corner < power(2, D); ++corner) {
      const PerTier<double> values = corner_values(coarse, cube, corner);
      for (std::size_t tier = 0; tier < as_size(D); ++tier) {
        const C value = static_cast<C>(values[tier]);
        bounds[tier][corner] = std::isnan(value) ? std::numeric_limits<C>::infinity()
                                                 : std::max({C{0}, high - value, value - low});
      }
    }
    const auto& kuhn = CubePlan<D>::instance().kuhn;
    const bool has_one_node = is_in_one_node(coarse, cube);
    for (std::size_t s = 0; s < (has_one_node ? 1 : kuhn.size()); ++s) {
      const PerTier<Place> places = places_of(level, coarse, cube, s);
      for (std::size_t tier = 0; tier < as_size(D); ++tier) {
        C bound = 0;
        if (has_one_node)
          bound = *std::max_element(bounds[tier].begin(), bounds[tier].end());
        else
          for (const std::uint16_t corner : kuhn[s].corner)
            bound = std::max(bound, bounds[tier][corner]);
        if (exceeds_known(bound, level, places[tier])) return true;
      }
    }
    return false;
  }

  /// `cubes`: one per lane, on the field's lattice; those not used are ignored.
  void run(int level, const std::array<CanonicalCube<D>, kLanes>& cubes,
           const std::array<bool, kLanes>& is_used, const C* samples, Gaps gaps) {
    const auto& kuhn = CubePlan<D>::instance().kuhn;
    for (std::size_t l = 0; l < kLanes; ++l)
      if (is_used[l]) find_corners(coarse_cube(cubes[l], level), cubes[l], l);
    LinearArrays<C> arrays{.samples = samples, .corners = {}, .errors = {}};
    for (std::size_t tier = 0; tier < 3; ++tier) {  // the last one twice where D is 2
      arrays.corners[tier] = corners_[std::min(tier, as_size(D) - 1)].data();
      arrays.errors[tier] = errors_[tier].data();
    }
    run_linear(kuhn, arrays, gaps);
    if (gaps == Gaps::holes) correct_at_holes(is_used, samples);
    for (std::size_t l = 0; l < kLanes; ++l) {
      if (!is_used[l]) continue;
      const CanonicalCube<D> coarse = coarse_cube(cubes[l], level);
      if (is_in_one_node(coarse, cubes[l])) {
        put_largest_errors(level, coarse, cubes[l], l);
        continue;
      }
      for (std::size_t s = 0; s < kuhn.size(); ++s) {
        const PerTier<Place> places = places_of(level, coarse, cubes[l], s);
        for (std::size_t tier = 0; tier < as_size(D); ++tier)
          put_error(errors_[tier][s * kLanes + l], level, places[tier]);
      }
    }
  }

 private:
  template <typename T>
  using PerTier = std::array<T, as_size(D)>;
  /// Of a node among its level's; none where it is beyond the data.
  using Place = std::optional<std::size_t>;

  /// The cube of the level that a lane's cube lies in.
  static CanonicalCube<D> coarse_cube(const CanonicalCube<D>& cube, int level) {
    return CanonicalCube<D>(cube.lowest_corner(), std::int32_t{2} << level);
  }

  /// Whether all of a cube lies in one node of each tier of the coarse cube: which one depends on
  /// the order of the coordinates' distances to its border (see nodes_containing()), and those of
  /// two axes go through the same steps of the cube's side or through none in common.
  [[nodiscard]] static bool is_in_one_node(const CanonicalCube<D>& coarse,
                                           const CanonicalCube<D>& cube) {
    const Index<D> a = coarse.local(cube.global({}));
    const Index<D> b = coarse.local(cube.global(all_equal<D>(cube.side)));
    Index<D> distance;  // of the side that is next to the border
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t lower = std::min(a[i], b[i]);
      distance[i] = std::min(lower, coarse.side - lower - cube.side);
      for (std::size_t j = 0; j < i; ++j)
        if (distance[j] == distance[i]) return false;
    }
    return true;
  }

  /// Whether a bound is more than what is known of a node by now. Twice the slack: values between
  /// the corners are rounded too.
  [[nodiscard]] bool exceeds_known(C bound, int level, Place place) const {
    if (!place) return false;
    const ErrorCode error = encode_error(float_up(static_cast<double>(bound) + slack_ + slack_));
    std::atomic_ref<ErrorCode> known(own_[as_size(level)][*place]);
    return error > known.load(std::memory_order_relaxed);
  }

  void find_corners(const CanonicalCube<D>& coarse, const CanonicalCube<D>& cube,
                    std::size_t lane) {
    find_vertices(coarse);
    for (std::size_t corner = 0; corner < power(2, D); ++corner) {
      const PerTier<double> values = corner_values(coarse, cube, corner);
      for (std::size_t tier = 0; tier < as_size(D); ++tier)
        corners_[tier][corner * kLanes + lane] = static_cast<C>(values[tier]);
    }
  }

  /// F' at a cube's corner (bit i: at the far end of axis i); vertices_ are of `coarse`.
  [[nodiscard]] PerTier<double> corner_values(const CanonicalCube<D>& coarse,
                                              const CanonicalCube<D>& cube,
                                              std::size_t corner) const {
    Index<D> u;
    for (std::size_t i = 0; i < as_size(D); ++i) u[i] = (corner >> i & 1U) != 0 ? cube.side : 0;
    return interpolants_at<D>(coarse.local(cube.global(u)), coarse.side, [&](const Index<D>& v) {
      return vertices_[linear_index<D>(all_equal<D>(3), v)];
    });
  }

  /// The samples at the coarse cube's vertices; kept from call to call, as neighbours share it.
  void find_vertices(const CanonicalCube<D>& coarse) {
    if (coarse == vertices_of_) return;
    vertices_of_ = coarse;
    const Index<D> three = all_equal<D>(3);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      vertices_[i] = field_.value_or_nan(coarse.global(point_of<D>(three, i) * (coarse.side / 2)));
  }

  /// Finds the errors of simplices with a hole at a corner: it counts for points that lean on it
  /// and are no holes themselves.
  void correct_at_holes(const std::array<bool, kLanes>& is_used, const C* samples) {
    const auto& kuhn = CubePlan<D>::instance().kuhn;
    for (std::size_t tier = 0; tier < as_size(D); ++tier)
      for (std::size_t s = 0; s < kuhn.size(); ++s)
        for (std::size_t l = 0; l < kLanes; ++l) {
          std::array<C, as_size(D) + 1> corner;
          bool has_hole = false;
          for (std::size_t j = 0; j < corner.size(); ++j) {
            corner[j] = corners_[tier][kuhn[s].corner[j] * kLanes + l];
            has_hole = has_hole || std::isnan(corner[j]);
          }
          if (is_used[l] && has_hole)
            errors_[tier][s * kLanes + l] = error_at_hole(kuhn[s], corner, samples + l);
        }
  }

  static C error_at_hole(const KuhnSimplex<D>& simplex, const std::array<C, as_size(D) + 1>& corner,
                         const C* samples) {
    C largest = 0;
    for (const auto& row : simplex.rows)
      for (std::size_t i = 0; i < row.n; ++i) {
        const C f = samples[row.first + i * simplex.step];
        if (std::isnan(f)) continue;  // infinite where a hole is
        C value = 0;
        std::size_t rest = as_size(kPlanEdge<D>);  // what the corners from j on weigh
        for (std::size_t j = 0; j <= as_size(D); ++j) {
          const std::size_t next = j == as_size(D) ? 0 : row.u[j] + (j == 0 ? i : 0);
          if (rest > next) value += static_cast<C>(rest - next) * corner[j];
          rest = next;
        }
        const C error = std::abs(f - value / static_cast<C>(kPlanEdge<D>));
        if (!std::isnan(error))
          largest = std::max(largest, error);
        else if (!std::isinf(f))
          return std::numeric_limits<C>::infinity();
      }
    return largest;
  }

  /// A Kuhn simplex of a cube lies in one node of each tier of a coarser level: the one round its
  /// centroid.
  [[nodiscard]] PerTier<Place> places_of(int level, const CanonicalCube<D>& coarse,
                                         const CanonicalCube<D>& cube, std::size_t simplex) const {
    const Index<D> dims = field_.shape.grid_dims(level);
    Index<D> sum = coarse.local(cube.even_corner) * (D + 1);  // (D+1) · centroid
    for (const std::uint16_t corner : CubePlan<D>::instance().kuhn[simplex].corner)
      for (std::size_t i = 0; i < as_size(D); ++i)
        if ((corner >> i & 1U) != 0) sum[i] += cube.sign[i] * coarse.sign[i] * cube.side;
    PerTier<Place> places;
    const auto nodes = nodes_round<D>(sum, coarse.side * (D + 1));
    for (std::size_t tier = 0; tier < as_size(D); ++tier) {
      Index<D> q = nodes[tier];
      for (std::size_t i = 0; i < as_size(D); ++i) q[i] /= D + 1;
      q = coarse.global(q);
      bool exists = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        q[i] >>= level;
        exists = exists && q[i] < dims[i];
      }
      if (exists) places[tier] = linear_index<D>(dims, q);
    }
    return places;
  }

  void put_error(C error, int level, Place place) {
    if (place)
      raise_to(own_[as_size(level)][*place],
               encode_error(float_up(static_cast<double>(error) + slack_)));
  }

  /// Of a lane's cube that lies in one node of each tier.
  void put_largest_errors(int level, const CanonicalCube<D>& coarse, const CanonicalCube<D>& cube,
                          std::size_t lane) {
    const auto& kuhn = CubePlan<D>::instance().kuhn;
    const PerTier<Place> places = places_of(level, coarse, cube, 0);
    for (std::size_t tier = 0; tier < as_size(D); ++tier) {
      C largest = 0;
      for (std::size_t s = 0; s < kuhn.size(); ++s)
        largest = std::max(largest, errors_[tier][s * kLanes + lane]);
      put_error(largest, level, places[tier]);
    }
  }

  const Field& field_;
  double slack_;
  const OwnErrors& own_;
  CanonicalCube<D> vertices_of_;
  std::array<double, power(3, D)> vertices_{};
  std::array<AlignedVector<C>, as_size(D)> corners_;  ///< Per tier, corner and lane.
  std::array<AlignedVector<C>, 3> errors_;            ///< Per tier, Kuhn simplex and lane.
};

}  // namespace lode::diamond
