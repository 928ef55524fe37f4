#pragma once

#include <cstdint>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

inline constexpr int kGradientBits = 12;  ///< Of a coordinate of the direction,
/// whose codes are 0 to this: even, so that both axes and the middle have codes, and as few as do.
inline constexpr std::uint32_t kGradientSteps = 2400;
inline constexpr int kGradientLengthBits = 8;

/// Gradients in 32 bits, to tell which way a surface faces: the direction as a point of an
/// octahedron folded flat, 12 bits a coordinate, within 0.1 degrees; 8 bits of length, in quarters
/// of octaves from 2^-63 to 2 and a half, longer ones as these, shorter ones as the shortest; 0:
/// none.
[[nodiscard]] std::uint32_t gradient_code(const Vec3f& gradient);
[[nodiscard]] Vec3f gradient_of(std::uint32_t code);

}  // namespace lode::tetra_mt
