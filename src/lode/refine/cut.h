#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/refine/model.h"

namespace lode {

/// A consistent set of applied nodes, and the candidates beyond it: found by an applied node, in
/// focus, not applied themselves. 32 bytes a node in pages that never move. Nodes are found through
/// an open hash table of 4-byte entries, at most 5/8 full; or, where their ids are small numbers,
/// by these, in pages that are there once one of their nodes is.
class Cut {
 public:
  using Place = std::uint32_t;
  static constexpr Place kNowhere = 0xFFFFFFFFU;

  static constexpr std::uint16_t kMany = 0xFFFFU;

  enum class State : std::uint8_t { empty, candidate, applied };

  struct Entry {
    NodeId id{};
    float error = 0;
    float world_error = 0;
    float low = 0;
    float high = 0;
    float demand = 0;
    /// Applied nodes that directly depend on this one; at kMany it stays, and so does the node.
    std::uint16_t n_dependents = 0;
    State state = State::empty;
    bool is_at_border = false;

    [[nodiscard]] StoredFacts facts() const {
      return {error, world_error, low, high, is_at_border};
    }
  };
  static_assert(sizeof(Entry) == 32);

  Cut();
  /// Of ids below n_ids.
  explicit Cut(std::uint32_t n_ids);

  [[nodiscard]] bool contains(NodeId id) const {
    const Place at = find(id);
    return at != kNowhere && (*this)[at].state == State::applied;
  }
  [[nodiscard]] std::size_t n_applied() const { return n_applied_; }
  /// The applied nodes by ascending id.
  [[nodiscard]] std::vector<NodeId> applied() const;

  // For the engine and one_shot().

  [[nodiscard]] Place find(NodeId id) const {
    if (is_by_id_) {
      const auto at = static_cast<Place>(id);
      return (*this)[at].state == State::empty ? kNowhere : at;
    }
    for (std::size_t i = slot_of(id);; i = (i + 1) & mask_) {
      const Place at = slots_[i];
      if (at == kNowhere || (*this)[at].id == id) return at;
    }
  }
  [[nodiscard]] Entry& operator[](Place at) { return pages_[at >> page_bits_][at & page_mask_]; }
  [[nodiscard]] const Entry& operator[](Place at) const {
    return pages_[at >> page_bits_][at & page_mask_];
  }
  /// Asks the memory for a node's entry.
  void prefetch(NodeId id) const {
    if (is_by_id_) __builtin_prefetch(&(*this)[static_cast<Place>(id)], 1);
  }
  /// Adds a candidate, which must not be there.
  Place insert(NodeId id, const StoredFacts& facts);
  void erase(Place at);
  void set_state(Place at, State state) {
    Entry& entry = (*this)[at];
    n_applied_ += state == State::applied ? 1 : 0;
    n_applied_ -= entry.state == State::applied ? 1 : 0;
    entry.state = state;
  }
  /// Places 0 .. n_places-1 hold all entries, and empty ones.
  [[nodiscard]] std::size_t n_places() const { return n_places_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t n_bytes() const {
    const std::size_t n_kept = kept_.size() << page_bits_;
    const std::size_t n_entries = !is_by_id_ && kept_.size() < 2 ? n_places_ : n_kept;
    return n_entries * sizeof(Entry) + pages_.capacity() * sizeof(void*) +
           (slots_.capacity() + free_.capacity()) * sizeof(Place);
  }

 private:
  /// Of entries: 2 MiB; of the first page only what is used costs memory. By id 16 KiB.
  static constexpr int kPageBits = 16;
  static constexpr int kPageBitsById = 9;

  [[nodiscard]] std::size_t slot_of(NodeId id) const {
    auto bits = static_cast<std::uint64_t>(id);
    bits = (bits ^ (bits >> 32)) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(bits ^ (bits >> 32)) & mask_;
  }
  struct Free {
    void operator()(Entry* page) const noexcept { free_large(page); }
  };
  [[nodiscard]] std::size_t page_size() const { return std::size_t{1} << page_bits_; }
  [[nodiscard]] static Entry* nothing();
  Place take_place(NodeId id);
  void add_page(std::size_t number);
  void grow();

  std::vector<Entry*> pages_;  ///< Those not kept are one of empty entries.
  std::vector<std::unique_ptr<Entry, Free>> kept_;
  int page_bits_ = kPageBits;
  Place page_mask_ = (Place{1} << kPageBits) - 1;
  bool is_by_id_ = false;
  std::vector<Place> free_;
  UninitializedArray<Place> slots_;
  std::size_t mask_ = 0;
  std::size_t n_places_ = 0;
  std::size_t size_ = 0;
  std::size_t n_applied_ = 0;
};

}  // namespace lode
