#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <vector>

#include "lode/core/atomic_extremes.h"
#include "lode/core/progress.h"
#include "lode/models/diamond/cube_plan.h"
#include "lode/models/diamond/interpolant_kernel.h"
#include "lode/models/diamond/leaf_attributes.h"
#include "lode/models/diamond/raw_level.h"

namespace lode::diamond {

/// What rounding may have hidden from a computed error: F' is a chain of at most 64 means, each
/// rounded once. Nothing where all values are integers with room for the weights.
template <int D>
[[nodiscard]] double rounding_slack(const Model<D>& model) {
  const bool is_exact = !is_floating(model.info.type) && size_of(model.info.type) <= 4;
  if (is_exact || model.stats.min == model.stats.max) return 0;
  return 0x1p-47 * std::max(std::abs(model.stats.min), std::abs(model.stats.max));
}

/// Finds the leaf attributes and all own errors, brick by brick. Each brick sees its samples and
/// one layer round them, and the corners of coarser cubes; the largest over bricks is the answer,
/// whatever the order.
template <int D, typename C>
class ErrorPass {
 public:
  ErrorPass(const Model<D>& model, std::vector<RawLevel<C>>& levels)
      : model_(model), levels_(levels), slack_(rounding_slack<D>(model)) {}

  void run_brick(const Index<D>& brick) {
    values_.resize(kMarginPoints);
    gather_values<D>(model_, brick, 1, values_.data());
    put_leaf_attributes(brick);
    if (model_.shape.n_levels == 1) return;
    const bool has_holes = model_.has_holes();
    for (int first = 0; first < kPlansPerBrick<D>; first += static_cast<int>(kLanes)) {
      if (!gather_lanes(brick, first)) continue;
      const Holes holes = has_holes ? Holes::present : Holes::absent;
      node_errors(holes);
      for (int level = kPlanLevel + 1; level < model_.shape.n_levels; ++level)
        for (int tier = 0; tier < D; ++tier) coarse_errors(level, tier, holes);
    }
  }

  void put_leaf_attributes(const Index<D>& brick) {
    compute_leaf_attributes<D>(model_, brick, values_.data(), leaf_);
    const Index<D> dims = level_dims<D>(model_.shape, 0);
    Index<D> edge;
    for (std::size_t i = 0; i < as_size(D); ++i) edge[i] = kLeafCubes<D>;
    for (std::size_t i = 0; i < leaf_.error.size(); ++i) {
      const Index<D> cube = brick * kLeafCubes<D> + point_of<D>(edge, i);
      bool is_inside = true;
      for (std::size_t a = 0; a < as_size(D); ++a) is_inside = is_inside && cube[a] < dims[a];
      if (!is_inside) continue;
      const std::size_t at = linear_index<D>(dims, cube);
      levels_[0].error[at] = float_up(static_cast<double>(leaf_.error[i]) + slack_);
      levels_[0].low[at] = leaf_.low[i];
      levels_[0].high[at] = leaf_.high[i];
    }
  }

  void gather_only(const Index<D>& brick) {
    values_.resize(kMarginPoints);
    gather_values<D>(model_, brick, 1, values_.data());
  }

 private:
  static constexpr int kPlanLevel = D == 3 ? 3 : 4;  // tier-0 level of a cube of side kPlanEdge
  static constexpr std::size_t kMarginPoints =
      D == 3 ? std::size_t{35} * 35 * 35 : std::size_t{131} * 131;

  struct Lane {
    bool is_used = false;
    CanonicalCube<D> cube{{}, kPlanEdge<D>};
  };

