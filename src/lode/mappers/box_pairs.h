#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "lode/core/parallel.h"
#include "lode/core/progress.h"
#include "lode/core/result.h"
#include "lode/core/vec.h"

namespace lode {

/// Points lower <= p <= upper, per axis; finite.
struct Box3f {
  Vec3f lower;
  Vec3f upper;
};

using IndexPair = std::array<std::uint32_t, 2>;

/// Hands every pair of boxes that have a common point to `visit`, once, lower index first, in
/// batches and in no stated order; no two calls with the same worker run at once. Boxes of very
/// different sizes are fine: a tree over the boxes in Morton order.
/// Fails only when cancelled.
[[nodiscard]] Result<void> visit_box_pairs(
    std::span<const Box3f> boxes, Threads threads, Progress& progress,
    const std::function<void(std::span<const IndexPair> pairs, int worker)>& visit);

}  // namespace lode
