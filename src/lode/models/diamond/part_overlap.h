#pragma once

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// The one along which a build goes from part to part, as far as it can.
template <int D>
inline constexpr std::size_t kLastAxis = as_size(D - 1);
/// Layers of bricks along the last axis that a part has in common with the next one: the last of
/// its own, and the one above it.
inline constexpr std::int32_t kOverlapBricks = 2;

/// Own errors of a part's nodes, by level from 1 on; [0] is empty.
using PartErrors = std::vector<UninitializedArray<ErrorCode>>;

/// Those in kOverlapBricks layers of bricks of a part's model, from layer `first` on, before its
/// errors are nested.
template <int D>
void keep_overlap(const Model<D>& model, std::int32_t first, PartErrors& own);

/// Moves these layers to the model's beginning, with the nested attributes of level 0's nodes, and
/// the own errors of the others that keep_overlap() has kept. Makes room for a lattice of `dims`
/// samples, which has as many as the model along all axes but the last. Nothing else is of use
/// afterwards.
template <int D>
void move_overlap(Model<D>& model, const PartErrors& own, std::int32_t first, const Index<D>& dims);

/// Elements of level `level`'s arrays that move_overlap() has put there, at most `n`.
template <int D>
[[nodiscard]] std::size_t n_overlap_nodes(const Shape<D>& shape, int level, std::size_t n);

extern template void keep_overlap<2>(const Model<2>&, std::int32_t, PartErrors&);
extern template void keep_overlap<3>(const Model<3>&, std::int32_t, PartErrors&);
extern template void move_overlap<2>(Model<2>&, const PartErrors&, std::int32_t, const Index<2>&);
extern template void move_overlap<3>(Model<3>&, const PartErrors&, std::int32_t, const Index<3>&);
extern template std::size_t n_overlap_nodes<2>(const Shape<2>&, int, std::size_t);
extern template std::size_t n_overlap_nodes<3>(const Shape<3>&, int, std::size_t);

}  // namespace lode::diamond
