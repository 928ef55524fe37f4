#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/coarse_pass.h"
#include "lode/models/diamond/interpolant_kernel.h"
#include "lode/models/diamond/leaf_attributes.h"
#include "lode/models/diamond/own_errors.h"

namespace lode::diamond {

/// Finds the own errors of all nodes of levels >= 1, and level 0's nested attributes where `leaf`
/// is given, brick by brick. Each brick sees its samples and one layer round them, and the corners
/// of coarser cubes; the largest over bricks is the answer, whatever the order.
template <int D, typename C>
class ErrorPass {
 public:
  ErrorPass(const Model<D>& model, const OwnErrors& own, NodeLevel* leaf)
      : model_(model), own_(own), slack_(rounding_slack<D>(model)), coarse_(model, slack_, own) {
    if (leaf != nullptr) leaf_.emplace(model, slack_, *leaf);
    values_.resize(kLeafValues<D>);
  }

  void run_brick(const Index<D>& brick) {
    gather_values<D>(model_, brick, 1, values_.data());
    if (leaf_) leaf_->run_brick(brick, values_.data());
    if (model_.shape.n_levels == 1) return;
    brick_errors_.clear();
    for (std::size_t batch = 0; batch < as_size(kPlansPerBrick<D>) / kLanes; ++batch) {
      if (!gather_lanes(brick, batch)) continue;
      node_errors(batch);
      for (int level = kPlanLevel<D> + 1; level < model_.shape.n_levels; ++level)
        coarse_.run(level, cubes_, is_used_, samples_, gaps_);
    }
    brick_errors_.merge(model_.shape, brick, slack_, own_);
  }

 private:
  static CanonicalCube<D> cube_of(const Index<D>& brick, std::size_t number) {
    const Index<D> per_edge = all_equal<D>(kBrickEdge<D> / kPlanEdge<D>);
    return CanonicalCube<D>(brick * kBrickEdge<D> + point_of<D>(per_edge, number) * kPlanEdge<D>,
                            kPlanEdge<D>);
  }

  /// Per batch of cubes, the place in BrickErrors of every region of every node pass, per lane: the
  /// same for every brick, because a brick is itself a cube of the hierarchy.
  static const std::vector<std::vector<std::uint16_t>>& places() {
    static const auto kAll = [] {
      const Index<D> dims = all_equal<D>(kPlanEdge<D> + 1);
      std::vector<std::vector<std::uint16_t>> result(as_size(kPlansPerBrick<D>) / kLanes);
      for (std::size_t batch = 0; batch < result.size(); ++batch)
        for (const auto& node_pass : CubePlan<D>::instance().node_passes)
          for (const auto& region : node_pass.pass.regions)
            for (std::size_t l = 0; l < kLanes; ++l)
              result[batch].push_back(BrickErrors<D, C>::place(
                  node_pass.level,
                  cube_of({}, batch * kLanes + l).global(point_of<D>(dims, region.node))));
      return result;
    }();
    return kAll;
  }

  /// Fills the lanes with a batch of the brick's cubes; false when none of them meets the data.
  bool gather_lanes(const Index<D>& brick, std::size_t batch) {
    bool is_any = false;
    bool is_whole = true;
    for (std::size_t l = 0; l < kLanes; ++l) {
      cubes_[l] = cube_of(brick, batch * kLanes + l);
      const Index<D> lower = cubes_[l].lowest_corner();
      is_used_[l] = true;
      for (std::size_t i = 0; i < as_size(D); ++i) {
        is_used_[l] = is_used_[l] && lower[i] < model_.shape.dims[i] - 1;
        is_whole = is_whole && lower[i] + kPlanEdge<D> < model_.shape.dims[i];
      }
      is_any = is_any || is_used_[l];
    }
    if (!is_any) return false;
    vertices_.resize(kPlanPoints<D> * kLanes);
    scratch_.resize(kPlanPoints<D> * kLanes);
    copy_rows(batch);
    samples_ = vertices_.data();
    if (!is_whole) mask_beyond_data();
    gaps_ = model_.has_holes() ? Gaps::holes : is_whole ? Gaps::none : Gaps::beyond_data;
    return true;
  }

