#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/refine/bucket_bits.h"

namespace lode {

/// The largest of a changing set of errors >= 0, each rounded up to the upper 16 bits of a float32
/// (at most 1/128 too large). All in O(1).
class ErrorCounts {
 public:
  ErrorCounts() : counts_(BucketBits::kBuckets, 0) {}

  void add(float error) {
    const std::size_t bucket = bucket_of(error);
    if (counts_[bucket]++ == 0) occupied_.set(bucket);
  }
  void remove(float error) {
    const std::size_t bucket = bucket_of(error);
    if (--counts_[bucket] == 0) occupied_.reset(bucket);
  }
  /// 0 where there is none.
  [[nodiscard]] float largest() const {
    if (occupied_.is_empty()) return 0;
    return std::bit_cast<float>(static_cast<std::uint32_t>(occupied_.highest()) << 16);
  }
  [[nodiscard]] std::size_t n_bytes() const { return counts_.size() * sizeof(counts_[0]); }

 private:
  static std::size_t bucket_of(float error) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(error);
    return (bits >> 16) + ((bits & 0xFFFFU) != 0 ? 1U : 0U);
  }

  std::vector<std::uint32_t> counts_;
  BucketBits occupied_;
};

}  // namespace lode
