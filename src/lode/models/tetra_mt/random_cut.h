#pragma once

#include <cstdint>

#include "lode/models/tetra_mt/tetra_cut.h"

namespace lode::tetra_mt {

/// Applies `n_wanted` nodes chosen at random, or fewer where one is chosen twice, and what must
/// come before them, to a cut that stands at its base: the same for the same seed. Stops where the
/// cut is damaged.
void apply_at_random(const PackedHierarchy& hierarchy, std::uint32_t n_wanted, std::uint64_t seed,
                     TetraCut& cut);

}  // namespace lode::tetra_mt
