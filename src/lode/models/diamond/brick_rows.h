#pragma once

// What rows of a brick's samples and of stored nodes say of which nodes are refined, a bit each.

#include <array>
#include <cstdint>

#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// Bit x of word y + 33 z: something of that sample of a brick.
using BrickBits = std::array<std::uint64_t, as_size(kBrickSamples<3>* kBrickSamples<3>)>;

/// Bit y of word z: whether a row is asked for.
using BrickRows = std::array<std::uint64_t, as_size(kBrickSamples<3>)>;

[[nodiscard]] constexpr std::size_t brick_row(std::size_t y, std::size_t z) {
  return y + as_size(kBrickSamples<3>) * z;
}

/// A row of nodes of a level from 1 on, as they are stored: n of them.
struct StoredNodes {
  const ErrorCode* error;
  const float* low;
  const float* high;
  std::size_t n;  ///< At most 32.
};

/// Nodes are refined whose error is larger, and of whose range the low end is below `above` and the
/// high one is not below `below`.
struct NodeLimits {
  ErrorCode error = 0;
  float above = 0;
  float below = 0;
};

/// A bit for each node of a row: whether it is refined. `forced`: those whose error does not
/// matter.
[[nodiscard]] std::uint32_t find_refined(const StoredNodes& row, const NodeLimits& limits,
                                         std::uint32_t forced);

/// When a node's own error is too large: error + slack > limit.
struct ErrorLimit {
  float limit = 0;
  double slack = 0;  ///< 0 of integers.
};

/// At which samples of the rows asked for the node of level 0 with its centre there has a midpoint
/// error beyond the limit: its sample differs from the mean of those at its axis' ends (see
/// axis_ends()). Other rows, and corners of cubes of side 2, get 0.
void find_rough(const std::uint8_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough);
void find_rough(const std::uint16_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough);
void find_rough(const std::int16_t* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough);
void find_rough(const float* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough);
void find_rough(const double* brick, const ErrorLimit& limit, const BrickRows& rows,
                BrickBits& rough);

}  // namespace lode::diamond
