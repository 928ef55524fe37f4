#pragma once

// Selective refinement from any earlier cut, by two priority queues: Cignoni, De Floriani, Magillo,
// Puppo, Scopigno (2004), section 4.3.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "lode/refine/budget.h"
#include "lode/refine/demand.h"
#include "lode/refine/demand_queue.h"
#include "lode/refine/error_counts.h"
#include "lode/refine/shortage.h"
#include "lode/refine/standing.h"
#include "lode/refine/waiting.h"

namespace lode {

/// Moves a cut towards the answer of a query, one node or a thousand evaluations a step. After any
/// step the cut is consistent, and the query can be changed.
///
/// Without a budget the answer is the ancestors' closure of {demand > 0}, the same from any earlier
/// cut; on the way there demands fall, but for 1/128 of them, unless ApplyOrder says otherwise.
/// With one it is the longest prefix of one order whose every member fits: again and again the
/// candidate of the largest demand, ties by id, with whatever must come before it. So larger
/// budgets contain smaller ones.
template <RefinableModel M>
class Engine {
 public:
  /// `model` is at its base and must outlive the engine.
  explicit Engine(M& model) : model_(model), cut_(cut_for(model)), n_cells_(model.n_base_cells()) {}

  /// The answer is the same in both orders, which are one where there is a budget or pages come
  /// late.
  void set_query(Demand demand, Budget budget = {}, FocusChange focus = FocusChange::changed,
                 ApplyOrder apply_order = ApplyOrder::best_first) {
    (void)set_query_unless([] { return false; }, std::move(demand), budget, focus, apply_order);
  }
  /// The same, but `must_stop` is asked before each node below the base whose facts it takes, which
  /// may be in pages that take their time: false where it said so. Then no step may follow before
  /// another query, and there are no candidates.
  template <typename MustStop>
  [[nodiscard]] bool set_query_unless(const MustStop& must_stop, Demand demand, Budget budget = {},
                                      FocusChange focus = FocusChange::changed,
                                      ApplyOrder apply_order = ApplyOrder::best_first);

  /// False if nothing was left to do: the answer is there, or it takes pages that are not.
  bool step();

  /// Steps until nothing is left to do.
  void finish() {
    while (step()) {
    }
  }
  /// Steps until nothing is left to do, or `must_stop`, asked before each, says so.
  template <typename MustStop>
  void run(const MustStop& must_stop) {
    while (!must_stop() && step()) {
    }
  }

  [[nodiscard]] Standing standing() const {
    return {n_steps_,
            cut_.n_applied(),
            n_cells_,
            error_bound(),
            phase_ == Phase::settled,
            is_idle_,
            n_cells_ <= budget_.max_cells,
            phase_ == Phase::settled && has_budget_ended_,
            memory_.hopeless.empty() && !(memory_.blocked_demand > 0),
            is_nested_};
  }
  [[nodiscard]] std::uint64_t n_cells() const { return n_cells_; }
  [[nodiscard]] const Cut& cut() const { return cut_; }
  /// The largest measure(facts) of a candidate: what the answer achieves in any unit. Facts have
  /// regions where the demand uses them.
  template <typename Measure>
  [[nodiscard]] double largest(const Measure& measure) const;
  /// Of all the engine holds; the model's own not included.
  [[nodiscard]] std::size_t n_bytes() const {
    return cut_.n_bytes() + wanted_.n_bytes() + spare_.n_bytes() + errors_.n_bytes() +
           waiting_.n_bytes() + memory_.n_bytes() + sizeof(*this);
  }

 private:
  using Place = Cut::Place;
  using State = Cut::State;
  enum class Phase : std::uint8_t {
    settled,
    evaluate,  ///< All entries get their new demand.
    adjust,    ///< Refining what is wanted most, undoing what is least.
    unwind,    ///< Back to before the demand at which the budget ends,
    replay,    ///< and forward in order.
  };
  struct Room {
    float demand = 0;
    std::uint64_t n_cells = 0;
  };
  static constexpr std::size_t kEvaluationsPerStep = 1024;

