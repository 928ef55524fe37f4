#pragma once

#include <vector>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Cubes of side 2 along a brick's edge.
template <int D>
inline constexpr std::int32_t kLeafCubes = kBrickEdge<D> / 2;

/// The nested attributes of the tier-0 nodes of level 0 in one brick.
template <typename C>
struct LeafAttributes {
  std::vector<C> error;  ///< kLeafCubes^D, x fastest; infinite where holes meet present cells.
  std::vector<C> low;    ///< Over the nested domain; low > high: no finite sample.
  std::vector<C> high;
};

/// Finds them from the brick's samples with a margin of one layer (see gather_values; holes are
/// NaN). Errors are largest at midpoints of edges, because at this level every sample is one.
template <int D, typename C>
void compute_leaf_attributes(const Model<D>& model, const Index<D>& brick, const C* values,
                             LeafAttributes<C>& out);

}  // namespace lode::diamond
