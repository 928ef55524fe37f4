#pragma once

#include <cstdint>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/lattice_mesh.h"
#include "lode/delaunay/worst_sample.h"

namespace lode::delaunay {

/// A node to insert, packed, and one that is in the mesh by then, the nearer the sooner it is
/// found.
struct OrderedNode {
  std::uint32_t node;
  std::uint32_t near;
};

/// Inserts samples in an order that is given, whatever their errors, and finds those of all
/// triangles that there ever are, as strict orders do. Nodes are of the mesh's domain, and none is
/// twice. `range`: of the heights. Fails when cancelled.
template <typename T>
[[nodiscard]] Result<void> insert_in_order(LatticeMesh& mesh, const SampleRows<T>& rows,
                                           HeightRange range, std::span<const OrderedNode> order,
                                           InsertionObserver& observer, Progress& progress);

}  // namespace lode::delaunay
