#pragma once

// How the engine changes its cut: a wanted node with all that must come before it, one node back,
// and what waits for pages. Part of engine.h.

#include "lode/refine/engine.h"

namespace lode {

template <RefinableModel M>
void Engine<M>::begin_chain(const Ranked& wanted) {
  chain_.assign(1, wanted.id);
  done_.clear();
  chain_demand_ = wanted.demand;
  chain_place_ = wanted.place;
  cells_before_chain_ = n_cells_;
}

/// Leaves a node's children in children_, and asks the memory for what discovering them will need:
/// it answers while the node is applied.
template <RefinableModel M>
void Engine<M>::find_children(NodeId id) {
  children_.clear();
  model_.add_children(id, children_);
  if constexpr (requires { model_.prefetch(id); })
    for (const NodeId child : children_) {
      model_.prefetch(child);
      cut_.prefetch(child);
    }
}

/// Leaves the places of a node's parents in parent_places_; those that are missing go on the
/// chain.
template <RefinableModel M>
bool Engine<M>::find_missing_parents(NodeId id) {
  parents_.clear();
  parent_places_.clear();
  model_.add_parents(id, parents_);
  const std::size_t n_before = chain_.size();
  for (const NodeId parent : parents_) {
    const Place at = cut_.find(parent);
    if (at == Cut::kNowhere || cut_[at].state != State::applied)
      chain_.push_back(parent);
    else
      parent_places_.push_back(at);
  }
  return chain_.size() > n_before;
}

/// Applies the next node of the chain.
template <RefinableModel M>
void Engine<M>::continue_chain() {
  while (!chain_.empty()) {
    const NodeId id = chain_.back();
    const Place at = chain_.size() == 1 ? chain_place_ : cut_.find(id);
    if (at != Cut::kNowhere && cut_[at].state == State::applied) {
      chain_.pop_back();
      continue;
    }
    if (park(id)) return;
    if (find_missing_parents(id)) {
      if constexpr (PagedRefinableModel<M>) model_.let_go(id);
      continue;
    }
    find_children(id);
    chain_.pop_back();
    apply(id, at);
    if (budget_.is_limited() || PagedRefinableModel<M>) done_.push_back(id);
    if (!budget_.is_limited()) return;
    if (n_cells_ <= budget_.max_cells) return;
    room_ = Room{chain_demand_, n_cells_ - cells_before_chain_};
    return roll_back();
  }
}

/// True if pages are missing to apply the next node of the chain: then the wanted one waits for
/// them, or for memory, and the others are wanted by nobody. Else its pages are held.
template <RefinableModel M>
bool Engine<M>::park(NodeId id) {
  if constexpr (PagedRefinableModel<M>) {
    const Held held = model_.hold(id);
    if (held.state == Held::State::held) return false;
    const Ranked wanted{chain_.front(), chain_demand_, chain_place_};
    if (held.state == Held::State::full) {
      memory_.blocked.push_back(wanted);
      memory_.blocked_demand = std::max(memory_.blocked_demand, wanted.demand);
    } else if (waiting_.is_awaited(held.page) || !model_.may_be_full() ||
               memory_.may_ask(held.page)) {
      if (waiting_.park(held.page, wanted)) model_.request(held.page, chain_demand_);
    } else {
      memory_.hopeless.push_back(wanted);
      memory_.room_then = model_.n_room();
    }
    chain_.clear();
    roll_back();
    is_in_order_ = false;
    memory_.free_then = model_.n_free();
    return true;
  }
  return false;
}

/// Memory that has become free goes to what is wanted most; where others have taken a share, what
/// is wanted least goes.
template <RefinableModel M>
void Engine<M>::watch_memory() {
  if (!keeps_spares_ && model_.may_be_full()) {
    keeps_spares_ = true;
    if (phase_ != Phase::evaluate) focus_ = FocusChange::same;
    phase_ = Phase::evaluate;
    is_idle_ = false;
    n_unevaluated_ = n_round_ = cut_.n_places();
  }
  if (!memory_.hopeless.empty() && model_.n_room() > memory_.room_then) {
    memory_.forget_asked();
    wish_again(memory_.hopeless);
  }
  if (memory_.blocked_demand > 0 && model_.n_free() > memory_.free_then) unblock();
  if (!model_.is_over()) return;
  if (!chain_.empty()) roll_back();
  const Ranked* least = least_wanted();
  if (least == nullptr) return;
  // Else it would be applied again where others hold its page.
  memory_.blocked_demand = std::max(
      memory_.blocked_demand, std::nextafter(least->demand, std::numeric_limits<float>::max()));
  memory_.free_then = 0;
  undo(least->id);
  if (phase_ == Phase::settled) phase_ = Phase::adjust;
  is_idle_ = false;
}

/// There is no memory for what is wanted most: what is wanted less goes first. Where nothing is
/// left that could, there is none.
template <RefinableModel M>
void Engine<M>::give_way() {
  const Ranked* least = least_wanted();
  const float demand = memory_.blocked_demand;
  if (least != nullptr && least->demand < demand && memory_.may_exchange()) return undo(least->id);
  if (!waiting_.is_empty()) {
    is_idle_ = true;
    return;
  }
  if constexpr (PagedRefinableModel<M>) {
    if (model_.drop_unclaimed()) return unblock();
    memory_.room_then = model_.n_room();
  }
  std::erase_if(memory_.blocked, [&](const Ranked& entry) {
    if (entry.demand == demand) memory_.hopeless.push_back(entry);
    return entry.demand == demand;
  });
  unblock();
}

template <RefinableModel M>
void Engine<M>::unblock() {
  memory_.blocked_demand = 0;
  wish_again(memory_.blocked);
}

/// Candidates are wanted once more.
template <RefinableModel M>
void Engine<M>::wish_again(std::vector<Ranked>& entries) {
  for (const Ranked& entry : entries)
    if (is_valid_candidate(entry)) queue_candidate(entry.place);
  entries.clear();
  if (phase_ == Phase::settled) phase_ = Phase::adjust;
  is_idle_ = false;
}

/// What waited for pages that have arrived is wanted again.
template <RefinableModel M>
void Engine<M>::accept_pages() {
  if (model_.has_arrivals()) {
    pages_.clear();
    model_.take_arrivals(pages_);
    for (const std::uint32_t page : pages_) waiting_.page_arrived(page);
  }
  if (!waiting_.has_arrived()) return;
  waiting_.release(kEvaluationsPerStep, [&](const Ranked& entry) {
    if (is_valid_candidate(entry)) queue_candidate(entry.place);
  });
  is_idle_ = false;
  if (!budget_.is_limited()) return;
  // What was under way may not be what is wanted most any more.
  if (!chain_.empty()) roll_back();
  room_.reset();
  if (phase_ == Phase::replay || phase_ == Phase::unwind) phase_ = Phase::adjust;
}

/// Within the step: an answer that is interrupted here must not be too large.
template <RefinableModel M>
void Engine<M>::roll_back() {
  const bool was_in_order = is_in_order_;
  for (; !done_.empty(); done_.pop_back()) undo(done_.back());
  is_in_order_ = was_in_order;
  if (chain_.empty()) return;  // the wanted node was undone, and is in the queue again
  const Place wanted = cut_.find(chain_.front());
  if (wanted != Cut::kNowhere && cut_[wanted].state == State::candidate) queue_candidate(wanted);
  chain_.clear();
}

/// Its parents are applied, and their places in parent_places_; its children are in children_.
/// `at`: where it is a candidate.
template <RefinableModel M>
void Engine<M>::apply(NodeId id, Place at) {
  for (const Place parent : parent_places_)
    if (cut_[parent].n_dependents != Cut::kMany) ++cut_[parent].n_dependents;
  if (at == Cut::kNowhere) {
    const StoredFacts stored = model_.facts(id);
    at = cut_.insert(id, stored);
    cut_[at].demand = to_rank(demand_(facts(id, stored)));
  } else {
    errors_.remove(cut_[at].error);
    if (phase_ == Phase::evaluate) cut_[at].demand = to_rank(demand_(facts(id, cut_[at].facts())));
  }
  cut_.set_state(at, State::applied);
  cut_[at].n_dependents = 0;
  n_cells_ += model_.apply(id);
  queue_spare(at);
  const float limit = cut_[at].demand;
  for (const NodeId child : children_) discover(child, limit);
}

/// Files that lie may have applied what this has discovered, or forgotten what it depends on.
template <RefinableModel M>
void Engine<M>::undo(NodeId id) {
  is_in_order_ = false;
  n_cells_ -= model_.undo(id);
  if constexpr (PagedRefinableModel<M>) model_.let_go(id);
  parents_.clear();
  model_.add_parents(id, parents_);
  for (const NodeId parent : parents_) {
    const Place at = cut_.find(parent);
    if (at == Cut::kNowhere || cut_[at].n_dependents == Cut::kMany) continue;
    if (--cut_[at].n_dependents == 0) queue_spare(at);
  }
  children_.clear();
  model_.add_children(id, children_);
  for (const NodeId child : children_) {
    const Place at = cut_.find(child);
    if (at == Cut::kNowhere || cut_[at].state == State::applied) continue;
    errors_.remove(cut_[at].error);
    cut_.erase(at);
  }
  const Place at = cut_.find(id);
  if (at == Cut::kNowhere) return;
  if (!demand_.touches(facts(id, cut_[at].facts()))) return cut_.erase(at);
  cut_.set_state(at, State::candidate);
  errors_.add(cut_[at].error);
  queue_candidate(at);
}

}  // namespace lode
