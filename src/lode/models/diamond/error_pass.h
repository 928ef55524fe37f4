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

/// What own errors of a model are found from, and where they go.
template <int D, typename Field>
struct ErrorTask {
  const Model<D>& model;  ///< A part of the field, or all of it.
  Part<D> part;
  OwnErrors own;              ///< Of the model's nodes, up to level kPlanLevel.
  NodeLevel* leaf = nullptr;  ///< Where level 0's nested attributes go; null: they do not.
  const Field& field;  ///< The whole one; of it only samples of levels above kPlanLevel are asked,
  OwnErrors coarse;    ///< whose errors go here: of the whole field's nodes.
  /// So many layers of bricks along the last axis have their errors already; all but the last of
  /// them have level 0's attributes too.
  std::int32_t n_known_layers = 0;
};

/// Finds the own errors of all nodes of levels >= 1, and level 0's nested attributes, brick by
/// brick. Each brick sees its samples and one layer round them, and the corners of coarser cubes;
/// the largest over bricks is the answer, whatever the order, and however the field is parted.
template <int D, typename C, typename Field>
class ErrorPass {
 public:
  explicit ErrorPass(const ErrorTask<D, Field>& task)
      : model_(task.model),
        part_(task.part),
        own_(task.own),
        n_known_layers_(task.n_known_layers),
        slack_(rounding_slack<D>(model_)),
        coarse_(task.field, slack_, task.coarse) {
    if (task.leaf != nullptr) leaf_.emplace(model_, slack_, *task.leaf);
    values_.resize(kLeafValues<D>);
  }

  void run_brick(const Index<D>& brick) {
    const std::int32_t layer = brick[as_size(D - 1)];
    if (layer + 1 < n_known_layers_) return;
    gather_values<D>(model_, brick, 1, values_.data());
    range_of(values_.data(), power(as_size(kLeafEdge<D>), D), low_, high_);
    const bool is_constant = low_ == high_ && !model_.has_holes() && is_whole(brick);
    if (leaf_ && is_constant)
      leaf_->run_constant_brick(brick, low_);
    else if (leaf_)
      leaf_->run_brick(brick, values_.data());
    if (own_.size() == 1 || layer < n_known_layers_) return;
    find_levels(brick);
    if (is_constant) {
      brick_errors_.clear_to_zero();
      brick_errors_.merge(model_.shape, brick, slack_, own_);
      if (levels_.empty()) return;
    }
    brick_errors_.clear();
    for (std::size_t batch = 0; batch < as_size(kPlansPerBrick<D>) / kLanes; ++batch) {
      if (!gather_lanes(brick, batch)) continue;
      if (!is_constant) node_errors(batch);
      if (!keep_shares()) continue;
      for (const int level : levels_) coarse_.run(level, cubes_, is_used_, samples_, gaps_);
    }
    if (is_constant) return;
    brick_errors_.merge(model_.shape, brick, slack_, own_);
  }

 private:
  /// Whether all of the brick is samples of the part.
  [[nodiscard]] bool is_whole(const Index<D>& brick) const {
    for (std::size_t i = 0; i < as_size(D); ++i) {
      const std::int32_t lower = brick[i] * kBrickEdge<D>;
      if (lower < part_.samples.lower[i] || lower + kBrickEdge<D> >= model_.shape.dims[i])
        return false;
    }
    return true;
  }

  /// The coarse levels whose errors the brick's samples may raise.
  void find_levels(const Index<D>& brick) {
    levels_.clear();
    const CanonicalCube<D> cube(brick * kBrickEdge<D> + part_.origin, kBrickEdge<D>);
    for (int level = kPlanLevel<D> + 1; level < coarse_.n_levels(); ++level) {
      // In a cube as large as the brick F' is not linear on the brick's simplices.
      const bool is_inside = std::int32_t{2} << level > kBrickEdge<D>;
      if (model_.has_holes() || !is_inside || coarse_.can_raise(level, cube, low_, high_))
        levels_.push_back(level);
    }
  }

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
        is_used_[l] = is_used_[l] && lower[i] >= part_.samples.lower[i] &&
                      lower[i] < std::min(part_.samples.upper[i], model_.shape.dims[i] - 1);
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

  /// Leaves only cubes that no other part looks at, and takes them to the whole field's lattice;
  /// false when there is none.
  bool keep_shares() {
    bool is_any = false;
    for (std::size_t l = 0; l < kLanes; ++l) {
      const Index<D> lower = cubes_[l].lowest_corner();
      for (std::size_t i = 0; i < as_size(D); ++i)
        is_used_[l] =
            is_used_[l] && lower[i] >= part_.shares.lower[i] && lower[i] < part_.shares.upper[i];
      cubes_[l] = CanonicalCube<D>(lower + part_.origin, kPlanEdge<D>);
      is_any = is_any || is_used_[l];
    }
    return is_any;
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
      if (as_size(node_pass.level) < own_.size()) {
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
  const Part<D>& part_;
  const OwnErrors& own_;
  std::int32_t n_known_layers_;
  double slack_;
  std::optional<LeafPass<D, C>> leaf_;
  CoarsePass<D, C, Field> coarse_;
  BrickErrors<D, C> brick_errors_;
  std::array<CanonicalCube<D>, kLanes> cubes_;
  std::array<bool, kLanes> is_used_{};
  C low_ = 0;  ///< Of values_, where it has no holes,
  C high_ = 0;
  std::vector<int> levels_;  ///< of coarse nodes that these can raise.
  std::vector<C> values_;    ///< The brick's samples with one layer round them.
  AlignedVector<C> vertices_, masked_, scratch_, errors_;
  const C* samples_ = nullptr;  ///< vertices_, or masked_ where points lie beyond the data.
  Gaps gaps_ = Gaps::none;
};

/// Whether float32 holds every interpolant exactly: multiples of 1/root side below the largest
/// value's magnitude.
template <int D, typename Field>
[[nodiscard]] bool is_exact_in_float(const LatticeField<D, Field>& field) {
  if (is_floating(field.storage)) return false;
  const double largest = std::max(std::abs(field.stats.min), std::abs(field.stats.max));
  const int bits = static_cast<int>(std::ceil(std::log2(largest + 1))) + 1;
  return bits + field.shape.n_levels <= 24;
}

/// Runs the pass over all bricks of the model; brick_done() is called after each, by any thread.
template <typename C, int D, typename Field, typename BrickDone>
[[nodiscard]] Result<void> find_own_errors(const ErrorTask<D, Field>& task, Threads threads,
                                           const Progress& progress, const BrickDone& brick_done) {
  std::vector<std::unique_ptr<ErrorPass<D, C, Field>>> passes(as_size(n_workers(threads)));
  parallel_for(task.model.n_bricks(), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, C, Field>>(task);
    pass->run_brick(point_of<D>(task.model.brick_dims, i));
    brick_done();
  });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

/// Finds the own errors of all nodes of levels >= 1. Where `leaf` is given, level 0's nested
/// attributes are put there.
template <int D, typename C>
[[nodiscard]] Result<void> find_own_errors(const Model<D>& model, const OwnErrors& own,
                                           NodeLevel* leaf, Threads threads, Progress& progress) {
  const ErrorTask<D, Model<D>> task{model, Part<D>::whole(model.shape), own, leaf, model, own};
  std::atomic<std::size_t> n_done{0};
  return find_own_errors<C>(task, threads, progress, [&] {
    progress.report("errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
}

}  // namespace lode::diamond
