#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "lode/models/tetra_mt/page_content.h"

namespace lode::tetra_mt {

/// A few items with keys of two or three numbers: how many of them come before each. All are
/// compared with all, many at once, as branches that keys decide would cost more (decision 0051).
class SmallOrder {
 public:
  /// Of items: what a node brings, and one step of a walk.
  static constexpr std::size_t kMost = kMaxBrought + 4;

  /// `n_parts`: of a key, 2 or 3.
  explicit SmallOrder(std::size_t n_parts) : n_parts_(n_parts) {}

  void set_key(std::size_t i, const std::array<std::uint32_t, 3>& key) {
    for (std::size_t k = 0; k < 3; ++k) parts_[k][i] = key[k];
  }
  /// Of the first n items. Where keys are equal, which false says, all are ranked as they lie.
  bool find_ranks(std::size_t n);
  [[nodiscard]] std::uint32_t rank(std::size_t i) const { return ranks_[i]; }

 private:
  static constexpr std::size_t kPadding = 16;
  using Numbers = std::array<std::uint32_t, (kMost + kPadding - 1) / kPadding * kPadding>;

  std::size_t n_parts_;
  alignas(64) std::array<Numbers, 3> parts_{};
  alignas(64) Numbers ranks_{};
};

}  // namespace lode::tetra_mt
