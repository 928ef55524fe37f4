#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"
#include "lode/core/result.h"
#include "lode/delaunay/tin.h"

namespace lode::delaunay {

struct FullTin {
  Tin tin;                       ///< With twins, errors, all 0, and heights.
  std::uint64_t n_left_out = 0;  ///< Valid samples that are corners of no cell with four.
};

/// All samples of the domain (see grid_domain.h): two triangles a cell with four valid corners, cut
/// along the diagonal whose ends differ less in height, of equal ones that from the lower left. A
/// cell's corners are on one circle, so either way it is Delaunay. O(samples). Fails as
/// find_domain() does, but for the
/// size: beyond 2^30 triangles.
[[nodiscard]] Result<FullTin> to_full_tin(const HeightGrid& grid);

}  // namespace lode::delaunay
