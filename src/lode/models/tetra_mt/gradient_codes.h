#pragma once

#include <cstdint>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

inline constexpr int kGradientBits = 12;  ///< Of a coordinate of the direction,
/// whose codes are 0 to this: even, so that both axes and the middle have codes. Steps of 2 / n an
/// axis turn no direction by more than sqrt(18) / n, in the middle of a face: 0.0017, or 0.097
/// degrees.
inline constexpr std::uint32_t kGradientSteps = 2500;
inline constexpr int kGradientLengthBits = 8;

/// Gradients in 32 bits, to tell which way a surface faces: the direction as a point of an
/// octahedron folded flat, 12 bits a coordinate, within 0.1 degrees; 8 bits of length, in quarters
/// of octaves from 2^-63 to 2 and a half, longer ones as these, shorter ones as the shortest; 0:
/// none.
[[nodiscard]] std::uint32_t gradient_code(const Vec3f& gradient);
[[nodiscard]] Vec3f gradient_of(std::uint32_t code);

}  // namespace lode::tetra_mt
