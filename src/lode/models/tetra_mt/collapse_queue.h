#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "lode/models/tetra_mt/live_tetrahedra.h"

namespace lode::tetra_mt {

/// Vertices by key >= 0, smallest first, but for 1/128 of it: in buckets by the bits of a float.
/// Among equals the one that came last.
class CollapseQueue {
 public:
  explicit CollapseQueue(std::uint32_t n_vertices)
      : first_(kBuckets, kNone),
        next_(n_vertices, kNone),
        previous_(n_vertices, kNone),
        keys_(n_vertices, 0),
        is_in_(n_vertices, 0) {}

  /// The last one that it had.
  [[nodiscard]] float key(std::uint32_t vertex) const { return keys_[vertex]; }
  /// Puts it in, or elsewhere.
  void set(std::uint32_t vertex, float key) {
    remove(vertex);
    keys_[vertex] = key;
    const std::uint32_t bucket = bucket_of(key);
    next_[vertex] = first_[bucket];
    previous_[vertex] = kNone;
    if (first_[bucket] != kNone) previous_[first_[bucket]] = vertex;
    first_[bucket] = vertex;
    is_in_[vertex] = 1;
    least_ = std::min(least_, bucket);
  }
  void remove(std::uint32_t vertex) {
    if (is_in_[vertex] == 0) return;
    is_in_[vertex] = 0;
    if (next_[vertex] != kNone) previous_[next_[vertex]] = previous_[vertex];
    if (previous_[vertex] != kNone)
      next_[previous_[vertex]] = next_[vertex];
    else
      first_[bucket_of(keys_[vertex])] = next_[vertex];
  }
  /// kNone when it is empty.
  [[nodiscard]] std::uint32_t pop() {
    while (least_ < kBuckets && first_[least_] == kNone) ++least_;
    if (least_ == kBuckets) return kNone;
    const std::uint32_t vertex = first_[least_];
    remove(vertex);
    return vertex;
  }
  /// Whether a key is no larger than what the queue has, but for its bucket's width.
  [[nodiscard]] bool is_least(float key) {
    while (least_ < kBuckets && first_[least_] == kNone) ++least_;
    return bucket_of(key) <= least_;
  }

 private:
  static constexpr int kShift = 16;  ///< Sign and exponent, and seven bits of the fraction.
  static constexpr std::uint32_t kBuckets = 1U << (31 - kShift);

  [[nodiscard]] static std::uint32_t bucket_of(float key) {
    return std::bit_cast<std::uint32_t>(std::max(key, 0.0F)) >> kShift;
  }

  std::vector<std::uint32_t> first_;  ///< By bucket.
  std::vector<std::uint32_t> next_;
  std::vector<std::uint32_t> previous_;
  std::vector<float> keys_;
  std::vector<std::uint8_t> is_in_;
  std::uint32_t least_ = kBuckets;
};

}  // namespace lode::tetra_mt
