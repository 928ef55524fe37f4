#pragma once

#include <vector>

#include "lode/core/vec.h"

namespace lode::tetra_mt::midpoint {

/// The triangles of a sheet round both ends of an edge, which become those round one vertex between
/// the same outline.
struct EdgePatch {
  Vec3d first;   ///< One end,
  Vec3d second;  ///< the other,
  Vec3d middle;  ///< and the vertex that comes.
  /// Round the first end, without the second; and on round the second, without the first: each
  /// begins where the other ends.
  std::vector<Vec3d> first_ring;
  std::vector<Vec3d> second_ring;
};

/// No point of the old triangles is farther from the new ones, nor any of these from the old ones,
/// but for rounding; infinite where it is not known, or more than `limit`. As patch_deviation():
/// compared along one direction, in which neither may hide part of itself.
[[nodiscard]] double edge_patch_deviation(const EdgePatch& patch, double limit);

}  // namespace lode::tetra_mt::midpoint
