#pragma once

#include <span>

#include "lode/core/parallel_fill.h"
#include "lode/models/diamond/own_errors.h"
#include "lode/models/diamond/world_block.h"

namespace lode::diamond {

/// Raises the world errors of a level's nodes, level >= 1, to what their own errors and the samples
/// round them say, block by block. `Field` is a LatticeField with the level's samples; `slack` has
/// been added to own errors, and those up to it are taken for rounding.
template <int D, typename C, typename Field>
void raise_to_own_worlds(const Field& field, int level, std::span<const ErrorCode> own,
                         double slack, Threads threads, UninitializedArray<WorldCode>& worlds);

/// Joins every node's world error with its children's, of the levels from `first` on to before
/// `end`. Where `first` is not 1, nodes of the lowest tier have been joined with the level below.
template <int D>
void nest_worlds(const Shape<D>& shape, int first, int end, Threads threads, WorldErrors& worlds);

/// Before any is found.
template <int D>
[[nodiscard]] WorldErrors no_worlds(const Shape<D>& shape, Threads threads) {
  WorldErrors worlds(as_size(shape.n_levels));
  for (int level = 0; level < shape.n_levels; ++level)
    fill_anew(worlds[as_size(level)], n_points<D>(shape.attribute_dims(level)), WorldCode{0},
              threads);
  return worlds;
}

/// Completes a model's, of which level 0's have been found.
template <int D, typename C>
void find_worlds(const Model<D>& model, const OwnErrors& own, Threads threads,
                 WorldErrors& worlds) {
  for (int level = 1; level < model.shape.n_levels; ++level)
    raise_to_own_worlds<D, C>(model, level, own[as_size(level)], rounding_slack<D>(model), threads,
                              worlds[as_size(level)]);
  nest_worlds<D>(model.shape, 1, model.shape.n_levels, threads, worlds);
}

}  // namespace lode::diamond
