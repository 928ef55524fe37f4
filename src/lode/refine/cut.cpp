#include "lode/refine/cut.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <utility>

namespace lode {

Cut::Cut() : slots_(64, kNowhere), mask_(63) {}

Cut::Cut(std::uint32_t n_ids)
    : page_bits_(kPageBitsById),
      page_mask_((Place{1} << kPageBitsById) - 1),
      is_by_id_(true),
      n_places_(n_ids) {
  pages_.assign((n_places_ + page_mask_) >> page_bits_, nothing());
}

/// A page of empty entries, for all cuts; nobody writes to it.
Cut::Entry* Cut::nothing() {
  static std::array<Entry, std::size_t{1} << kPageBitsById> entries{};
  return entries.data();
}

std::vector<NodeId> Cut::applied() const {
  std::vector<NodeId> result;
  result.reserve(n_applied_);
  for (std::size_t at = 0; at < n_places_; ++at) {
    const Entry& entry = (*this)[static_cast<Place>(at)];
    if (entry.state == State::applied) result.push_back(entry.id);
  }
  std::sort(result.begin(), result.end());
  return result;
}

Cut::Place Cut::insert(NodeId id, const StoredFacts& facts) {
  const Place at = take_place(id);
  (*this)[at] = {id, facts.error, facts.world_error, facts.low,         facts.high,
                 0,  0,           State::candidate,  facts.is_at_border};
  ++size_;
  if (is_by_id_) return at;
  std::size_t i = slot_of(id);
  while (slots_[i] != kNowhere) i = (i + 1) & mask_;
  slots_[i] = at;
  return at;
}

/// Where an entry that is to come will be.
Cut::Place Cut::take_place(NodeId id) {
  if (is_by_id_) {
    const auto at = static_cast<Place>(id);
    if (pages_[at >> page_bits_] == nothing()) add_page(at >> page_bits_);
    return at;
  }
  if (8 * (size_ + 1) > 5 * slots_.size()) grow();
  if (!free_.empty()) {
    const Place at = free_.back();
    free_.pop_back();
    return at;
  }
  if (n_places_ == pages_.size() << page_bits_) {
    pages_.push_back(nullptr);
    add_page(pages_.size() - 1);
  }
  return static_cast<Place>(n_places_++);
}

void Cut::erase(Place at) {
  --size_;
  if (is_by_id_) return set_state(at, State::empty);
  std::size_t hole = slot_of((*this)[at].id);
  while (slots_[hole] != at) hole = (hole + 1) & mask_;
  // Entries behind the hole move up, unless that were before where their search begins.
  for (std::size_t i = (hole + 1) & mask_; slots_[i] != kNowhere; i = (i + 1) & mask_) {
    const std::size_t wanted = slot_of((*this)[slots_[i]].id);
    if (((i - wanted) & mask_) < ((i - hole) & mask_)) continue;
    slots_[hole] = slots_[i];
    hole = i;
  }
  slots_[hole] = kNowhere;
  set_state(at, State::empty);
  free_.push_back(at);
}

void Cut::add_page(std::size_t number) {
  const std::size_t n_bytes = sizeof(Entry) << page_bits_;
  void* memory = kept_.empty() || is_by_id_ ? std::malloc(n_bytes) : allocate_large(n_bytes);
  if (memory == nullptr) throw std::bad_alloc();
  // Entries begin to live when they are set; those by id are empty before.
  pages_[number] = kept_.emplace_back(static_cast<Entry*>(memory)).get();
  if (is_by_id_) std::uninitialized_fill_n(pages_[number], page_size(), Entry{});
}

/// Entries are read as they lie; looking for each from its old slot would be random.
void Cut::grow() {
  const std::size_t n_slots = 2 * slots_.size();
  slots_ = {};
  slots_.assign(n_slots, kNowhere);
  mask_ = n_slots - 1;
  for (std::size_t at = 0; at < n_places_; ++at) {
    const Entry& entry = (*this)[static_cast<Place>(at)];
    if (entry.state == State::empty) continue;
    std::size_t i = slot_of(entry.id);
    while (slots_[i] != kNowhere) i = (i + 1) & mask_;
    slots_[i] = static_cast<Place>(at);
  }
}

}  // namespace lode
