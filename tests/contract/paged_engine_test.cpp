// The engine over models whose data come late: whatever comes when, the answer is the same.

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/contract/models.h"

namespace lode::test {
namespace {

/// A model whose nodes each need one of `n_pages`; which have come the test decides.
template <typename M>
class Slow : public M {
 public:
  Slow(M model, std::uint_fast32_t n_pages) : M(std::move(model)), n_pages_(n_pages) {}

  [[nodiscard]] std::optional<std::uint32_t> missing(NodeId id) const {
    const auto page =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(id) * 0x9E3779B1U % n_pages_);
    if (page < 3 || here_.contains(page)) return {};
    return page;
  }
  void request(std::uint32_t page, float demand) {
    EXPECT_FALSE(here_.contains(page));
    EXPECT_GT(demand, 0);
    requested_.insert(page);
  }
  void forget_requests() { requested_.clear(); }
  [[nodiscard]] bool has_arrivals() const { return !arrived_.empty(); }
  void take_arrivals(std::vector<std::uint32_t>& out) {
    out.insert(out.end(), arrived_.begin(), arrived_.end());
    arrived_.clear();
  }

  /// One of the pages that were asked for comes.
  bool deliver(std::mt19937& random) {
    if (requested_.empty()) return false;
    const auto page =
        std::next(requested_.begin(), static_cast<std::ptrdiff_t>(random() % requested_.size()));
    here_.insert(*page);
    arrived_.push_back(*page);
    requested_.erase(page);
    return true;
  }

 private:
  std::uint_fast32_t n_pages_;
  std::set<std::uint32_t> here_, requested_;
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

    Run(const M& fixture, std::uint_fast32_t n_pages)
        : model(fixture.refinable(), n_pages), engine(model) {}
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
  for (int trial = 0; trial < 400; ++trial) {
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
  for (int start = 0; start < 8; ++start) {
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

}  // namespace
}  // namespace lode::test
