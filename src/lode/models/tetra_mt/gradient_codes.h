#pragma once

#include <cstdint>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

inline constexpr int kGradientBits = 11;  ///< Of a coordinate of the direction.
inline constexpr int kGradientLengthBits = 8;

/// Gradients in 30 bits, to tell which way a surface faces: the direction as a point of an
/// octahedron folded flat, 11 bits a coordinate, within 0.1 degrees; 8 bits of length, in quarters
/// of octaves from 2^-63 to 2 and a half, longer ones as these, shorter ones as the shortest; 0:
/// none.
[[nodiscard]] std::uint32_t gradient_code(const Vec3f& gradient);
[[nodiscard]] Vec3f gradient_of(std::uint32_t code);

}  // namespace lode::tetra_mt