  /// Offsets into the brick's samples (with margin) of each point of each of its cubes: the same
  /// for every brick, because a brick is itself a cube of the hierarchy.
  static const std::vector<std::uint32_t>& lane_offsets() {
    static const std::vector<std::uint32_t> offsets = [] {
      std::vector<std::uint32_t> result(kPlanPoints<D> * as_size(kPlansPerBrick<D>));
      Index<D> dims;
      for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
      for (std::size_t cube = 0; cube < as_size(kPlansPerBrick<D>); ++cube)
        for (std::size_t i = 0; i < kPlanPoints<D>; ++i) {
          const Index<D> p = cube_of({}, cube).global(point_of<D>(dims, i));
          std::size_t at = 0;
          for (std::size_t a = as_size(D); a-- > 0;)
            at = at * as_size(kBrickSamples<D> + 2) + as_size(p[a] + 1);
          result[i * as_size(kPlansPerBrick<D>) + cube] = static_cast<std::uint32_t>(at);
        }
      return result;
    }();
    return offsets;
  }

  /// Fills the lanes with the brick's cubes first .. first + kLanes - 1; false when none of them
  /// meets the data.
  bool gather_lanes(const Index<D>& brick, int first) {
    bool is_any = false;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const CanonicalCube<D> cube = cube_of(brick, as_size(first) + l);
      const Index<D> lower = cube.lowest_corner();
      lanes_[l] = {true, cube};
      for (std::size_t i = 0; i < as_size(D); ++i)
        lanes_[l].is_used = lanes_[l].is_used && lower[i] < model_.shape.dims[i] - 1;
      is_any = is_any || lanes_[l].is_used;
    }
    if (!is_any) return false;
    vertices_.resize(kPlanPoints<D> * kLanes);
    scratch_.resize(kPlanPoints<D> * kLanes);
    const std::uint32_t* offsets = lane_offsets().data() + first;
    for (std::size_t i = 0; i < kPlanPoints<D>; ++i, offsets += kPlansPerBrick<D>)
      for (std::size_t l = 0; l < kLanes; ++l) vertices_[i * kLanes + l] = values_[offsets[l]];
    samples_ = vertices_;
    for (std::size_t i = 0; i < as_size(D); ++i)
      if ((brick[i] + 1) * kBrickEdge<D> >= model_.shape.dims[i]) {
        mask_beyond_data();
        break;
      }
    return true;
  }

  /// Points beyond the data do not count as samples.
  void mask_beyond_data() {
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    for (std::size_t i = 0; i < kPlanPoints<D>; ++i)
      for (std::size_t l = 0; l < kLanes; ++l)
        if (!model_.shape.is_sample(lanes_[l].cube.global(point_of<D>(dims, i))))
          samples_[i * kLanes + l] = std::numeric_limits<C>::quiet_NaN();
  }

  static CanonicalCube<D> cube_of(const Index<D>& brick, std::size_t number) {
    Index<D> per_edge;
    for (std::size_t i = 0; i < as_size(D); ++i) per_edge[i] = kBrickEdge<D> / kPlanEdge<D>;
    return CanonicalCube<D>(brick * kBrickEdge<D> + point_of<D>(per_edge, number) * kPlanEdge<D>,
                            kPlanEdge<D>);
  }

  void put_error(int level, const Index<D>& node, C error) {
    if (!(error > C(0)) && slack_ == 0) return;
    const Index<D> dims = model_.shape.grid_dims(level);
    Index<D> q;
    for (std::size_t i = 0; i < as_size(D); ++i) {
      q[i] = node[i] >> level;
      if (q[i] < 0 || q[i] >= dims[i]) return;
    }
    raise_to(levels_[as_size(level)].error[linear_index<D>(dims, q)],
             float_up(static_cast<double>(error) + slack_));
  }

  void node_errors(Holes holes) {
    const CubePlan<D>& plan = CubePlan<D>::instance();
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    for (const auto& node_pass : plan.node_passes) {
      if (node_pass.level >= model_.shape.n_levels) continue;
      const auto& regions = node_pass.pass.regions;
      errors_.resize(regions.size() * kLanes);
      run_interpolant(node_pass.pass, {samples_.data(), vertices_.data(), scratch_.data()}, holes,
                      errors_.data());
      for (std::size_t r = 0; r < regions.size(); ++r) {
        const Index<D> u = point_of<D>(dims, regions[r].target);
        for (std::size_t l = 0; l < kLanes; ++l)
          if (lanes_[l].is_used)
            put_error(node_pass.level, lanes_[l].cube.global(u), errors_[r * kLanes + l]);
      }
    }
  }

