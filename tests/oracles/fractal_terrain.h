#pragma once

#include <cstdint>

#include "lode/core/height_grid.h"

namespace lode::oracles {

/// A periodic fractal surface of side by side samples, side a power of two: amplitudes of its waves
/// fall as k^-2 (power as k^-4), phases are random; scaled so that heights are 0..65535. The same
/// for a seed on every machine with IEEE doubles and a C library whose sine and cosine are equal.
/// Memory: 16 bytes a sample while it is made.
[[nodiscard]] HeightGrid make_fractal_terrain(std::int32_t side, std::uint64_t seed);

}  // namespace lode::oracles
