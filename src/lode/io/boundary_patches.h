#pragma once

#include <cstddef>

#include "lode/core/cell_mesh.h"
#include "lode/core/result.h"
#include "lode/core/tetra_mesh.h"
#include "lode/io/tetra_faces.h"
#include "lode/io/tetrahedra.h"

namespace lode::io {

/// The field of the cells that numbers patches: PatchId (any case) of integers where there is one,
/// else that of regions, whose place among them is `regions`; their number where there is none.
[[nodiscard]] std::size_t find_patch_ids(const CellMesh& mesh, std::size_t regions);

/// Finds the patches that cells with two dimensions mark on the boundary: a face of one tetrahedron
/// is of the first such cell that has its three corners, and a number other than 0. So faces may
/// have more corners than tetrahedra, on their edges too. `regions`: find_regions(). The result's
/// corners are the mesh's points. Counts what is taken, and what is left out as it lies inside, or
/// has no number. Fails on numbers of 2^53 and more. O(faces log faces), but for points that very
/// many faces of more than three corners share.
[[nodiscard]] Result<void> take_patches(const CellMesh& mesh, std::size_t regions,
                                        const TetraFaces& faces, TetraMesh& result,
                                        TetraReport& report);

}  // namespace lode::io