  /// The cube of side 2h of a level that contains a lane's cube.
  static CanonicalCube<D> coarse_cube(int level, const CanonicalCube<D>& lane) {
    return CanonicalCube<D>(lane.lowest_corner(), std::int32_t{2} << level);
  }

  void coarse_errors(int level, int tier, Holes holes) {
    const CubePlan<D>& plan = CubePlan<D>::instance();
    Index<D> dims;
    for (std::size_t i = 0; i < as_size(D); ++i) dims[i] = kPlanEdge<D> + 1;
    corners_.resize(kPlanPoints<D> * kLanes);
    for (std::size_t l = 0; l < kLanes; ++l) {
      const CanonicalCube<D> cube = coarse_cube(level, lanes_[l].cube);
      for (const std::uint16_t corner : plan.kuhn.vertices) {
        const Index<D> p = lanes_[l].cube.global(point_of<D>(dims, corner));
        corners_[corner * kLanes + l] =
            lanes_[l].is_used
                ? static_cast<C>(interpolant_at<D>(
                      cube.local(p), cube.side, tier,
                      [&](const Index<D>& u) { return model_.value_or_nan(cube.global(u)); }))
                : C(0);
      }
    }
    errors_.resize(plan.kuhn.regions.size() * kLanes);
    run_interpolant(plan.kuhn, {samples_.data(), corners_.data(), scratch_.data()}, holes,
                    errors_.data());
    for (std::size_t r = 0; r < plan.kuhn.regions.size(); ++r)
      for (std::size_t l = 0; l < kLanes; ++l)
        if (lanes_[l].is_used) put_coarse_error(level, tier, l, r, errors_[r * kLanes + l]);
  }

  /// A Kuhn simplex lies in one coarser diamond of each tier: the one round its centroid.
  void put_coarse_error(int level, int tier, std::size_t l, std::size_t simplex, C error) {
    const CanonicalCube<D> cube = coarse_cube(level, lanes_[l].cube);
    Index<D> sum;  // (D+1) · centroid
    for (const Index<D>& v : CubePlan<D>::instance().kuhn_simplices[simplex].v)
      sum = sum + cube.local(lanes_[l].cube.global(v));
    for (Index<D> node : nodes_containing<D>(sum, cube.side * (D + 1), tier)) {
      for (std::size_t i = 0; i < as_size(D); ++i) node[i] /= D + 1;
      put_error(level, cube.global(node), error);
    }
  }

  const Model<D>& model_;
  std::vector<RawLevel<C>>& levels_;
  double slack_;
  std::array<Lane, kLanes> lanes_;
  std::vector<C> values_;
  LeafAttributes<C> leaf_;
  AlignedVector<C> samples_, vertices_, scratch_, corners_, errors_;
};

/// Whether float32 holds every interpolant exactly: multiples of 1/root side below the largest
/// value's magnitude.
template <int D>
[[nodiscard]] bool is_exact_in_float(const Model<D>& model) {
  if (is_floating(model.storage)) return false;
  const double largest = std::max(std::abs(model.stats.min), std::abs(model.stats.max));
  const int bits = static_cast<int>(std::ceil(std::log2(largest + 1))) + 1;
  return bits + model.shape.n_levels <= 24;
}

/// The own errors of all nodes, and the leaf attributes (nested, as level 0 holds them).
template <int D, typename C>
[[nodiscard]] Result<std::vector<RawLevel<C>>> find_own_errors(const Model<D>& model,
                                                               Threads threads,
                                                               Progress& progress) {
  std::vector<RawLevel<C>> raw;
  for (int level = 0; level < model.shape.n_levels; ++level)
    raw.emplace_back(n_points<D>(level_dims<D>(model.shape, level)));
  std::vector<std::unique_ptr<ErrorPass<D, C>>> passes(as_size(n_workers(threads)));
  std::atomic<std::size_t> n_done{0};
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C>>(model, raw);
    pass->run_brick(point_of<D>(model.brick_dims, i));
    progress.report("errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  return raw;
}

}  // namespace lode::diamond
