#pragma once

#include <optional>
#include <vector>

#include "lode/core/parallel.h"
#include "lode/models/diamond/leaf_rows.h"
#include "lode/models/diamond/model.h"
#include "lode/models/diamond/sample_scale.h"
#include "lode/models/diamond/world_block.h"

namespace lode::diamond {

/// Cubes of side 2 along a brick's edge.
template <int D>
inline constexpr std::int32_t kLeafCubes = kBrickEdge<D> / 2;
/// Edge of the array of a brick's samples with one layer round them: local coordinate p is at p
/// + 1.
template <int D>
inline constexpr std::int32_t kLeafEdge = kBrickSamples<D> + 2;
/// Its elements.
template <int D>
inline constexpr std::size_t kLeafValues = power(as_size(kLeafEdge<D>), D) + kRowPadding;

/// Finds the nested attributes of the tier-0 nodes of level 0, brick by brick, and stores them in
/// `out` (the model's level 0). Errors are largest at midpoints of edges, because at this level
/// every sample is one; `slack` is added to each (0 where V is not double, which must hold all
/// values and range ends exactly). They are infinite where holes meet present cells. One thread.
template <int D, typename V>
class LeafPass {
 public:
  /// `worlds`: where the nested world errors of the same nodes go; null: they are not found.
  LeafPass(const Model<D>& model, double slack, NodeLevel& out,
           UninitializedArray<WorldCode>* worlds = nullptr);

  /// `values`: kLeafValues; the brick's samples with a margin of one layer (see gather_values;
  /// holes are NaN).
  void run_brick(const Index<D>& brick, const V* values, bool has_holes);
  /// The same where all samples are equal, or all holes (lowest > highest), also in the margin.
  void run_uniform_brick(const Index<D>& brick, V lowest, V highest);

 private:
  using C = typename SampleScale<D, V>::C;

  void find_worlds(const Index<D>& brick, const V* values);

  const Model<D>& model_;
  double slack_;
  NodeLevel& out_;
  UninitializedArray<WorldCode>* worlds_;
  std::optional<WorldBlock<D, C>> world_block_;
  std::vector<V> midpoint_;  ///< Scratch: one error a sample.
};

/// How many of a brick's values and those round it are holes.
template <int D, typename V>
[[nodiscard]] std::size_t count_holes(const V* values) {
  if constexpr (!std::is_floating_point_v<V>) return 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < power(as_size(kLeafEdge<D>), D); ++i) n += values[i] != values[i];
  return n;
}

/// Runs the pass over n bricks into the model's level 0: brick_at(i) names them, and
/// gather(brick, values) gives each one's values.
template <typename V, int D, typename BrickAt, typename Gather>
void find_leaf_attributes(Model<D>& model, std::size_t n, Threads threads, const BrickAt& brick_at,
                          const Gather& gather) {
  struct Worker {
    LeafPass<D, V> pass;
    std::vector<V> values;
  };
  std::vector<std::optional<Worker>> workers(as_size(n_workers(threads)));
  parallel_for(n, threads, 1, [&](std::size_t i, int number) {
    std::optional<Worker>& worker = workers[as_size(number)];
    if (!worker)
      worker.emplace(Worker{{model, rounding_slack<D>(model), model.levels[0]},
                            std::vector<V>(kLeafValues<D>)});
    const Index<D> brick = brick_at(i);
    gather(brick, worker->values.data());
    const V* values = worker->values.data();
    const bool has_holes = model.has_holes() && count_holes<D>(values) > 0;
    worker->pass.run_brick(brick, values, has_holes);
  });
}

extern template class LeafPass<2, Step>;
extern template class LeafPass<3, Step>;
extern template class LeafPass<2, float>;
extern template class LeafPass<3, float>;
extern template class LeafPass<2, double>;
extern template class LeafPass<3, double>;

}  // namespace lode::diamond
