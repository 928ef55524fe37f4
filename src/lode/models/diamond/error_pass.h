#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/coarse_pass.h"
#include "lode/models/diamond/cube_lanes.h"

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
  /// Where level 0's nested world errors go, beside `leaf`.
  UninitializedArray<WorldCode>* leaf_worlds = nullptr;
};

/// Finds the own errors of all nodes of levels >= 1, and level 0's nested attributes, brick by
/// brick. Each brick sees its samples and one layer round them, and the corners of coarser cubes;
/// the largest over bricks is the answer, whatever the order, and however the field is parted.
/// Samples are held in V.
template <int D, typename V, typename Field>
class ErrorPass {
 public:
  using C = typename SampleScale<D, V>::C;

  explicit ErrorPass(const ErrorTask<D, Field>& task)
      : model_(task.model),
        part_(task.part),
        own_(task.own),
        n_known_layers_(task.n_known_layers),
        scale_(model_),
        slack_(rounding_slack<D>(model_)),
        coarse_(task.field, slack_, task.coarse),
        lanes_(model_.shape, part_) {
    if (task.leaf != nullptr) leaf_.emplace(model_, slack_, *task.leaf, task.leaf_worlds);
    for (BrickState& brick : bricks_) brick.values.resize(kLeafValues<D>);
  }

  /// Up to kBricksOf<D, V> bricks, from `first` on in x.
  void run(const Index<D>& first) {
    const std::int32_t layer = first[as_size(D - 1)];
    if (layer + 1 < n_known_layers_) return;
    n_bricks_ = std::min(bricks_.size(), as_size(model_.brick_dims[0] - first[0]));
    bool is_needed = false;
    for (std::size_t i = 0; i < n_bricks_; ++i) {
      BrickState& brick = bricks_[i];
      brick.position = first;
      brick.position[0] += static_cast<std::int32_t>(i);
      open(brick);
      if (own_.size() == 1 || layer < n_known_layers_) continue;
      begin_errors(brick);
      is_needed = is_needed || !brick.is_uniform || !brick.levels.empty();
    }
    if (is_needed) find_errors(first);
  }

 private:
  struct BrickState {
    Index<D> position;
    std::vector<V> values;  ///< Its samples with one layer round them.
    bool has_holes = false;
    bool is_uniform = false;  ///< All of them are equal, or holes.
    C low = 0;                ///< Of them, where there are no holes,
    C high = 0;
    std::vector<int> levels;  ///< of coarse nodes that these can raise.
    BrickErrors<D, C> errors;
  };

  /// Gathers a brick's samples and finds level 0's attributes.
  void open(BrickState& brick) {
    gather_values<D>(model_, brick.position, 1, brick.values.data());
    const std::size_t n_values = power(as_size(kLeafEdge<D>), D);
    const std::size_t n_holes = model_.has_holes() ? count_holes<D>(brick.values.data()) : 0;
    V low{};
    V high{};
    if constexpr (std::is_floating_point_v<V>) {  // of nothing but holes; steps are never holes
      low = std::numeric_limits<V>::infinity();
      high = -low;
    }
    if (n_holes == 0) range_of(brick.values.data(), n_values, low, high);
    brick.has_holes = n_holes > 0;
    brick.is_uniform = (low == high || n_holes == n_values) && is_whole(brick.position);
    brick.low = scale_.value(low);
    brick.high = scale_.value(high);
    if (leaf_ && brick.is_uniform)
      leaf_->run_uniform_brick(brick.position, low, high);
    else if (leaf_)
      leaf_->run_brick(brick.position, brick.values.data(), brick.has_holes);
  }

  void begin_errors(BrickState& brick) {
    find_levels(brick);
    if (!brick.is_uniform) return brick.errors.clear();
    brick.errors.clear_to_zero();
    brick.errors.merge(model_.shape, brick.position, slack_, own_);
  }

