#pragma once

#include <cstdint>
#include <vector>

#include "lode/core/height_frame.h"
#include "lode/core/surface.h"
#include "lode/delaunay/tin.h"

namespace lode {

/// A TIN in the world, and how far its coordinates in floats are from those of the samples: heights
/// in their unit, positions along an axis of the world.
struct TinSurface {
  Surface surface;
  /// Of PlacedSurface, where floats do not have all heights.
  std::vector<Vec3d> places{};
  double height_slack = 0;
  double position_slack = 0;
  std::uint64_t n_turned = 0;  ///< Triangles that floats turn over, or make flat.
};

/// Of a TIN with heights. Triangles turn left seen from above; values are the heights, exactly. The
/// origin is zero where floats hold all coordinates, else the lower corner; heights that are floats
/// or of 16 bits keep theirs at zero, and are exact.
[[nodiscard]] TinSurface to_surface(const delaunay::Tin& tin, const HeightFrame& frame);

/// How triangles that turn left on the lattice turn in the world.
enum class TriangleTurns : std::uint8_t { left, right };

/// The same with vertices at given places, x, y and height, which it keeps.
[[nodiscard]] TinSurface to_surface(const delaunay::Tin& tin, std::vector<Vec3d> places,
                                    TriangleTurns turns);

}  // namespace lode
