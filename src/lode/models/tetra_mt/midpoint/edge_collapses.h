#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/midpoint/state.h"
#include "lode/models/tetra_mt/refusals.h"

namespace lode::tetra_mt::midpoint {

struct EdgeCollapseOptions {
  std::uint64_t base_cells = 0;  ///< About where to stop.
  CollapseOrder order = CollapseOrder::squared_error;
  /// How far the boundary, and what lies between regions, may be from the reference's, or that from
  /// it, in the mesh's unit: what collapses do is added up. 0: all stays in its planes, but for
  /// rounding. Lines in which sheets meet, and outlines of patches, always stay straight.
  double boundary_tolerance = 0;
  bool has_world_errors = false;  ///< EdgeFacts' are found.
  Threads threads = {};
};

struct EdgeCollapses {
  std::vector<EdgeCollapse> collapses;  ///< In an order that can be done again.
  std::vector<EdgeFacts> facts;         ///< By collapse and field.
  std::uint64_t n_base_cells = 0;
  /// By vertex of the mesh and field: F - F' on the base, as shares of the fields' ranges; 0 for
  /// its vertices.
  std::vector<float> errors;
  double boundary_deviation = 0;  ///< As HalfEdgeCollapses'.
  double volume_change = 0;       ///< The base's volume less the reference's.
  double boundary_tolerance = 0;  ///< The options',
  bool has_world_errors = false;  ///< likewise.
  RefusalCounts refusals;         ///< Of the base's vertices.
};

/// Collapses edges to their midpoints until few cells are left, or none may go: the edge first
/// whose going adds least to what errors at all samples cost, for each cell that goes with it, or
/// as the order says; errors are measured whatever it is (Cignoni, De Floriani, Magillo, Puppo,
/// Scopigno 2004, section 4.2). Samples are the vertices of the reference that are no more in the
/// mesh; errors of all fields count, as shares of their ranges. Of each field the new vertex has
/// the mean of the values, or that of the end which is an extremum of it in the mesh as it is; a
/// maximum and a minimum do not collapse. The mesh stays what it is, topologically; its boundary,
/// and what lies between regions, stays in its planes, but for rounding: an end that may not go
/// along the edge keeps its place, and the other one comes there, with its value. No tetrahedron
/// that comes is flat or turned round, no vertex has more than kMaxLink beside it. In rounds of
/// blocks in space; the same comes of any number of threads. Fails when a face has more than two
/// tetrahedra, a value is not finite, a region has no id, or there is no field.
[[nodiscard]] Result<EdgeCollapses> collapse_edges(const TetraMesh& mesh,
                                                   const EdgeCollapseOptions& options,
                                                   Progress& progress);

}  // namespace lode::tetra_mt::midpoint
