#include "lode/refine/cut.h"

#include <algorithm>
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
    if (n_places_ == pages_.size() * kPageSize)
      pages_.push_back(std::make_unique<Entry[]>(kPageSize));
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

void Cut::grow() {
  const std::vector<Place> old =
      std::exchange(slots_, std::vector<Place>(2 * slots_.size(), kNowhere));
  mask_ = slots_.size() - 1;
  for (const Place at : old) {
    if (at == kNowhere) continue;
    std::size_t i = slot_of((*this)[at].id);
    while (slots_[i] != kNowhere) i = (i + 1) & mask_;
    slots_[i] = at;
  }
}

}  // namespace lode