  [[nodiscard]] static Cut cut_for(const M& model) {
    if constexpr (requires { model.n_nodes(); })
      return Cut(model.n_nodes());
    else
      return Cut();
  }
  [[nodiscard]] NodeFacts facts(NodeId id, const StoredFacts& stored) const {
    NodeFacts result = without_bounds(stored, model_.range_reference());
    if (demand_.uses_bounds()) result.bounds = model_.bounds(id);
    if (demand_.uses_regions()) result.regions = region_mask_of(model_, id);
    return result;
  }
  /// Unless candidates wait for data.
  void settle() {
    const bool is_too_large = n_cells_ > budget_.max_cells;
    has_budget_ended_ = room_.has_value() || (is_too_large && !wanted_.is_empty());
    room_.reset();
    is_idle_ = !waiting_.is_empty();
    phase_ = is_idle_ ? Phase::adjust : Phase::settled;
    if (wanted_.is_empty() && wanted_.n_bytes() > cut_.n_bytes() / 8) wanted_.release();
  }
  /// While candidates of a new focus are looked for, nothing is known of those not found yet.
  [[nodiscard]] double error_bound() const {
    if (phase_ == Phase::evaluate && is_searching_) return std::numeric_limits<double>::infinity();
    return static_cast<double>(errors_.largest());
  }

  void evaluate_or_adjust();
  void evaluate_some();
  void evaluate(Place at);
  void discover(NodeId id, float limit);
  void queue_candidate(Place at);
  void queue_spare(Place at);

  void adjust();
  void make_room();
  void watch_memory();
  void give_way();
  void unblock();
  void wish_again(std::vector<Ranked>& entries);
  bool is_valid_candidate(const Ranked& entry) const;
  bool is_valid_spare(const Ranked& entry) const;
  const Ranked* most_wanted();
  const Ranked* least_wanted();

  void begin_chain(const Ranked& wanted);
  void continue_chain();
  void roll_back();
  bool park(NodeId id);
  void accept_pages();
  void find_children(NodeId id);
  bool find_missing_parents(NodeId id);
  void apply(NodeId id, Place at);
  void undo(NodeId id);

