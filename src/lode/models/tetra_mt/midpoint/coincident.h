#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode::tetra_mt::midpoint {

/// Whether two positions are the same bits.
[[nodiscard]] bool is_same_place(const Vec3d& a, const Vec3d& b);

/// Numbers of positions, by the bits of x, then y, then z; of those at one place, ascending.
[[nodiscard]] std::vector<std::uint32_t> by_place(std::span<const Vec3d> positions);

/// Of by_place(): places in its order from `begin` until before `end`, two at least.
struct CoincidentRun {
  std::size_t begin;
  std::size_t end;
};
/// All that lie at one place, ascending. `order`: by_place().
[[nodiscard]] std::vector<CoincidentRun> coincident_runs(std::span<const Vec3d> positions,
                                                         std::span<const std::uint32_t> order);

}  // namespace lode::tetra_mt::midpoint
