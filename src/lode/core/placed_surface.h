#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/surface.h"

namespace lode {

/// A surface, and where its vertices are in float64.
struct PlacedSurface {
  Surface surface;
  /// In the world, by vertex, where positions in floats do not have them; else empty.
  std::vector<Vec3d> places{};
};

/// The same of another's, which outlives it.
struct PlacedSurfaceView {
  const Surface& surface;
  std::span<const Vec3d> places{};

  [[nodiscard]] Vec3d world_position(std::uint32_t vertex) const {
    return places.empty() ? surface.world_position(vertex) : places[vertex];
  }
};

}  // namespace lode