  M& model_;
  Demand demand_;
  Budget budget_;
  Cut cut_;
  DemandQueue<false> wanted_;  ///< Candidates with a demand.
  DemandQueue<true> spare_;    ///< Applied nodes nothing depends on; all of them if keeps_spares_,
                               ///< else unwanted ones.
  ErrorCounts errors_;         ///< Of all candidates.
  Waiting waiting_;            ///< Candidates that cannot be applied yet.
  Shortage memory_;            ///< Of models whose pages do not all fit.
  bool keeps_spares_ = false;
  Phase phase_ = Phase::settled;
  std::size_t next_place_ = 0;     ///< To evaluate,
  std::size_t n_unevaluated_ = 0;  ///< how many from there on,
  std::size_t n_round_ = 0;        ///< of the places that were there when the query came.
  FocusChange focus_ = FocusChange::changed;
  bool has_budget_ended_ = false;  ///< When it settled last: what is left does not fit.
  bool is_in_order_ = true;        ///< The cut was reached from the base by this query alone.
  bool is_nested_ = true;
  bool is_idle_ = false;       ///< Until pages arrive.
  bool is_searching_ = false;  ///< For candidates that the cut of an earlier focus did not keep.
  std::optional<Room> room_;   ///< What the most wanted node lacks.
  float unwind_to_ = 0;
  std::vector<NodeId> chain_;  ///< What is being applied: the wanted one, then what it needs.
  std::vector<NodeId> done_;   ///< Applied for it so far.
  float chain_demand_ = 0;
  Place chain_place_ = 0;  ///< Of the wanted one.
  std::uint64_t cells_before_chain_ = 0;
  std::uint64_t n_cells_ = 0;
  std::uint64_t n_steps_ = 0;
  std::vector<NodeId> parents_;  ///< This and the next two are scratch.
  std::vector<Place> parent_places_;
  std::vector<NodeId> children_;
  std::vector<std::uint32_t> pages_;
};

template <RefinableModel M>
template <typename MustStop>
bool Engine<M>::set_query_unless(const MustStop& must_stop, Demand demand, Budget budget,
                                 FocusChange focus, ApplyOrder apply_order) {
  // An evaluation that was cut short has not looked for candidates everywhere.
  const bool is_complete = phase_ != Phase::evaluate || focus_ == FocusChange::same;
  demand_ = std::move(demand);
  budget_ = budget;
  focus_ = is_complete ? focus : FocusChange::changed;
  phase_ = Phase::evaluate;
  // Places by id are there before anything is in them.
  n_unevaluated_ = n_round_ = cut_.size() > 0 ? cut_.n_places() : 0;
  n_steps_ = 0;
  const QueueOrder order = budget.is_limited() ? QueueOrder::strict : QueueOrder::near;
  const bool is_any =
      apply_order == ApplyOrder::nearest_first && !budget.is_limited() && !PagedRefinableModel<M>;
  wanted_.clear(is_any ? QueueOrder::last : order);
  spare_.clear(order);
  chain_.clear();
  done_.clear();
  room_.reset();
  waiting_.clear();
  memory_.start(cut_.size());
  keeps_spares_ = budget.is_limited();
  if constexpr (PagedRefinableModel<M>) keeps_spares_ = keeps_spares_ || model_.may_be_full();
  is_idle_ = false;
  if constexpr (PagedRefinableModel<M>) model_.forget_requests();
  is_in_order_ = cut_.n_applied() == 0;
  is_nested_ = true;
  is_searching_ = focus_ == FocusChange::changed && cut_.n_applied() > 0;
  if (focus_ == FocusChange::same) return true;
  children_.clear();
  model_.add_base(children_);
  for (const NodeId id : children_) {
    if (must_stop()) return false;
    if (cut_.find(id) == Cut::kNowhere) discover(id, std::numeric_limits<float>::infinity());
  }
  return true;
}

template <RefinableModel M>
bool Engine<M>::step() {
  if constexpr (PagedRefinableModel<M>) watch_memory();
  if (phase_ == Phase::settled) return false;
  if constexpr (PagedRefinableModel<M>) {
    accept_pages();
    if (is_idle_) return false;
  }
  ++n_steps_;
  if (phase_ == Phase::evaluate)
    evaluate_or_adjust();
  else if (!chain_.empty())
    continue_chain();
  else
    adjust();
  return true;
}

/// Without a budget what is known to be wanted, or not, need not wait for the rest: queries that
/// change again and again before all is evaluated would never be answered. With one, order matters.
template <RefinableModel M>
void Engine<M>::evaluate_or_adjust() {
  constexpr std::uint64_t kAdjustments = 32;  // for each evaluation of a thousand
  if (!chain_.empty()) return continue_chain();
  if (!budget_.is_limited() && n_steps_ % (kAdjustments + 1) != 0) {
    const Ranked* most = most_wanted();
    if (most != nullptr && most->demand >= memory_.blocked_demand) {
      begin_chain(*most);
      wanted_.pop();
      return continue_chain();
    }
    const Ranked* least = least_wanted();
    if (least != nullptr && !(least->demand > 0)) return undo(least->id);
  }
  evaluate_some();
}

/// From where the last query left off, once round.
template <RefinableModel M>
void Engine<M>::evaluate_some() {
  for (std::size_t i = 0; i < kEvaluationsPerStep && n_unevaluated_ > 0; ++i, --n_unevaluated_) {
    if (next_place_ >= n_round_) next_place_ = 0;
    evaluate(static_cast<Place>(next_place_++));
  }
  if (n_unevaluated_ == 0) phase_ = Phase::adjust;
}

template <RefinableModel M>
void Engine<M>::evaluate(Place at) {
  Cut::Entry& entry = cut_[at];
  if (entry.state == State::empty) return;
  const Evaluation node = demand_.evaluate(facts(entry.id, entry.facts()));
  if (entry.state == State::candidate && !node.touches) {
    errors_.remove(entry.error);
    cut_.erase(at);
    return;
  }
  entry.demand = to_rank(node.demand);
  if (entry.state == State::candidate) {
    queue_candidate(at);
    return;
  }
  queue_spare(at);
  if (focus_ == FocusChange::same) return;
  children_.clear();
  const float limit = entry.demand;
  model_.add_children(entry.id, children_);
  for (const NodeId child : children_)
    if (cut_.find(child) == Cut::kNowhere) discover(child, limit);
}

/// `limit`: the demand of the node that discovers it.
template <RefinableModel M>
void Engine<M>::discover(NodeId id, float limit) {
  const StoredFacts stored = model_.facts(id);
  const Evaluation node = demand_.evaluate(facts(id, stored));
  if (!node.touches) return;
  const Place at = cut_.insert(id, stored);
  cut_[at].demand = to_rank(node.demand);
  is_nested_ = is_nested_ && !(cut_[at].demand > 0 && cut_[at].demand > limit);
  errors_.add(stored.error);
  queue_candidate(at);
}

template <RefinableModel M>
void Engine<M>::queue_candidate(Place at) {
  const Cut::Entry& entry = cut_[at];
  if (!(entry.demand > 0)) return;
  if (wanted_.size() > 2 * cut_.size() + 1024)
    wanted_.keep_if([&](const Ranked& other) { return is_valid_candidate(other); });
  wanted_.push({entry.id, entry.demand, at});
}

template <RefinableModel M>
void Engine<M>::queue_spare(Place at) {
  const Cut::Entry& entry = cut_[at];
  if (entry.n_dependents > 0 || (entry.demand > 0 && !keeps_spares_)) return;
  if (spare_.size() > 2 * cut_.size() + 1024)
    spare_.keep_if([&](const Ranked& other) { return is_valid_spare(other); });
  spare_.push({entry.id, entry.demand, at});
}

template <RefinableModel M>
bool Engine<M>::is_valid_candidate(const Ranked& entry) const {
  const Cut::Entry& now = cut_[entry.place];
  return now.state == State::candidate && now.id == entry.id && now.demand == entry.demand;
}

template <RefinableModel M>
bool Engine<M>::is_valid_spare(const Ranked& entry) const {
  const Cut::Entry& now = cut_[entry.place];
  return now.state == State::applied && now.id == entry.id && now.demand == entry.demand &&
         now.n_dependents == 0;
}

template <RefinableModel M>
const Ranked* Engine<M>::most_wanted() {
  while (!wanted_.is_empty() && !is_valid_candidate(wanted_.top())) wanted_.pop();
  return wanted_.is_empty() ? nullptr : &wanted_.top();
}

template <RefinableModel M>
const Ranked* Engine<M>::least_wanted() {
  while (!spare_.is_empty() && !is_valid_spare(spare_.top())) spare_.pop();
  return spare_.is_empty() ? nullptr : &spare_.top();
}

template <RefinableModel M>
void Engine<M>::adjust() {
  if (phase_ == Phase::unwind) {
    const Ranked* least = least_wanted();
    if (least != nullptr && least->demand <= unwind_to_) return undo(least->id);
    phase_ = Phase::replay;
  }
  if (n_cells_ > budget_.max_cells) {
    const Ranked* least = least_wanted();
    return least != nullptr ? undo(least->id) : settle();
  }
  if (room_) return make_room();
  const Ranked* most = most_wanted();
  if (most != nullptr && most->demand >= memory_.blocked_demand) {
    begin_chain(*most);
    wanted_.pop();
    return continue_chain();
  }
  if (memory_.blocked_demand > 0) return give_way();
  const Ranked* least = least_wanted();
  if (least == nullptr || least->demand > 0) return settle();
  undo(least->id);
}

/// The most wanted node did not fit: what is wanted less goes first.
template <RefinableModel M>
void Engine<M>::make_room() {
  if (is_in_order_ || phase_ == Phase::replay) return settle();
  const Ranked* least = least_wanted();
  if (n_cells_ + room_->n_cells <= budget_.max_cells) {
    room_.reset();
  } else if (least != nullptr && least->demand < room_->demand) {
    undo(least->id);
  } else {
    unwind_to_ = room_->demand;
    room_.reset();
    phase_ = Phase::unwind;
  }
}

template <RefinableModel M>
template <typename Measure>
double Engine<M>::largest(const Measure& measure) const {
  double result = 0;
  for (std::size_t at = 0; at < cut_.n_places(); ++at) {
    const Cut::Entry& entry = cut_[static_cast<Place>(at)];
    if (entry.state != State::candidate) continue;
    NodeFacts node = without_bounds(entry.facts(), model_.range_reference());
    node.bounds = model_.bounds(entry.id);
    if (demand_.uses_regions()) node.regions = region_mask_of(model_, entry.id);
    result = std::max(result, static_cast<double>(measure(node)));
  }
  return result;
}

}  // namespace lode

#include "lode/refine/engine_changes.h"
