#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lode/core/uninitialized_array.h"

namespace lode::diamond {

/// A world error as a share of the longest edge of its level's simplices, rounded up: by at most
/// 1/16, but what is more than 0 counts as 1/58000 at least. Codes are ordered as the shares are.
using WorldCode = std::uint8_t;

/// That of the longest edge.
inline constexpr WorldCode kWholeEdge = 255;
/// Codes from a share to its double.
inline constexpr int kWorldCodesPerOctave = 16;

namespace detail {
/// Of a float32's bits, those beyond a code's.
inline constexpr int kWorldShift = 19;
inline constexpr std::uint32_t kWorldOffset =
    (std::bit_cast<std::uint32_t>(1.0F) >> kWorldShift) - kWholeEdge;
}  // namespace detail

/// 0 <= share <= 1.
[[nodiscard]] inline WorldCode encode_world(float share) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(share);
  if (bits == 0) return 0;
  constexpr std::uint32_t kRest = (1U << detail::kWorldShift) - 1;
  const std::uint32_t code = (bits + kRest) >> detail::kWorldShift;
  return static_cast<WorldCode>(
      std::clamp(code, detail::kWorldOffset + 1, detail::kWorldOffset + kWholeEdge) -
      detail::kWorldOffset);
}

[[nodiscard]] inline float decode_world(WorldCode code) {
  if (code == 0) return 0;
  return std::bit_cast<float>((code + detail::kWorldOffset) << detail::kWorldShift);
}

/// The same world error among those of the next coarser level, whose edges are twice as long.
[[nodiscard]] constexpr WorldCode one_level_up(WorldCode code) {
  constexpr int kStep = kWorldCodesPerOctave;
  return code > kStep ? static_cast<WorldCode>(code - kStep) : static_cast<WorldCode>(code != 0);
}

/// The nested world errors of nodes, laid out as Model::levels; an entry of level 0 also covers the
/// finer nodes in its cube.
using WorldErrors = std::vector<UninitializedArray<WorldCode>>;

}  // namespace lode::diamond
