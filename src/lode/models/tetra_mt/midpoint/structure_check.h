#pragma once

#include <cstdint>

#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/structure_check.h"

namespace lode::tetra_mt::midpoint {

/// As for half edges; what a node discovers is what it splits into, and what it depends on the cut
/// tells when it may be split. Looks at every page. Fails where one cannot be loaded, or when
/// cancelled.
[[nodiscard]] Result<StructureFindings> check_structure(const Forest& forest, std::uint64_t seed,
                                                        Progress& progress);

}  // namespace lode::tetra_mt::midpoint
