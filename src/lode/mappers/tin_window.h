#pragma once

#include "lode/core/height_frame.h"
#include "lode/core/vec.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// A rectangle of the world, with its border.
struct WorldWindow {
  Vec<double, 2> lower;
  Vec<double, 2> upper;
};

/// Keeps the triangles of a TIN that meet a window, whole and in their order, and the vertices that
/// they have, in theirs; twins go. Touching is meeting, up to the rounding of float64. O(size).
void keep_in_window(delaunay::Tin& tin, const HeightFrame& frame, const WorldWindow& window);

}  // namespace lode
