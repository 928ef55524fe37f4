#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode::implicit_pyramid {

/// A vertex that was removed, and one that was its neighbour, and stayed for another level.
struct RemovedVertex {
  std::uint32_t vertex;
  std::uint32_t neighbour;
};

/// By level, from the finest on; of a level in the order of vertices.
using Thinning = std::vector<std::vector<RemovedVertex>>;

/// Vertices with more neighbours stay for another level, as long as others go.
inline constexpr std::size_t kMostNeighbours = 8;

/// Takes vertices out of a Delaunay triangulation with heights and twins, level by level, until
/// those that must stay are left: each time a maximal set of which no two are neighbours and each
/// has kMostNeighbours at most (D. Kirkpatrick, "Optimal search in planar subdivisions", SIAM J.
/// Computing 12, 1983; M. de Berg, K. Dobrindt, "On levels of detail in terrains", 1995). First
/// come those whose heights differ least from what their neighbours make one expect. O(n log n).
[[nodiscard]] Result<Thinning> thin(delaunay::Tin full, const std::vector<bool>& must_stay,
                                    Progress& progress);

}  // namespace lode::implicit_pyramid
