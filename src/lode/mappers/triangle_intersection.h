#pragma once

#include <array>

#include "lode/core/vec.h"

namespace lode {

/// Corners of a triangle. The exact answers below hold for any finite coordinates.
using TriangleCorners = std::array<Vec3f, 3>;
using LineEnds = std::array<Vec3f, 2>;

/// Whether the three points lie on one line, exactly.
[[nodiscard]] bool has_zero_area(const Vec3f& a, const Vec3f& b, const Vec3f& c);

/// Whether two triangles with no common corner have a common point, exactly. Neither may have
/// zero area; so for the functions below.
[[nodiscard]] bool triangles_meet(const TriangleCorners& s, const TriangleCorners& t);

/// Whether two triangles with s[0] = t[0], and no other common corner, meet anywhere else.
[[nodiscard]] bool triangles_meet_beyond_corner(const TriangleCorners& s, const TriangleCorners& t);

/// Whether two triangles with s[0] = t[0], s[1] = t[1] and s[2] != t[2] meet beyond that edge:
/// they are coplanar and lie on the same side of it.
[[nodiscard]] bool triangles_meet_beyond_edge(const TriangleCorners& s, const TriangleCorners& t);

/// Whether two segments in the plane of the first two coordinates (the third is ignored), with no
/// common end, have a common point, exactly. Neither may be a point.
[[nodiscard]] bool lines_meet(const LineEnds& s, const LineEnds& t);

/// Whether two such segments with s[0] = t[0] and s[1] != t[1] overlap.
[[nodiscard]] bool lines_meet_beyond_end(const LineEnds& s, const LineEnds& t);

}  // namespace lode
