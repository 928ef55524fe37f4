#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// Gives the sides of creases vertices of their own, so that normals that are averaged at vertices
/// are smooth along the sides and not across the crease. A crease is an edge at which two
/// triangles' normals are more than `angle` (radians) apart, that two triangles do not run through
/// in opposite directions, or that one triangle or more than two have. A vertex gets as many copies
/// as parts between creases meet in it. Corners of `triangles` are changed, copies are numbered
/// after `positions`; returns which vertex each copy is of. O(n log n) of n triangles.
[[nodiscard]] std::vector<std::uint32_t> split_at_creases(
    std::span<const Vec3f> positions, double angle,
    std::span<std::array<std::uint32_t, 3>> triangles);

}  // namespace lode
