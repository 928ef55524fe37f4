#pragma once

#include "lode/core/progress.h"
#include "lode/models/diamond/distance_search.h"
#include "lode/models/diamond/extract.h"
#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/world_code.h"

namespace lode::diamond {

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

struct FileDistanceQuery {
  IsosurfaceQuery surface;  ///< With no nodes wanted, but
  NodeSet<3> wanted;        ///< these.
  double max_distance = 0;  ///< World units, > 0.
  /// What it may take of memory, in bytes, beside a part of the file: the nodes, or it fails; and
  /// the triangles of a window, which is made smaller for that, down to a brick.
  std::uint64_t node_bytes = 0;
  std::uint64_t window_bytes = 0;
};

/// The same of a file with more than kBrickLevel levels, in windows of a chunk or less, each with
/// what lies within a brick round it: until no window has anything left to refine. All nodes larger
/// than bricks that the surface may cross are refined, so that leaves lie in windows. The nodes are
/// others than those of the model in memory, and other windows give others; what is promised is the
/// same.
[[nodiscard]] Result<DistanceCut> find_distance_cut(const CoarseField<3>& field,
                                                    store::BlockCache& blocks,
                                                    FileDistanceQuery query, Progress& progress);

}  // namespace lode::diamond
