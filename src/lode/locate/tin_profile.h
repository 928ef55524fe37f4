#pragma once

#include <cstdint>
#include <vector>

#include "lode/delaunay/predicates.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// Where a segment from a (t = 0) to b (t = 1) meets an edge or vertex of a TIN, or ends.
struct ProfilePoint {
  double t = 0;
  delaunay::Point at;  ///< Column and row.
  double height = 0;
  double rounding = 0;  ///< Of the height.
  double error = 0;     ///< Of the triangle from here to the next point; 0 at the end of a part.
  bool starts_part = false;  ///< Outside of all triangles just before.
  /// Of surfaces that do not meet: the next point is at the same place, on the other surface.
  bool is_step = false;
};

/// The profile of a TIN with errors and heights: between points of a part it is linear, and nothing
/// is there between parts. Which edges and vertices the segment meets, and in which order, is
/// decided exactly; the domain is closed, so that along an outline it counts, and places where the
/// segment only touches the domain are left out. Where it runs in an edge the smaller error of both
/// triangles holds. Expects a and b, finite, to be different. O(triangles).
[[nodiscard]] std::vector<ProfilePoint> tin_profile(const delaunay::Tin& tin,
                                                    const delaunay::Point& a,
                                                    const delaunay::Point& b);

}  // namespace lode
