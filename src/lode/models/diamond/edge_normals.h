#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/core/vec.h"

namespace lode::diamond {

/// The gradients of the field at both ends of edges, axis by axis, and how far from the first end
/// the vertices are, in [0, 1]. There is room for kEdgePadding more.
struct EdgeGradients {
  std::array<const double*, 3> first;
  std::array<const double*, 3> second;
  const double* kept;
  std::size_t n;
};

/// How gradients become normals: as NormalSampler::to_normal() does it.
struct NormalFrame {
  Mat3 to_world;
  double sign;
};

/// Writes unit normals to lower values, zero where the gradient is: as NormalSampler::at() does it
/// one by one, to the bit. Up to `end` anything may be written behind them.
void place_normals(const EdgeGradients& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end);

}  // namespace lode::diamond
