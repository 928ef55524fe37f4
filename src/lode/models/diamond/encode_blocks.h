#pragma once

#include <vector>

#include "lode/core/progress.h"
#include "lode/models/diamond/block_order.h"
#include "lode/models/diamond/coarse_field.h"
#include "lode/store/writer.h"

namespace lode::diamond {

/// Appends the blocks of groups, in their order: samples, or the errors, lows, highs and world
/// errors of nodes; none where a group has no points; before each run of them an index. `origin` is
/// where the field's lattice begins in the one that the groups are regions of.
template <int D, typename Field>
[[nodiscard]] Result<void> append_groups(const Field& field, const WorldErrors& worlds,
                                         const Index<D>& origin,
                                         std::span<const BlockGroup<D>> groups,
                                         store::Writer& writer, Threads threads,
                                         const Progress& progress);

/// Rounds the ranges of these levels as they are stored; docs/format.md. `field` says of what
/// range.
template <int D, typename Field>
void round_ranges(const LatticeField<D, Field>& field, std::vector<NodeLevel>& levels, int first,
                  Threads threads);

}  // namespace lode::diamond
