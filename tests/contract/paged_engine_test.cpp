// The engine over models whose data come late: whatever comes when, the answer is the same.

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/contract/models.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// A model whose nodes each need one of `n_pages`; which have come the test decides. At most
/// `room` of them are held or promised at once.
template <typename M>
class Slow : public M {
 public:
  Slow(M model, std::uint_fast32_t n_pages, std::size_t room = 1U << 30)
      : M(std::move(model)), n_pages_(n_pages), room_(room) {}

  Held hold(NodeId id) {
    const auto page =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(id) * 0x9E3779B1U % n_pages_);
    if (page < 3) return {};  // the first are always there
    if (const auto use = uses_.find(page); use != uses_.end()) {
      ++use->second;
      return {};
    }
    if (!promised_.contains(page) && n_free() == 0) return {Held::State::full, page};
    if (!here_.contains(page)) {
      promised_[page] = false;
      return {Held::State::absent, page};
    }
    promised_.erase(page);
    uses_[page] = 1;

    return {};
  }
  void let_go(NodeId id) {
    const auto page =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(id) * 0x9E3779B1U % n_pages_);
    if (page < 3) return;
    const auto use = uses_.find(page);
    ASSERT_NE(use, uses_.end());
    if (--use->second == 0) uses_.erase(use);
  }
  void request(std::uint32_t page, float demand) {
    EXPECT_FALSE(here_.contains(page));
    EXPECT_GT(demand, 0);
    requested_.insert(page);
  }
  void forget_requests() {
    requested_.clear();
    promised_.clear();
  }
  [[nodiscard]] bool has_arrivals() const { return !arrived_.empty(); }
  void take_arrivals(std::vector<std::uint32_t>& out) {
    out.insert(out.end(), arrived_.begin(), arrived_.end());
    for (const std::uint32_t page : arrived_)
      if (promised_.contains(page)) promised_[page] = true;
    arrived_.clear();
  }
  bool drop_unclaimed() {
    return std::erase_if(promised_, [](const auto& promise) { return promise.second; }) > 0;
  }
  [[nodiscard]] std::size_t n_room() const { return room_; }
  [[nodiscard]] bool may_be_full() const { return room_ < n_pages_; }
  [[nodiscard]] bool is_over() const { return uses_.size() + promised_.size() > room_; }
  [[nodiscard]] std::size_t n_free() const {
    return room_ - std::min(room_, uses_.size() + promised_.size());
  }

  /// One of the pages that were asked for comes; one that nobody holds may go.
  bool deliver(std::mt19937& random) {
    if (requested_.empty()) return false;
    const auto page =
        std::next(requested_.begin(), static_cast<std::ptrdiff_t>(random() % requested_.size()));
    here_.insert(*page);
    arrived_.push_back(*page);
    requested_.erase(page);
    if (here_.size() <= room_) return true;
    const auto is_idle = [&](std::uint32_t other) {
      return !uses_.contains(other) && other != arrived_.back();
    };
    if (const auto idle = std::ranges::find_if(here_, is_idle); idle != here_.end())
      here_.erase(idle);
    return true;
  }
  void set_room(std::size_t room) { room_ = room; }
  [[nodiscard]] std::size_t n_held() const { return uses_.size(); }

 private:
  std::uint_fast32_t n_pages_;
  std::size_t room_;
  std::set<std::uint32_t> here_, requested_;
  std::map<std::uint32_t, bool> promised_;  ///< And whether they have come.
  std::map<std::uint32_t, int> uses_;
  std::vector<std::uint32_t> arrived_;
};

Demand some_isovalue(std::mt19937& random) {
  const auto isovalue = static_cast<double>(random() % 120);
  return isovalue_demand(isovalue, static_cast<double>(1 + random() % 40));
}

template <typename M>
class paged_engine : public ::testing::Test {
 protected:
  using Opened = decltype(std::declval<const M&>().refinable());

  struct Run {
    Slow<Opened> model;
    Engine<Slow<Opened>> engine;

    Run(const M& fixture, std::uint_fast32_t n_pages, std::size_t room = 1U << 30)
        : model(fixture.refinable(), n_pages, room), engine(model) {}
    Run(const Run&) = delete;

    /// Steps, and pages that come between them, one in `rarity`, until the answer is there.
    void finish(std::mt19937& random, std::uint_fast32_t rarity) {
      while (!engine.standing().is_settled) {
        if (engine.step()) {
          if (random() % rarity == 0) model.deliver(random);
          continue;
        }
        EXPECT_TRUE(engine.standing().awaits_data || engine.standing().is_settled);
        if (engine.standing().awaits_data) {
          EXPECT_FALSE(engine.step());
          EXPECT_TRUE(model.deliver(random)) << "waits for what it did not ask for";
        }
      }
    }
  };

  std::vector<NodeId> expected(const Demand& demand, Budget budget) const {
    auto model = fixture_.refinable();
    Engine<Opened> engine(model);
    engine.set_query(demand, budget);
    engine.finish();
    return engine.cut().applied();
  }

  M fixture_ = M::make(1, {2});
};

