#pragma once

#include <array>
#include <cstdint>

#include "lode/render/volume_view.h"

namespace lode {

/// Rays on their way through the cells of a mesh, side by side: element i of each array is ray i's.
///
/// A vertex is placed relative to a ray's line (LineOffset), cut to 26 bits. So u v' - u' v of two
/// vertices has an exact sign, and all cells agree on which side of an edge the line runs, ties by
/// is_tie_negative(). Then of a cell's four faces the line meets either none or two: from an outer
/// face that it meets a walk takes each cell's other such face, ends at an outer face, and meets no
/// cell twice, whatever the mesh's shape and however its depths round.
struct RayLanes {
  static constexpr std::size_t kCapacity = 64;
  template <typename T>
  using Row = std::array<T, kCapacity>;

  // The line and its part that counts.
  alignas(64) Row<double> right, up, right_slope, up_slope, world_per_depth, begin, end;
  // The face that it is at: corners relative to the line, edges as in MetFace.
  alignas(64) std::array<Row<double>, 3> u, v, depths, levels, edges;
  alignas(64) std::array<Row<std::uint64_t>, 3> corners;
  alignas(64) Row<std::uint64_t> next;  ///< The cell that it enters, or an outer face.
  // Where its integral has come to: depth (the largest so far), level, and what is on the ramp.
  alignas(64) Row<double> depth, level;
  alignas(64) Row<double> transmittance, weight, level_weight;
  // The ramp that it is on, see LightRamp.
  alignas(64) Row<double> lower, upper, origin, extinction, extinction_slope;
  // The end of the segment that is next for integration.
  alignas(64) Row<double> to_depth, to_level;
};

/// What a step has left to do, by ray: bit i is ray i's.
struct LaneEvents {
  std::uint64_t is_segment_open = 0;  ///< From depth to to_depth nothing is integrated yet.
  std::uint64_t has_ended = 0;        ///< At an outer face, opaque, or at its end.
};

/// Moves the rays 0 <= i < n through a cell each and integrates over the segment, unless it is cut
/// by a knot or an end of the ray or is not thin. Same results for any SIMD target and any company.
[[nodiscard]] LaneEvents step_lanes(const CellLinks& links, std::span<const ViewVertex> vertices,
                                    std::size_t n, RayLanes& lanes);

}  // namespace lode
