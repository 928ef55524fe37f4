#pragma once

#include <cstdint>

#include "lode/delaunay/tin.h"

namespace lode {

/// Where triangles of a TIN do not meet edge to edge: a vertex hangs in an edge of another triangle
/// that does not have it.
struct TinGaps {
  std::uint64_t n_hanging = 0;  ///< Vertices.
  double largest = 0;           ///< Vertical, at one of them.
};

/// Of a TIN with heights. O(n log n).
[[nodiscard]] TinGaps measure_gaps(const delaunay::Tin& tin);

/// Closes all gaps: each hanging vertex gets the height of the longest edge that it hangs in, long
/// edges first (paper 004, figure 6: which can make refinement useless). Errors of triangles are no
/// bounds any more, and are left out.
void close_gaps(delaunay::Tin& tin);

}  // namespace lode
