#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/world_code.h"

namespace lode::diamond {

/// How a distance was kept.
struct DistanceCutReport {
  double proven = 0;                   ///< World units: no point of either surface is farther.
  std::uint64_t n_rounds = 0;          ///< How often the surface was held against the true one.
  std::uint64_t n_nodes = 0;           ///< Refined for the distance.
  std::uint64_t n_full_triangles = 0;  ///< Of the true surface.
  std::uint64_t n_lost = 0;            ///< Its triangles that no refinement brought near,
  double lost_size = 0;                ///< and the diagonal of the box round them, world units.
};

struct DistanceCut {
  NodeSet<3> nodes;  ///< IsosurfaceQuery::wanted, with those that the query had there.
  DistanceCutReport report;
};

/// Finds which nodes to refine, beside those that the query itself and the border ask for, so
/// that no point of the query's surface is farther than `max_distance` (world units, > 0) from that
/// of full resolution, nor any point of that one from it; both as extract_isosurface() gives them.
/// docs/models/diamond3d.md has the proof. Starts from `worlds`, which only save rounds. Takes
/// about 75 bytes of memory for each triangle of full resolution, and 130 for each of the cut.
/// Deterministic; fails when cancelled.
[[nodiscard]] Result<DistanceCut> find_distance_cut(const Model<3>& model,
                                                    const IsosurfaceQuery& query,
                                                    double max_distance, const WorldErrors& worlds,
                                                    Progress& progress);

}  // namespace lode::diamond