  void find_errors(const Index<D>& first) {
    typename CubeLanes<D, V>::Values values{};
    for (std::size_t i = 0; i < n_bricks_; ++i) values[i] = bricks_[i].values.data();
    bool has_holes = false;
    for (std::size_t i = 0; i < n_bricks_; ++i) has_holes = has_holes || bricks_[i].has_holes;
    for (std::size_t batch = 0; batch < CubeLanes<D, V>::kBatches; ++batch) {
      if (!lanes_.gather(first, values, batch, has_holes)) continue;
      node_errors(batch);
      lanes_.keep_shares();
      for (std::size_t group = 0; group < CubeLanes<D, V>::kGroups; ++group)
        coarse_errors(batch, group);
    }
    for (std::size_t i = 0; i < n_bricks_; ++i)
      if (!bricks_[i].is_uniform)
        bricks_[i].errors.merge(model_.shape, bricks_[i].position, slack_, own_);
  }

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
  void find_levels(BrickState& brick) {
    brick.levels.clear();
    if (brick.is_uniform && brick.has_holes) return;
    constexpr C kUnbounded = std::numeric_limits<C>::infinity();
    const C low = brick.has_holes ? -kUnbounded : brick.low;
    const C high = brick.has_holes ? kUnbounded : brick.high;
    const CanonicalCube<D> cube(brick.position * kBrickEdge<D> + part_.origin, kBrickEdge<D>);
    for (int level = kPlanLevel<D> + 1; level < coarse_.n_levels(); ++level) {
      // In a cube as large as the brick F' is not linear on the brick's simplices.
      const bool is_inside = std::int32_t{2} << level > kBrickEdge<D>;
      if (!is_inside || coarse_.can_raise(level, cube, low, high)) brick.levels.push_back(level);
    }
  }

  /// Per batch of cubes, the place in BrickErrors of every region of every node pass, per lane: the
  /// same for every brick, because a brick is itself a cube of the hierarchy.
  static const std::vector<std::vector<std::uint16_t>>& places() {
    static const auto kAll = [] {
      const Index<D> dims = all_equal<D>(kPlanEdge<D> + 1);
      std::vector<std::vector<std::uint16_t>> result(CubeLanes<D, V>::kBatches);
      for (std::size_t batch = 0; batch < result.size(); ++batch)
        for (const auto& node_pass : CubePlan<D>::instance().node_passes)
          for (const auto& region : node_pass.pass.regions)
            for (std::size_t l = 0; l < kLanesOf<V>; ++l)
              result[batch].push_back(BrickErrors<D, C>::place(
                  node_pass.level,
                  CubeLanes<D, V>::cube_of({}, batch, l).global(point_of<D>(dims, region.node))));
      return result;
    }();
    return kAll;
  }

  void node_errors(std::size_t batch) {
    bool is_any = false;
    std::array<BrickErrors<D, C>*, kLanesOf<V>> to{};  // null: nothing to be found
    for (std::size_t l = 0; l < kLanesOf<V>; ++l) {
      if (!lanes_.is_used(l)) continue;
      BrickState& brick = bricks_[CubeLanes<D, V>::brick_of(batch, l)];
      if (!brick.is_uniform) to[l] = &brick.errors;
      is_any = is_any || !brick.is_uniform;
    }
    if (!is_any) return;
    scratch_.resize(kPlanPoints<D> * kLanesOf<V>);
    const std::uint16_t* place = places()[batch].data();
    for (const auto& node_pass : CubePlan<D>::instance().node_passes) {
      const std::size_t n_regions = node_pass.pass.regions.size();
      if (as_size(node_pass.level) < own_.size()) {
        errors_.resize(n_regions * kLanesOf<V>);
        run_interpolant(node_pass.pass, {lanes_.samples(), lanes_.vertices(), scratch_.data()},
                        lanes_.gaps(), errors_.data());
        for (std::size_t r = 0; r < n_regions * kLanesOf<V>; r += kLanesOf<V>)
          for (std::size_t l = 0; l < kLanesOf<V>; ++l)
            if (to[l] != nullptr) to[l]->raise(place[r + l], scale_.error(errors_[r + l]));
      }
      place += n_regions * kLanesOf<V>;
    }
  }

