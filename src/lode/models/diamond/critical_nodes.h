#pragma once

#include <cstdint>
#include <limits>

#include "lode/core/progress.h"
#include "lode/models/diamond/file_parts.h"
#include "lode/models/diamond/node_set.h"
#include "lode/models/diamond/weak_regions.h"

namespace lode::diamond {

/// Nodes without which a cut's surface may have another topology than that of full resolution.
struct CriticalNodes {
  NodeSet<3> nodes;              ///< With their ancestors: IsosurfaceQuery::wanted.
  std::uint64_t n_critical = 0;  ///< Themselves: also those that reach across the border, refined
                                 ///< anyway, whose ring it breaks into pieces; with a persistence
                                 ///< not those that the cut refines anyway;
  std::uint64_t n_nodes = 0;     ///< and with the ancestors.
  WeakRegions weak{};            ///< Where asked for.
};

struct CriticalQuery {
  double isovalue = 0;
  double persistence = 0;  ///< Field units.
  Threads threads{};
  std::uint64_t max_bytes = std::numeric_limits<std::uint64_t>::max();  ///< Of a file's set.
  /// With a persistence, what else the cut refines: by its errors,
  double tolerance = std::numeric_limits<double>::infinity();
  /// and these: a set that has all ancestors of its nodes. Null: none.
  const NodeSet<3>* refined = nullptr;
  bool with_weak = false;  ///< With a persistence, whether weak regions are found, too.
};

/// Finds all nodes of a volume that are critical at an isovalue: refining one changes the topology
/// of the surface in its star. Its centre lies on one side, both ends of its axis on the other, and
/// round the axis the star's other vertices are not one arc of either side. All others move the
/// surface without tearing or joining it, in whatever order they are refined, so in a cut with all
/// critical nodes refined it has the topology of full resolution: docs/models/diamond3d.md, "The
/// topology kept". After Gerstner and Pajarola, Visualization 2000. With a persistence the cut's
/// surface has the topology of another field at the isovalue, which is nowhere farther than that
/// from this one: so it keeps what there is from so far below the isovalue to so far above. Only
/// bricks that the surface of either field may cross are looked at. Deterministic; fails when
/// cancelled.
[[nodiscard]] Result<CriticalNodes> find_critical_nodes(const Model<3>& model,
                                                        const CriticalQuery& query,
                                                        Progress& progress);

/// The same nodes of a file, chunk by chunk, as extract_from_file() goes through it. Fails where
/// their set takes more than the query lets it.
[[nodiscard]] Result<CriticalNodes> find_critical_nodes(const CoarseField<3>& field,
                                                        store::BlockCache& blocks,
                                                        const CriticalQuery& query,
                                                        Progress& progress);

}  // namespace lode::diamond