  /// The points of all lanes side by side. Rows of mirrored cubes run backwards.
  void copy_rows(std::size_t batch) {
    Index<D> rows = all_equal<D>(kPlanEdge<D> + 1);
    rows[0] = 1;
    std::array<const C*, kLanes> origin;
    std::array<std::array<std::ptrdiff_t, as_size(D)>, kLanes> step;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const CanonicalCube<D> cube = cube_of({}, batch * kLanes + l);
      origin[l] = values_.data();
      for (std::size_t i = 0; i < as_size(D); ++i) {
        const auto stride =
            static_cast<std::ptrdiff_t>(power(as_size(kLeafEdge<D>), static_cast<int>(i)));
        origin[l] += (cube.even_corner[i] + 1) * stride;
        step[l][i] = cube.sign[i] * stride;
      }
    }
    C* row = vertices_.data();
    for (std::size_t r = 0; r < n_points<D>(rows); ++r, row += (kPlanEdge<D> + 1) * kLanes) {
      const Index<D> u = point_of<D>(rows, r);
      for (std::size_t l = 0; l < kLanes; ++l) {
        const C* from = origin[l];
        for (std::size_t i = 1; i < as_size(D); ++i) from += u[i] * step[l][i];
        C* to = row + l;
        for (std::int32_t x = 0; x <= kPlanEdge<D>; ++x, to += kLanes, from += step[l][0])
          *to = *from;
      }
    }
  }

  /// Points beyond the data do not count as samples.
  void mask_beyond_data() {
    masked_ = vertices_;
    samples_ = masked_.data();
    for (std::size_t l = 0; l < kLanes; ++l) {
      const LatticeBox<D> inside = part_in_data(cubes_[l]);
      if (inside.lower == Index<D>{} && inside.upper == all_equal<D>(kPlanEdge<D> + 1)) continue;
      Index<D> rows = all_equal<D>(kPlanEdge<D> + 1);
      rows[0] = 1;
      C* row = masked_.data() + l;
      for (std::size_t r = 0; r < n_points<D>(rows); ++r, row += (kPlanEdge<D> + 1) * kLanes) {
        const Index<D> u = point_of<D>(rows, r);
        bool is_inside = true;
        for (std::size_t i = 1; i < as_size(D); ++i)
          is_inside = is_inside && u[i] >= inside.lower[i] && u[i] < inside.upper[i];
        const std::int32_t begin = is_inside ? inside.lower[0] : 0;
        const std::int32_t end = is_inside ? inside.upper[0] : 0;
        for (std::int32_t x = 0; x <= kPlanEdge<D>; ++x)
          if (x < begin || x >= end) row[as_size(x) * kLanes] = std::numeric_limits<C>::quiet_NaN();
      }
    }
  }

  /// The points of a cube that are samples: lower <= u < upper, in its coordinates.
  [[nodiscard]] LatticeBox<D> part_in_data(const CanonicalCube<D>& cube) const {
    LatticeBox<D> part{{}, all_equal<D>(kPlanEdge<D> + 1)};
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t beyond = model_.shape.dims[i] - cube.even_corner[i];  // first one, as u
      if (cube.sign[i] > 0)
        part.upper[i] = std::clamp(beyond, 0, kPlanEdge<D> + 1);
      else
        part.lower[i] = std::clamp(1 - beyond, 0, kPlanEdge<D> + 1);
    }
    return part;
  }

  void node_errors(std::size_t batch) {
    const std::uint16_t* place = places()[batch].data();
    for (const auto& node_pass : CubePlan<D>::instance().node_passes) {
      const std::size_t n_regions = node_pass.pass.regions.size();
      if (node_pass.level < model_.shape.n_levels) {
        errors_.resize(n_regions * kLanes);
        run_interpolant(node_pass.pass, {samples_, vertices_.data(), scratch_.data()}, gaps_,
                        errors_.data());
        for (std::size_t r = 0; r < n_regions; ++r)
          for (std::size_t l = 0; l < kLanes; ++l)
            if (is_used_[l]) brick_errors_.raise(place[r * kLanes + l], errors_[r * kLanes + l]);
      }
      place += n_regions * kLanes;
    }
  }

  const Model<D>& model_;
  const OwnErrors& own_;
  double slack_;
  std::optional<LeafPass<D, C>> leaf_;
  CoarsePass<D, C> coarse_;
  BrickErrors<D, C> brick_errors_;
  std::array<CanonicalCube<D>, kLanes> cubes_;
  std::array<bool, kLanes> is_used_{};
  std::vector<C> values_;  ///< The brick's samples with one layer round them.
  AlignedVector<C> vertices_, masked_, scratch_, errors_;
  const C* samples_ = nullptr;  ///< vertices_, or masked_ where points lie beyond the data.
  Gaps gaps_ = Gaps::none;
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

/// Finds the own errors of all nodes of levels >= 1. Where `leaf` is given, level 0's nested
/// attributes are put there.
template <int D, typename C>
[[nodiscard]] Result<void> find_own_errors(const Model<D>& model, const OwnErrors& own,
                                           NodeLevel* leaf, Threads threads, Progress& progress) {
  std::vector<std::unique_ptr<ErrorPass<D, C>>> passes(as_size(n_workers(threads)));
  std::atomic<std::size_t> n_done{0};
  parallel_for(model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C>>(model, own, leaf);
    pass->run_brick(point_of<D>(model.brick_dims, i));
    progress.report("errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

}  // namespace lode::diamond
