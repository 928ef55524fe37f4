#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "lode/api/tetra_extraction.h"
#include "lode/core/mesh.h"
#include "lode/core/result.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/tetra_cut.h"

namespace lode {

/// Whether there is time to read a page for the error of a cell. Else what is known of all stands
/// for it.
using MayRead = std::function<bool()>;
struct CellErrorReads {
  MayRead may_read;
  double bound = 0;  ///< Of all cells of the cut, of the measured field; of others the base's.
};

/// Cells of a cut, with the values and errors of fields, their vertices numbered in the order of
/// the hierarchy's: whose numbers it returns. Cuts of the same cells give the same mesh, bit for
/// bit, whatever was applied and undone before.
std::vector<std::uint32_t> fill_mesh(const tetra_mt::PackedHierarchy& hierarchy,
                                     const TetraFieldUse& fields, const tetra_mt::TetraCut& cut,
                                     const CellErrorReads& reads, SimplexMesh& mesh);

/// The same of midpoints, whose cut is that of the measured field: vertices are in the order of
/// their labels, and most are none of the reference's. Fails where pages cannot be loaded.
Result<std::vector<std::uint32_t>> fill_mesh(const tetra_mt::midpoint::MidpointCut& cut,
                                             const TetraFieldUse& fields, SimplexMesh& mesh);

}  // namespace lode
