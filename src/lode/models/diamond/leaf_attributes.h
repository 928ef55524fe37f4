#pragma once

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Cubes of side 2 along a brick's edge.
template <int D>
inline constexpr std::int32_t kLeafCubes = kBrickEdge<D> / 2;

/// Finds the nested attributes of the tier-0 nodes of level 0 in one brick, from its samples with a
/// margin of one layer (see gather_values; holes are NaN), and stores them in `out` (the model's
/// level 0). Errors are largest at midpoints of edges, because at this level every sample is one;
/// `slack` is added to each. They are infinite where holes meet present cells.
template <int D, typename C>
void put_leaf_attributes(const Model<D>& model, const Index<D>& brick, const C* values,
                         double slack, NodeLevel& out);

}  // namespace lode::diamond
