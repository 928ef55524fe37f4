#pragma once

#include <cstdint>

#include "lode/core/tetra_mesh.h"

namespace lode::oracles {

/// Gradient noise in three octaves (Perlin 1985), the coarsest of `frequency` lattice steps a unit;
/// gradients by hashes of `seed`.
[[nodiscard]] double gradient_noise(const Vec3d& p, std::uint64_t seed);

enum class Cut : int { in_five = 5, in_six = 6 };

/// A regular grid of n samples an axis over [0, 1]^3, each cell cut into tetrahedra, with a field
/// of noise: the paper's Plasma64 is such a one of 64, cut in six.
[[nodiscard]] TetraMesh noise_mesh(int n, Cut cut, std::uint64_t seed);

}  // namespace lode::oracles
