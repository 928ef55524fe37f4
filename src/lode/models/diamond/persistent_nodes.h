#pragma once

#include "lode/models/diamond/critical_nodes.h"

namespace lode::diamond {

/// As find_critical_nodes() of a persistence above 0: nodes with which a cut's surface has the
/// topology of a field that is nowhere farther than the persistence from the samples (see
/// RelaxedBox). That field depends on which nodes are refined, and what is critical on that field:
/// so it goes in rounds, each of which takes in the coarsest ones that are missing.
[[nodiscard]] Result<CriticalNodes> find_persistent_nodes(const Model<3>& model,
                                                          const CriticalQuery& query,
                                                          Progress& progress);
[[nodiscard]] Result<CriticalNodes> find_persistent_nodes(const CoarseField<3>& field,
                                                          store::BlockCache& blocks,
                                                          const CriticalQuery& query,
                                                          Progress& progress);

}  // namespace lode::diamond
