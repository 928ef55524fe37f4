#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lode/refine/bucket_bits.h"
#include "lode/refine/cut.h"

namespace lode {

/// The order of refinement: larger demands first, ties by smaller id.
struct Ranked {
  NodeId id{};
  float demand = 0;  ///< >= 0.
  Cut::Place place = 0;

  [[nodiscard]] bool comes_before(const Ranked& other) const {
    return demand != other.demand ? demand > other.demand : id < other.id;
  }
};

enum class QueueOrder : std::uint8_t {
  strict,
  near,  ///< Demands may be out of order by 1/128: what was pushed last, and lies near, comes
         ///< first.
  last,  ///< Whatever the demands: what was pushed last comes first.
};

/// A priority queue of nodes of a cut whose entries may have become stale: the reader asks the cut.
/// From the first in the order of refinement, or (IsReversed) from the last. A bucket for each
/// value of a demand's upper 16 bits: in strict order a heap, else a stack; or a stack for all.
template <bool IsReversed>
class DemandQueue {
 public:
  DemandQueue() : heap_of_(BucketBits::kBuckets, kNone) {}

  [[nodiscard]] bool is_empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const Ranked& top() const {
    const std::size_t bucket = first();
    const auto& heap = heaps_[heap_of_[bucket]];
    return is_stack(bucket) ? heap.back() : heap.front();
  }

  void clear(QueueOrder order) {
    for (auto& heap : heaps_) heap.clear();
    occupied_.clear();
    size_ = 0;
    order_ = order;
  }
  /// Gives the memory of an empty queue back.
  void release() {
    heaps_ = {};
    std::fill(heap_of_.begin(), heap_of_.end(), kNone);
  }
  void push(const Ranked& entry) {
    const std::size_t bucket = bucket_of(entry.demand);
    if (heap_of_[bucket] == kNone) {
      heap_of_[bucket] = static_cast<std::uint16_t>(heaps_.size());
      heaps_.emplace_back();
    }
    auto& heap = heaps_[heap_of_[bucket]];
    if (heap.empty()) occupied_.set(bucket);
    heap.push_back(entry);
    if (!is_stack(bucket)) std::push_heap(heap.begin(), heap.end(), comes_later);
    ++size_;
  }
  void pop() {
    const std::size_t bucket = first();
    auto& heap = heaps_[heap_of_[bucket]];
    if (!is_stack(bucket)) std::pop_heap(heap.begin(), heap.end(), comes_later);
    heap.pop_back();
    if (heap.empty()) occupied_.reset(bucket);
    --size_;
  }
  /// Drops the others, and doubles.
  template <typename IsValid>
  void keep_if(const IsValid& is_valid) {
    std::vector<Ranked> kept;
    for (const auto& heap : heaps_)
      std::copy_if(heap.begin(), heap.end(), std::back_inserter(kept), is_valid);
    std::sort(kept.begin(), kept.end(),
              [](const Ranked& a, const Ranked& b) { return a.comes_before(b); });
    const auto same = [](const Ranked& a, const Ranked& b) { return a.id == b.id; };
    kept.erase(std::unique(kept.begin(), kept.end(), same), kept.end());
    clear(order_);
    for (const Ranked& entry : kept) push(entry);
  }
  [[nodiscard]] std::size_t n_bytes() const {
    std::size_t n = heap_of_.size() * sizeof(std::uint16_t);
    for (const auto& heap : heaps_)
      n += sizeof(std::vector<Ranked>) + heap.capacity() * sizeof(Ranked);
    return n;
  }

 private:
  static constexpr std::uint16_t kNone = 0xFFFFU;

  /// Nodes that nobody wants all go, in whatever order.
  [[nodiscard]] bool is_stack(std::size_t bucket) const {
    return order_ != QueueOrder::strict || (IsReversed && bucket == 0);
  }
  [[nodiscard]] std::size_t first() const {
    return IsReversed ? occupied_.lowest() : occupied_.highest();
  }
  [[nodiscard]] std::size_t bucket_of(float demand) const {
    return order_ == QueueOrder::last ? 0 : std::bit_cast<std::uint32_t>(demand) >> 16;
  }
  static bool comes_later(const Ranked& a, const Ranked& b) {
    return IsReversed ? a.comes_before(b) : b.comes_before(a);
  }

  std::vector<std::uint16_t> heap_of_;
  std::vector<std::vector<Ranked>> heaps_;
  BucketBits occupied_;
  std::size_t size_ = 0;
  QueueOrder order_ = QueueOrder::strict;
};

}  // namespace lode
