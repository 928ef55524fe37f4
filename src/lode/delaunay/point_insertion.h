#pragma once

#include <cstdint>
#include <span>

#include "lode/core/height_frame.h"
#include "lode/core/progress.h"
#include "lode/delaunay/greedy_insertion.h"
#include "lode/delaunay/lattice_mesh.h"

namespace lode::delaunay {

/// Scattered points with heights, and where they lie in a mesh of them that is to be refined.
struct PointSamples {
  std::span<const LatticePoint> nodes;         ///< Different; as the mesh has them.
  std::span<const double> heights;             ///< Finite, by node.
  std::span<const std::uint32_t> triangle_of;  ///< By node: one that holds it; kNoHalfEdge: none.
};

/// The Delaunay selector, as insert_greedily(), of scattered points. Each triangle has a list of
/// the points in it that are not inserted; those of the triangles that an insertion removes are
/// handed to the new ones round it. A point on an edge is in one list, of whose triangle does not
/// matter: both planes agree there; in the end both triangles' errors count it. Of points of a
/// triangle that err equally by computation the one whose shuffled number is smallest is taken.
/// Errors are computed in float64; what rounding may hide counts as error, so of triangles that are
/// not level a tolerance of 0 leaves no point out. `range`: of the heights. `observer` may be null.
/// O(n log n) usually. Fails when cancelled.
[[nodiscard]] Result<GreedyReport> insert_points(PointMesh& mesh, const PointSamples& samples,
                                                 HeightRange range, const GreedyOptions& options,
                                                 Progress& progress,
                                                 PointObserver* observer = nullptr);

/// Inserts all points in triangles, whatever their heights, which may be left out. O(n log n)
/// expected, as orders are shuffled.
[[nodiscard]] Result<void> insert_all_points(PointMesh& mesh, const PointSamples& samples,
                                             Progress& progress);

/// Inserts points in an order that is given, whatever their errors, and finds those of all
/// triangles that there ever are, as insert_points() does. `order`: nodes that lie in triangles and
/// are no corners, none twice. Fails when cancelled.
[[nodiscard]] Result<void> insert_points_in_order(PointMesh& mesh, const PointSamples& samples,
                                                  HeightRange range,
                                                  std::span<const std::uint32_t> order,
                                                  PointObserver& observer, Progress& progress);

}  // namespace lode::delaunay