  /// Of a batch those lanes that belong to one brick.
  void coarse_errors(std::size_t batch, std::size_t group) {
    const BrickState& brick = bricks_[CubeLanes<D, V>::brick_of(batch, group * kLanes)];
    const auto& is_used = lanes_.used(group);
    if (brick.levels.empty() || std::find(is_used.begin(), is_used.end(), true) == is_used.end())
      return;
    const C* samples = lane_values(group);
    // Vertices of coarse cubes may be holes where the brick has none.
    const Gaps gaps = model_.has_holes() ? Gaps::holes : lanes_.gaps();
    for (const int level : brick.levels)
      coarse_.run(level, lanes_.cubes(group), is_used, samples, gaps);
  }

  /// Their samples, kLanes a point.
  const C* lane_values(std::size_t group) {
    if constexpr (std::is_same_v<V, C>) {
      return lanes_.samples();
    } else {
      coarse_samples_.resize(kPlanPoints<D> * kLanes);
      widen_lanes(lanes_.samples() + group * kLanes, kPlanPoints<D>, scale_.value(0),
                  scale_.error(1), coarse_samples_.data());
      return coarse_samples_.data();
    }
  }

  const Model<D>& model_;
  const Part<D>& part_;
  const OwnErrors& own_;
  std::int32_t n_known_layers_;
  SampleScale<D, V> scale_;
  double slack_;
  std::optional<LeafPass<D, V>> leaf_;
  CoarsePass<D, C, Field> coarse_;
  CubeLanes<D, V> lanes_;
  std::array<BrickState, kBricksOf<D, V>> bricks_;
  std::size_t n_bricks_ = 0;  ///< Of them there are.
  AlignedVector<V> scratch_, errors_;
  AlignedVector<C> coarse_samples_;
};

/// Runs the pass over all bricks of the model; brick_done() is called after each, by any thread.
template <typename V, int D, typename Field, typename BrickDone>
[[nodiscard]] Result<void> find_own_errors(const ErrorTask<D, Field>& task, Threads threads,
                                           const Progress& progress, const BrickDone& brick_done) {
  std::vector<std::unique_ptr<ErrorPass<D, V, Field>>> passes(as_size(n_workers(threads)));
  const auto n_together = static_cast<std::int32_t>(kBricksOf<D, V>);
  Index<D> runs = task.model.brick_dims;
  runs[0] = (runs[0] + n_together - 1) / n_together;
  parallel_for(n_points<D>(runs), threads, 1, [&](std::size_t i, int worker) {
    if (progress.is_cancelled()) return;
    auto& pass = passes[as_size(worker)];
    if (!pass) pass = std::make_unique<ErrorPass<D, V, Field>>(task);
    Index<D> first = point_of<D>(runs, i);
    first[0] *= n_together;
    pass->run(first);
    for (std::int32_t x = first[0]; x < std::min(first[0] + n_together, task.model.brick_dims[0]);
         ++x)
      brick_done();
  });
  if (progress.is_cancelled()) return cancelled_error();
  return {};
}

/// Finds the own errors of all nodes of levels >= 1. Where `leaf` is given, level 0's nested
/// attributes are put there, and its world errors where those are asked for.
template <int D, typename V>
[[nodiscard]] Result<void> find_own_errors(const Model<D>& model, const OwnErrors& own,
                                           NodeLevel* leaf,
                                           UninitializedArray<WorldCode>* leaf_worlds,
                                           Threads threads, Progress& progress) {
  const ErrorTask<D, Model<D>> task{
      model, Part<D>::whole(model.shape), own, leaf, model, own, 0, leaf_worlds};
  std::atomic<std::size_t> n_done{0};
  return find_own_errors<V>(task, threads, progress, [&] {
    progress.report("errors",
                    static_cast<double>(++n_done) / static_cast<double>(model.n_bricks()));
  });
}

}  // namespace lode::diamond
