#include "lode/models/diamond/part_builder.h"

#include <atomic>

#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/encode_blocks.h"
#include "lode/models/diamond/error_pass.h"
#include "lode/models/diamond/nesting_pass.h"
#include "lode/models/diamond/world_pass.h"

namespace lode::diamond {

template <int D>
PartPlan<D> PartPlan<D>::of(const Shape<D>& shape, const LatticeBox<D>& chunks) {
  PartPlan plan;
  plan.chunks = chunks;
  const LatticeBox<D> core = samples_of_chunks<D>(shape, chunks);
  for (std::size_t i = 0; i < as_size(D); ++i) {
    const bool is_first = core.lower[i] == 0;
    const bool is_last = core.upper[i] == shape.dims[i];
    // Cubes of the plan lie in the part as in the field.
    plan.part.origin[i] = is_first ? 0 : core.lower[i] - kBrickEdge<D>;
    plan.samples.lower[i] = is_first ? 0 : core.lower[i] - kPlanEdge<D>;
    const std::int32_t layer = i == kLastAxis<D> ? kBrickEdge<D> : kPlanEdge<D>;
    plan.samples.upper[i] =
        is_last ? shape.dims[i] : std::min(shape.dims[i], core.upper[i] + layer + 1);
    plan.dims[i] = plan.samples.upper[i] - plan.part.origin[i];
  }
  plan.part.core = {core.lower - plan.part.origin, core.upper - plan.part.origin};
  plan.part.samples = {plan.samples.lower - plan.part.origin, plan.dims};
  plan.part.shares = plan.part.core;
  plan.part.shares.upper[kLastAxis<D>] = plan.dims[kLastAxis<D>];
  return plan;
}

/// The first part, one between others, and the last differ in their border layers.
template <int D>
PartPlan<D> PartPlan<D>::largest(const Shape<D>& shape, std::int32_t chunks_per_part) {
  const Index<D> n = chunk_counts<D>(shape);
  PartPlan largest;
  for (std::size_t i = 0; i < as_size(D); ++i) {
    const std::int32_t step = i == 0 ? chunks_per_part : 1;
    for (const std::int32_t first : {0, step, (n[i] - 1) / step * step}) {
      if (first >= n[i]) continue;
      LatticeBox<D> chunks{{}, all_equal<D>(1)};
      chunks.lower[i] = first;
      chunks.upper[i] = std::min(first + step, n[i]);
      largest.dims[i] = std::max(largest.dims[i], PartPlan::of(shape, chunks).dims[i]);
    }
  }
  return largest;
}

template <int D>
std::uint64_t PartPlan<D>::n_bytes(std::size_t sample_size) const {
  const Shape<D> shape = Shape<D>::of(dims);
  std::uint64_t n_bricks = 1;
  for (const std::int32_t n : dims.v)
    n_bricks *= static_cast<std::uint64_t>((n + kBrickEdge<D> - 1) / kBrickEdge<D>);
  std::uint64_t bytes = n_bricks * kBrickSize<D> * sample_size;
  constexpr std::uint64_t kNodeBytes = sizeof(ErrorCode) + 2 * sizeof(float) + sizeof(WorldCode);
  for (int level = 0; level <= kPlanLevel<D>; ++level)
    bytes += n_points<D>(shape.attribute_dims(level)) *
             (level <= kChunkLevel ? kNodeBytes : sizeof(ErrorCode));
  for (int level = 1; level <= kChunkLevel; ++level)
    bytes +=
        sizeof(ErrorCode) * n_overlap_nodes<D>(shape, level, n_points<D>(shape.grid_dims(level)));
  return bytes;
}

template <int D>
void PartBuilder<D>::reserve(const Index<D>& dims) {
  const Shape<D> shape = Shape<D>::of(dims);
  std::size_t n_bricks = 1;
  for (const std::int32_t n : brick_counts<D>(shape).v) n_bricks *= as_size(n);
  // Samples before those of a part are read, but what they give is not used.
  fill_anew(model_.samples, n_bricks * kBrickSize<D> * field_.sample_size(), std::byte{}, threads_);
  model_.levels.resize(as_size(std::min(field_.shape.n_levels, kChunkLevel + 1)));
  model_.worlds.resize(model_.levels.size());
  for (std::size_t level = 0; level < model_.levels.size(); ++level) {
    const std::size_t n = n_points<D>(shape.attribute_dims(static_cast<int>(level)));
    NodeLevel& nodes = model_.levels[level];
    model_.worlds[level].reserve(n);
    nodes.error.reserve(n);
    nodes.low.reserve(n);
    nodes.high.reserve(n);
  }
}

/// Whether a part's chunks begin where those of another end, along the last axis.
template <int D>
bool is_next(const LatticeBox<D>& chunks, const LatticeBox<D>& before) {
  LatticeBox<D> moved = before;
  moved.lower[kLastAxis<D>] = before.upper[kLastAxis<D>];
  moved.upper[kLastAxis<D>] = chunks.upper[kLastAxis<D>];
  return chunks.lower == moved.lower && chunks.upper == moved.upper;
}

/// What the model holds of the part before, where that ends where this one begins.
template <int D>
void PartBuilder<D>::take_over(const PartPlan<D>& plan) {
  n_taken_over_ = 0;
  if (is_found_ && is_next<D>(plan.chunks, plan_.chunks)) {
    const std::int32_t first = plan.part.origin[kLastAxis<D>] - plan_.part.origin[kLastAxis<D>];
    move_overlap<D>(model_, overlap_, first / kBrickEdge<D>, plan.dims);
    n_taken_over_ = kOverlapBricks;
  }
  is_found_ = false;
}

template <int D>
LatticeBox<D> PartBuilder<D>::missing_samples() const {
  LatticeBox<D> box = plan_.samples;
  if (n_taken_over_ == 0) return box;
  const std::size_t last = kLastAxis<D>;
  const std::int32_t first = plan_.part.origin[last] + n_taken_over_ * kBrickEdge<D>;
  // Bricks share that layer of samples.
  box.lower[last] = first + 1 < box.upper[last] ? first : box.upper[last];
  return box;
}

template <int D>
void PartBuilder<D>::begin(const PartPlan<D>& plan) {
  take_over(plan);
  plan_ = plan;
  VolumeInfo info = field_.info;
  for (std::size_t i = 0; i < as_size(D); ++i)
    info.grid.dims[as_size(field_.axes.axis[i])] = plan.dims[i];
  model_.reset(info);
  model_.stats = field_.stats;
  model_.levels.resize(as_size(std::min(field_.shape.n_levels, kChunkLevel + 1)));
  model_.worlds.resize(model_.levels.size());
  for (int level = 0; level < static_cast<int>(model_.levels.size()); ++level) {
    const std::size_t n = n_points<D>(model_.shape.attribute_dims(level));
    NodeLevel& nodes = model_.levels[as_size(level)];
    const std::size_t n_known = n_taken_over_ > 0 ? n_overlap_nodes<D>(model_.shape, level, n) : 0;
    fill_anew(nodes.error, n_known, n, ErrorCode{0}, threads_);
    resize_anew(nodes.low, n);
    resize_anew(nodes.high, n);
    if (level == 0)
      resize_anew(model_.worlds[0], n);
    else
      fill_anew(model_.worlds[as_size(level)], n, WorldCode{0}, threads_);
  }
  coarse_.resize(as_size(std::max(0, n_own_levels() - kKeptLevel)));
  for (std::size_t i = 0; i < coarse_.size(); ++i)
    fill_anew(coarse_[i], n_points<D>(model_.shape.grid_dims(kKeptLevel + static_cast<int>(i))),
              ErrorCode{0}, threads_);
  largest_.resize(model_.levels.size());
}

/// Levels, from 0, whose own errors bricks find by themselves.
template <int D>
int PartBuilder<D>::n_own_levels() const {
  return std::min(field_.shape.n_levels, kPlanLevel<D> + 1);
}

template <int D>
void PartBuilder<D>::put_samples(const LatticeBox<D>& box, const std::byte* values) {
  const LatticeBox<D> local{box.lower - plan_.part.origin, box.upper - plan_.part.origin};
  diamond::put_samples<D>(model_, local, values, threads_);
}

template <int D>
Result<void> PartBuilder<D>::find_attributes(const Progress& progress,
                                             const std::function<void()>& brick_done) {
  fill_beyond_data<D>(model_, threads_);
  const auto found = visit_held_type<D>(
      field_, [&]<typename V>() { return find_own_errors<V>(progress, brick_done); });
  if (!found) return found.error();
  give_own_errors();
  nest();
  give_cubes();
  round_ranges<D, Model<D>>(model_, model_.levels, 1, threads_);
  find_largest();
  is_found_ = true;
  return {};
}

template <int D>
template <typename V>
Result<void> PartBuilder<D>::find_own_errors(const Progress& progress,
                                             const std::function<void()>& brick_done) {
  ErrorTask<D, CoarseField<D>> task{model_,
                                    plan_.part,
                                    OwnErrors(as_size(n_own_levels())),
                                    &model_.levels[0],
                                    field_,
                                    {},
                                    n_taken_over_,
                                    &model_.worlds[0]};
  for (std::size_t level = 1; level < task.own.size(); ++level)
    task.own[level] = level < as_size(kKeptLevel) ? std::span(model_.levels[level].error)
                                                  : std::span(coarse_[level - kKeptLevel]);
  for (NodeLevel& nodes : field_.levels) task.coarse.emplace_back(nodes.error);
  return diamond::find_own_errors<V>(task, threads_, progress, brick_done);
}

/// Of nodes that the field has kept: other parts may have larger ones.
template <int D>
void PartBuilder<D>::give_own_errors() {
  for (std::size_t i = 0; i < coarse_.size(); ++i) {
    const int level = kKeptLevel + static_cast<int>(i);
    const UninitializedArray<ErrorCode>& own = coarse_[i];
    const Index<D> from = model_.shape.grid_dims(level);
    const Index<D> to = field_.shape.grid_dims(level);
    UninitializedArray<ErrorCode>& errors = field_.levels[as_size(level)].error;
    for (std::size_t at = 0; at < own.size(); ++at) {
      if (own[at] == 0) continue;
      Index<D> q = point_of<D>(from, at);
      bool exists = true;
      for (std::size_t a = 0; a < as_size(D); ++a) {
        q[a] += plan_.part.origin[a] >> level;
        exists = exists && q[a] < to[a];
      }
      if (!exists) continue;
      const std::size_t place = linear_index<D>(to, q);
      raise_to(errors[place], own[at]);
      if (level == kKeptLevel) raise_to(field_.finest_own[place], own[at]);
    }
  }
}

/// Errors are own ones before, and what the next part takes of them is kept.
template <int D>
void PartBuilder<D>::nest() {
  const std::int32_t end = plan_.part.core.upper[kLastAxis<D>];
  if (end < plan_.dims[kLastAxis<D>]) keep_overlap<D>(model_, end / kBrickEdge<D> - 1, overlap_);
  find_worlds();
  const int n_levels = static_cast<int>(model_.levels.size());
  NestingPass<D, Model<D>>(model_, 1, n_levels, threads_).run();
}

template <int D>
void PartBuilder<D>::find_worlds() {
  const int n_levels = static_cast<int>(model_.levels.size());
  for (int level = 1; level < n_levels; ++level)
    visit_held_type<D>(field_, [&]<typename V>() {
      raise_to_own_worlds<D, typename SampleScale<D, V>::C>(
          model_, level, model_.levels[as_size(level)].error, rounding_slack<D>(field_), threads_,
          model_.worlds[as_size(level)]);
    });
  nest_worlds<D>(model_.shape, 1, n_levels, threads_, model_.worlds);
}

template <int D>
bool PartBuilder<D>::is_in_core(const Index<D>& p) const {
  for (std::size_t i = 0; i < as_size(D); ++i)
    if (p[i] < plan_.part.core.lower[i] || p[i] >= plan_.part.core.upper[i]) return false;
  return true;
}

/// Cubes of the coarsest level of the part are joined with the nodes that the field has kept.
template <int D>
void PartBuilder<D>::give_cubes() {
  if (!field_.is_needed()) return;
  const Index<D> dims = model_.shape.grid_dims(kChunkLevel);
  Index<D> cubes;
  for (std::size_t i = 0; i < as_size(D); ++i) cubes[i] = dims[i] / 2;
  for (std::size_t i = 0; i < n_points<D>(cubes); ++i) {
    const Index<D> q = point_of<D>(cubes, i) * 2 + all_equal<D>(1);
    Index<D> lowest = q;  // lattice points of the cube, at its lowest corner
    for (std::int32_t& x : lowest.v) x = (x - 1) << kChunkLevel;
    if (is_in_core(lowest)) give_cube(q, linear_index<D>(dims, q));
  }
}

/// To those nodes round it that have one odd coordinate: they are its parents.
template <int D>
void PartBuilder<D>::give_cube(const Index<D>& q, std::size_t at) {
  const NodeLevel& from = model_.levels[as_size(kChunkLevel)];
  const Index<D> dims = field_.shape.grid_dims(kKeptLevel);
  NodeLevel& to = field_.levels[as_size(kKeptLevel)];
  for (int corner = 0; corner < (1 << D); ++corner) {
    Index<D> parent;
    int n_odd = 0;
    bool exists = true;
    for (int i = 0; i < D; ++i) {
      const std::size_t a = as_size(i);
      parent[a] = (q[a] - 1) / 2 + ((corner >> i) & 1) + (plan_.part.origin[a] >> kKeptLevel);
      n_odd += parent[a] & 1;
      exists = exists && parent[a] < dims[a];
    }
    if (n_odd != 1 || !exists) continue;
    const std::size_t place = linear_index<D>(dims, parent);
    to.error[place] = std::max(to.error[place], from.error[at]);
    to.low[place] = std::min(to.low[place], from.low[at]);
    to.high[place] = std::max(to.high[place], from.high[at]);
    WorldCode& world = field_.worlds[as_size(kKeptLevel)][place];
    world = std::max(world, one_level_up(model_.worlds[as_size(kChunkLevel)][at]));
  }
}

template <int D>
void PartBuilder<D>::find_largest() {
  for (int level = 0; level < static_cast<int>(model_.levels.size()); ++level) {
    const UninitializedArray<ErrorCode>& errors = model_.levels[as_size(level)].error;
    ErrorCode& largest = largest_[as_size(level)];
    for_each_piece(errors.size(), threads_, [&](std::size_t first, std::size_t end) {
      ErrorCode here = 0;
      for (std::size_t at = first; at < end; ++at) here = std::max(here, errors[at]);
      if (here > std::atomic_ref(largest).load(std::memory_order_relaxed))
        raise_to(largest, largest_in_core(level, first, end));
    });
  }
}

/// Of the nodes at first .. end - 1 of a level's array.
template <int D>
ErrorCode PartBuilder<D>::largest_in_core(int level, std::size_t first, std::size_t end) const {
  const Index<D> dims = model_.shape.attribute_dims(level);
  const int step = std::max(level, 1);
  const UninitializedArray<ErrorCode>& errors = model_.levels[as_size(level)].error;
  ErrorCode largest = 0;
  for (std::size_t at = first; at < end; ++at) {
    if (errors[at] <= largest) continue;
    Index<D> p = point_of<D>(dims, at);
    for (std::size_t i = 0; i < as_size(D); ++i)  // nodes beyond the data are the last chunk's
      p[i] = std::min(p[i] << step, std::max(plan_.dims[i] - 1, 0));
    if (is_in_core(p)) largest = errors[at];
  }
  return largest;
}

template <int D>
Result<void> PartBuilder<D>::append_chunk(const Index<D>& chunk, store::Writer& writer,
                                          const Progress& progress) const {
  const std::vector<BlockGroup<D>> groups = chunk_blocks<D>(field_.shape, chunk);
  return append_groups<D>(model_, model_.worlds, plan_.part.origin,
                          std::span<const BlockGroup<D>>(groups), writer, threads_, progress);
}

template struct PartPlan<2>;
template struct PartPlan<3>;
template class PartBuilder<2>;
template class PartBuilder<3>;

}  // namespace lode::diamond
