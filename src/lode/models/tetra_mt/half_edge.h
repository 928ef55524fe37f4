#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/block_collapser.h"

namespace lode::tetra_mt {

struct HalfEdgeOptions {
  std::uint64_t base_cells = 0;  ///< About where to stop.
  CollapseRules rules = {};
  Threads threads = {};
};

struct HalfEdgeCollapses {
  std::vector<Collapse> collapses;     ///< In an order that can be done again.
  std::vector<CollapseFacts> facts;    ///< By collapse and field.
  bool has_errors_everywhere = false;  ///< make_errors_hold_everywhere() has been there.
  bool has_world_errors = false;       ///< The rules'.
  std::vector<CollapseStars> stars;    ///< Of the collapses, in pieces.
  std::vector<Tetrahedron> base;       ///< Of the mesh's vertices.
  /// By tetrahedron of the base: the vertex whose collapse made it, or kNone.
  std::vector<std::uint32_t> base_makers;
  std::vector<OuterTetrahedron> outer_base;
  /// By tetrahedron of the base, as the mesh's; empty where there is one region and no patch.
  std::vector<std::uint32_t> base_regions;
  /// By vertex and field: F - F' on the base, as shares of the fields' ranges; 0 for its vertices.
  std::vector<float> errors;
  /// No point of the base's boundary, of one of its patches, or of what lies between its regions,
  /// is farther from the reference's, nor any of these from the base's; in the mesh's unit. At most
  /// CollapseRules::boundary_tolerance, or what that says of 0.
  double boundary_deviation = 0;
  RefusalCounts refusals;    ///< Of the base's vertices.
  double volume_change = 0;  ///< The base's volume less the reference's.
};

/// Collapses edges into one of their ends until few cells are left, or none may go: the vertex
/// first whose going adds least to what errors at all samples cost, for each cell that goes with
/// it, or as CollapseRules::order says (Cignoni, De Floriani, Magillo, Puppo, Scopigno 2004,
/// section 4.2; half edges: Danovaro, De Floriani 2005). Errors are measured whatever the order.
/// The mesh stays what it is, topologically; its boundary stays where it is, but for
/// CollapseRules::boundary_tolerance, and so does each region: what lies between two goes along
/// itself alone, and each patch of the boundary, lines in which sheets or patches meet along these;
/// no tetrahedron that comes is flat or turned round; the fields' ranges stay, as no vertex goes
/// whose value is above or below all beside it. In rounds: each has a limit, and blocks in space in
/// which all up to that go; then blocks elsewhere. The same comes of any number of threads. Fails
/// when a face has more than two tetrahedra, a value is not finite, or a region has no id.
[[nodiscard]] Result<HalfEdgeCollapses> collapse_half_edges(const TetraMesh& mesh,
                                                            const HalfEdgeOptions& options,
                                                            Progress& progress);

}  // namespace lode::tetra_mt
