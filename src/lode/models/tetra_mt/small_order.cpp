#include "lode/models/tetra_mt/small_order.h"

#include <numeric>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "lode/models/tetra_mt/small_order.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lode::tetra_mt::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<std::uint32_t, 16>;

/// parts[k]: of all keys; of n of them, and what lies behind.
template <std::size_t kParts>
HWY_INLINE void count_before(const std::array<const std::uint32_t*, 3>& parts, std::size_t n,
                             std::uint32_t* ranks) {
  const Lanes d;
  for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
    auto rank = hn::Zero(d);
    for (std::size_t j = 0; j < n; ++j) {
      const auto other = [&](std::size_t k) HWY_ATTR { return hn::Set(d, parts[k][j]); };
      const auto mine = [&](std::size_t k) HWY_ATTR { return hn::Load(d, parts[k] + i); };
      auto is_before = hn::Lt(other(kParts - 1), mine(kParts - 1));
      for (std::size_t k = kParts - 1; k-- > 0;)
        is_before =
            hn::Or(hn::Lt(other(k), mine(k)), hn::And(hn::Eq(other(k), mine(k)), is_before));
      rank = hn::Sub(rank, hn::VecFromMask(d, is_before));
    }
    hn::Store(rank, d, ranks + i);
  }
}

void run_count(const std::array<const std::uint32_t*, 3>& parts, std::size_t n_parts, std::size_t n,
               std::uint32_t* ranks) {
  if (n_parts == 2)
    count_before<2>(parts, n, ranks);
  else
    count_before<3>(parts, n, ranks);
}

}  // namespace lode::tetra_mt::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace lode::tetra_mt {
namespace {

HWY_EXPORT(run_count);

}  // namespace

bool SmallOrder::find_ranks(std::size_t n) {
  HWY_DYNAMIC_DISPATCH(run_count)
  ({parts_[0].data(), parts_[1].data(), parts_[2].data()}, n_parts_, n, ranks_.data());
  // Of two items with one key neither is before the other.
  const std::uint32_t sum = std::accumulate(ranks_.begin(), ranks_.begin() + n, 0U);
  if (sum == n * (n - 1) / 2) return true;
  std::iota(ranks_.begin(), ranks_.end(), 0U);
  return false;
}

}  // namespace lode::tetra_mt
#endif
