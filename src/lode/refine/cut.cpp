#include "lode/refine/cut.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace lode {

Cut::Cut() : slots_(64, kNowhere), mask_(63) {}

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
  if (8 * (size_ + 1) > 5 * slots_.size()) grow();
  Place at;
  if (!free_.empty()) {
    at = free_.back();
    free_.pop_back();
  } else {
    if (n_places_ == pages_.size() * kPageSize) add_page();
    at = static_cast<Place>(n_places_++);
  }
  (*this)[at] = {id, facts.error, facts.world_error, facts.low,         facts.high,
                 0,  0,           State::candidate,  facts.is_at_border};
  std::size_t i = slot_of(id);
  while (slots_[i] != kNowhere) i = (i + 1) & mask_;
  slots_[i] = at;
  ++size_;
  return at;
}

void Cut::erase(Place at) {
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
  --size_;
}

void Cut::add_page() {
  constexpr std::size_t kBytes = kPageSize * sizeof(Entry);
  void* memory = pages_.empty() ? std::malloc(kBytes) : allocate_large(kBytes);
  if (memory == nullptr) throw std::bad_alloc();
  pages_.emplace_back(static_cast<Entry*>(memory));  // entries begin to live when they are set
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
