#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/core/vec.h"

namespace lode::tetra_mt {

/// Points in boxes of about equal numbers.
struct SpaceBlocks {
  std::vector<std::uint32_t> points;  ///< Block by block.
  std::vector<std::size_t> begins;    ///< Of blocks, and of what would be the next.

  [[nodiscard]] std::size_t size() const { return begins.size() - 1; }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t block) const {
    return std::span(points).subspan(begins[block], begins[block + 1] - begins[block]);
  }
};

/// Halves what is larger than `max_size` along its longest side, again and again. `share`, between
/// 0 and 1: how much of it lies below the planes of the first three times, whose place decides on
/// all others'. A block's points are ascending.
[[nodiscard]] SpaceBlocks cut_in_blocks(std::span<const Vec3d> positions,
                                        std::vector<std::uint32_t> points, std::size_t max_size,
                                        double share);

}  // namespace lode::tetra_mt