TYPED_TEST_SUITE(paged_engine, AllModels);

TYPED_TEST(paged_engine, finds_the_same_answer_whatever_comes_when) {
  std::mt19937 random(11);
  for (int trial = 0; trial < oracles::trials(400, 100); ++trial) {
    SCOPED_TRACE(trial);
    typename TestFixture::Run run(this->fixture_, 4 + random() % 80);
    const Demand demand = some_isovalue(random);
    Budget budget;
    if (trial % 4 != 0) budget.max_cells = 10 + random() % 900;
    run.engine.set_query(demand, budget);
    run.finish(random, 1 + random() % 60);
    ASSERT_EQ(run.engine.cut().applied(), this->expected(demand, budget));
  }
}

TYPED_TEST(paged_engine, answers_new_queries_while_it_waits) {
  std::mt19937 random(12);
  for (int start = 0; start < oracles::trials(8, 3); ++start) {
    typename TestFixture::Run run(this->fixture_, 20 + random() % 400);
    for (int trial = 0; trial < 30; ++trial) {
      SCOPED_TRACE(trial);
      const Demand demand = some_isovalue(random);
      Budget budget;
      if (trial % 3 != 0) budget.max_cells = 10 + random() % 900;
      run.engine.set_query(demand, budget);
      for (std::size_t n = random() % 200; n > 0 && run.engine.step(); --n) {
      }
      if (trial % 2 == 1) continue;
      run.finish(random, 1 + random() % 60);
      ASSERT_EQ(run.engine.cut().applied(), this->expected(demand, budget));
    }
  }
}

TYPED_TEST(paged_engine, refines_what_it_can_while_it_waits) {
  typename TestFixture::Run run(this->fixture_, 37);
  run.engine.set_query(isovalue_demand(60, 1));
  double bound = run.engine.standing().error_bound;
  while (run.engine.step()) {
    EXPECT_LE(run.engine.standing().error_bound, bound);
    bound = run.engine.standing().error_bound;
  }
  EXPECT_TRUE(run.engine.standing().awaits_data);
  EXPECT_FALSE(run.engine.standing().is_settled);
  for (const NodeId id : run.engine.cut().applied()) {
    std::vector<NodeId> parents;
    run.model.add_parents(id, parents);
    for (const NodeId parent : parents) EXPECT_TRUE(run.engine.cut().contains(parent));
  }
}

TYPED_TEST(paged_engine, holds_no_more_than_there_is_room_for_and_gives_that_to_what_matters_most) {
  std::mt19937 random(13);
  for (int trial = 0; trial < 100; ++trial) {
    SCOPED_TRACE(trial);
    const std::uint_fast32_t n_pages = 20 + random() % 60;
    const std::size_t room = 4 + random() % 30;
    typename TestFixture::Run run(this->fixture_, n_pages, room);
    // Tolerances fall and isovalues change, so that there is something to give up.
    for (int query = 0; query < 3; ++query) {
      const Demand demand = some_isovalue(random);
      run.engine.set_query(demand, {});
      for (std::uint64_t n = 0; !run.engine.standing().is_settled; ++n) {
        ASSERT_LT(n, 2'000'000U) << "never settles";
        if (run.engine.step()) {
          if (random() % 10 == 0) run.model.deliver(random);
        } else if (run.engine.standing().awaits_data) {
          ASSERT_TRUE(run.model.deliver(random)) << "waits for what it did not ask for";
        }
        ASSERT_LE(run.model.n_held(), room);
      }
      const std::vector<NodeId> wanted = this->expected(demand, {});
      if (run.engine.standing().memory_met) {
        ASSERT_EQ(run.engine.cut().applied(), wanted);
      } else {
        ASSERT_LT(run.engine.cut().n_applied(), wanted.size());
        EXPECT_GT(run.engine.standing().error_bound, 0);
      }
      for (const NodeId id : run.engine.cut().applied())
        ASSERT_TRUE(std::ranges::binary_search(wanted, id)) << "applied, but nobody wants it";
    }
  }
}

TYPED_TEST(paged_engine, gives_up_what_matters_least_when_others_come_and_gets_it_back) {
  std::mt19937 random(14);
  for (int trial = 0; trial < 30; ++trial) {
    SCOPED_TRACE(trial);
    typename TestFixture::Run run(this->fixture_, 60, 60);
    const Demand demand = isovalue_demand(60, 1);
    run.engine.set_query(demand, {});
    run.finish(random, 3);
    ASSERT_TRUE(run.engine.standing().memory_met);
    const double bound = run.engine.standing().error_bound;
    run.model.set_room(5 + random() % 20);
    while (run.engine.step()) {
    }
    EXPECT_FALSE(run.model.is_over());
    EXPECT_FALSE(run.engine.standing().memory_met);
    EXPECT_GE(run.engine.standing().error_bound, bound);
    run.model.set_room(60);
    do run.finish(random, 3);
    while (run.engine.step());
    EXPECT_TRUE(run.engine.standing().memory_met);
    ASSERT_EQ(run.engine.cut().applied(), this->expected(demand, {}));
  }
}

}  // namespace
}  // namespace lode::test
