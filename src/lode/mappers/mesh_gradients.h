#pragma once

#include <vector>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"

namespace lode {

/// The gradient of a mesh's field at each vertex: the mean of those of the tetrahedra round it,
/// weighted by their solid angles there (Cignoni et al. 2004, section 3); all divided by the
/// largest coordinate of any, so that their ratios are kept and float32 holds them. Cells whose
/// volume is lost in rounding, less than 1e-12 of their edges' product, have none. Zero where no
/// cell has one, or they cancel. The same for any number of threads. O(cells), 16 bytes each for a
/// while.
[[nodiscard]] std::vector<Vec3f> vertex_gradients(const SimplexMesh& mesh, Threads threads);

}  // namespace lode
