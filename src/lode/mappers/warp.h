#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "lode/core/mesh.h"
#include "lode/core/parallel.h"
#include "lode/core/surface.h"

namespace lode {

/// Moves each vertex of a mesh or surface by a vector's components there, times a scale: linear on
/// each cell, so nothing cracks. Of a mesh it returns how many cells of positive volume have none
/// then. Normals of a surface go, as they are others.
[[nodiscard]] std::uint64_t warp(SimplexMesh& mesh,
                                 const std::array<std::span<const double>, 3>& vector, double scale,
                                 Threads threads);
void warp(Surface& surface, const std::array<std::span<const double>, 3>& vector, double scale);

}  // namespace lode
