#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/core/vec.h"

namespace lode::diamond {

/// The gradients at both ends of edges, and how far from the first end the vertices are, in [0, 1].
/// There is room for kEdgePadding more.
template <typename G>
struct EdgeGradients {
  const G* gradients;           ///< Of points, four numbers each, the last of them 0.
  const std::uint32_t* first;   ///< By edge, where those of its ends are,
  const std::uint32_t* second;  ///< by four.
  const double* kept;
  std::size_t n;
  double* between;  ///< Room for four numbers an edge.
};

/// How gradients become normals: as NormalSampler::to_normal() does it.
struct NormalFrame {
  Mat3 to_world;
  double sign;
};

/// Writes unit normals to lower values, zero where the gradient is: as NormalSampler::at() does it
/// one by one, to the bit. Up to `end` anything may be written behind them.
void place_normals(const EdgeGradients<float>& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end);
void place_normals(const EdgeGradients<double>& gradients, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end);

/// The same of gradients where the vertices are, four numbers each; there is room for kEdgePadding
/// numbers more.
void place_normals(const double* gradients, std::size_t n, const NormalFrame& frame, Vec3f* normals,
                   const Vec3f* end);

}  // namespace lode::diamond
