#pragma once

#include "lode/delaunay/tin.h"

namespace lode::delaunay {

/// Finds what is behind each edge of a TIN's triangles: twins. Of an edge that more than two
/// triangles have, or two on one side, some get none. O(n log n).
void link_triangles(Tin& tin);

}  // namespace lode::delaunay
