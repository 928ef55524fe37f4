#pragma once

#include <array>

#include "lode/core/vec.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt {

/// A triangle is seen along a direction if its area there is more than so much of the product of
/// two of its edges' lengths. Edge-on that is nothing but rounding, of some 1e-16 of the product,
/// by which no two triangles can be held against each other; at this, where edges cross is told to
/// 1e-8 of their lengths.
inline constexpr double kLeastSeen = 1e-8;

/// A disc of triangles round the origin, the vertex that goes, by the other corners in their order;
/// the first is the one that it goes into.
struct Patch {
  std::array<Vec3d, Star::kMaxLink> ring;
  int n = 0;
  bool is_closed =
      true;  ///< Else the origin is on the disc's edge, between the last and the first.
};

/// No point of the old triangles is farther from the new ones, nor any of these from the old ones,
/// but for rounding; infinite where it is not known, or more than `limit`. Both are compared along
/// one direction, in which neither may hide part of itself: their distance along it is linear
/// between the places where edges cross, so that it is largest at one of these. Where the origin is
/// on the disc's edge, that moves by no more than the origin is from the line between first and
/// last, and all else by no more than both together.
[[nodiscard]] double patch_deviation(const Patch& patch, double limit);

/// Of a closed one, that or the one of two discs that meet in the line from the first corner
/// through the origin on to the corner most opposite: as it is on a sharp edge of the boundary.
[[nodiscard]] double sheet_deviation(const Patch& patch, double limit);

/// Of the origin from the line between two points; 0 where their product says that it is on it.
[[nodiscard]] double distance_to_line(const Vec3d& a, const Vec3d& b);

/// Of a point from a triangle that has an area.
[[nodiscard]] double distance_to_triangle(const Vec3d& p, const std::array<Vec3d, 3>& triangle);

}  // namespace lode::tetra_mt
