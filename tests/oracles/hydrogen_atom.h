#pragma once

#include <cstdint>

#include "lode/core/vec.h"
#include "lode/core/volume.h"

namespace lode::oracles {

/// |psi|² of the hydrogen atom's 3d_z² orbital (n, l, m = 3, 2, 0) in units of Bohr radii:
/// (3z² - r²)² exp(-2r/3) / (81² · 6π). Two lobes along z and a ring round them; its integral is 1.
[[nodiscard]] double hydrogen_density(const Vec3d& point);

/// Its largest value, at (0, 0, ±6). On the ring's circle, r = 6 at z = 0, it is a quarter.
[[nodiscard]] double largest_hydrogen_density();

/// The cube that is sampled reaches as far on both sides: beyond, less than half a step of 8 bits.
inline constexpr double kHydrogenHalfWidth = 24;

/// n³ samples of it on that cube, uint8: 255 · density / largest density, rounded to nearest.
/// World coordinates are Bohr radii. 128³ is the size of the data set "Hydrogen" of the papers,
/// which is another state, in a magnetic field, and not in closed form.
[[nodiscard]] Volume hydrogen_atom(std::int32_t n);

}  // namespace lode::oracles
