// The engine's contract (architecture, section 4) over every model: the tests know none of them.

#include "lode/refine/engine.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "lode/refine/focus.h"
#include "tests/contract/models.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

template <typename M>
class engine : public ::testing::Test {
 protected:
  using Opened = decltype(std::declval<const M&>().refinable());

  /// An engine with its own opened model.
  struct Run {
    Opened model;
    Engine<Opened> engine;

    explicit Run(const M& fixture) : model(fixture.refinable()), engine(model) {}
    Run(const Run&) = delete;

    std::vector<NodeId> answer(const Demand& demand, Budget budget = {},
                               FocusChange focus = FocusChange::changed,
                               ApplyOrder apply_order = ApplyOrder::best_first) {
      engine.set_query(demand, budget, focus, apply_order);
      engine.finish();
      return engine.cut().applied();
    }
  };

  M fixture_ = M::make(1, {2});

  /// One of all kinds of query, by a random number.
  static Demand some_demand(std::mt19937& random) {
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random() % 10001) / 10000;
    };
    FocusDemand demand;
    demand.inside = uniform(0, 1) < 0.1 ? 0 : uniform(1, 90);
    if (random() % 3 == 0) demand.outside = demand.inside * uniform(0.5, 4);
    demand.ends_at_border = random() % 2 == 0;
    const Vec3d point{{uniform(-2, 20), uniform(-2, 12), uniform(-2, 22)}};
    switch (random() % 7) {
      case 0: demand.foci = {IsovalueFocus{{uniform(-10, 130), uniform(-10, 130)}}}; break;
      case 1: demand.foci = {IntervalFocus{{{uniform(0, 60), uniform(60, 125)}}}}; break;
      case 2: demand.foci = {BoxFocus{{point, point + Vec3d{{2, 3, 4}}}}}; break;
      case 3: demand.foci = {BallFocus{{point, uniform(0, 5)}}}; break;
      case 4: demand.foci = {HalfSpaceFocus{point, {{uniform(-1, 1), 0.3, 1}}}}; break;
      case 5: demand.foci = {SectionFocus{point, {{1, uniform(-1, 1), 0.1}}}}; break;
      default: break;
    }
    if (random() % 4 == 0)
      return max_of({demand, isovalue_demand(uniform(0, 120), uniform(1, 50))});
    return demand;
  }

  /// What the architecture says a budget's answer is, by definition: fresh, one node at a time.
  static std::vector<NodeId> prefix(const M& fixture, const Demand& demand,
                                    std::uint64_t max_cells) {
    Opened model = fixture.refinable();
    std::set<NodeId> applied;
    std::map<NodeId, float> candidates;
    const auto discover = [&](const std::vector<NodeId>& found) {
      for (const NodeId id : found) candidates[id] = to_rank(demand(facts_of(model, id)));
    };
    std::vector<NodeId> found;
    model.add_base(found);
    discover(found);
    std::uint64_t n_cells = model.n_base_cells();
    for (;;) {
      const NodeId* best = nullptr;
      float most = 0;
      for (const auto& [id, rank] : candidates)
        if (rank > most && !applied.contains(id)) {
          best = &id;
          most = rank;
        }
      if (best == nullptr) break;
      std::vector<NodeId> chain{*best};
      std::vector<NodeId> done;
      while (!chain.empty()) {
        const NodeId id = chain.back();
        std::vector<NodeId> parents;
        model.add_parents(id, parents);
        const std::size_t n = chain.size();
        for (const NodeId parent : parents)
          if (!applied.contains(parent)) chain.push_back(parent);
        if (chain.size() > n) continue;
        chain.pop_back();
        if (!applied.insert(id).second) continue;
        n_cells += model.apply(id);
        done.push_back(id);
      }
      if (n_cells > max_cells) {
        for (const NodeId id : done) applied.erase(id);
        break;
      }
      for (const NodeId id : done) {
        found.clear();
        model.add_children(id, found);
        discover(found);
      }
    }
    return {applied.begin(), applied.end()};
  }

  static void expect_consistent(const Run& run) {
    std::size_t n_checked = 0;
    for (const NodeId id : run.engine.cut().applied()) {
      std::vector<NodeId> parents;
      run.model.add_parents(id, parents);
      for (const NodeId parent : parents) ASSERT_TRUE(run.engine.cut().contains(parent));
      ++n_checked;
    }
    EXPECT_EQ(n_checked, run.engine.standing().n_applied);
  }

  /// By looking at every node that the cut discovers.
  static double error_bound(const Run& run, const Demand& demand) {
    std::vector<NodeId> found;
    run.model.add_base(found);
    for (const NodeId id : run.engine.cut().applied()) run.model.add_children(id, found);
    double bound = 0;
    for (const NodeId id : found) {
      const NodeFacts facts = facts_of(run.model, id);
      if (!run.engine.cut().contains(id) && demand.touches(facts))
        bound = std::max(bound, facts.error);
    }
    return bound;
  }
  /// Bounds are rounded up by at most 1/128.
  static void expect_bound(const Run& run, const Demand& demand) {
    const double expected = error_bound(run, demand);
    EXPECT_GE(run.engine.standing().error_bound, expected);
    EXPECT_LE(run.engine.standing().error_bound, expected * (1 + 1.0 / 128));
  }
};

TYPED_TEST_SUITE(engine, AllModels);

TYPED_TEST(engine, gives_the_one_shot_cut) {
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) {
    const Demand demand = this->some_demand(random);
    auto model = this->fixture_.refinable();
    const Cut expected = one_shot(model, demand);
    typename TestFixture::Run run(this->fixture_);
    EXPECT_EQ(run.answer(demand), expected.applied());
    EXPECT_TRUE(run.engine.standing().is_settled);
    EXPECT_TRUE(run.engine.standing().is_nested);
  }
}

TYPED_TEST(engine, gives_the_same_from_any_earlier_cut) {
  std::mt19937 random(2);
  typename TestFixture::Run moving(this->fixture_);
  for (int i = 0; i < oracles::trials(200, 60); ++i) {
    const Demand demand = this->some_demand(random);
    typename TestFixture::Run fresh(this->fixture_);
    ASSERT_EQ(moving.answer(demand), fresh.answer(demand)) << "query " << i;
    ASSERT_EQ(moving.engine.standing().n_cells, fresh.engine.standing().n_cells);
    ASSERT_EQ(moving.engine.standing().error_bound, fresh.engine.standing().error_bound);
  }
}

TYPED_TEST(engine, gives_the_same_in_whatever_order_nodes_are_applied) {
  std::mt19937 random(21);
  typename TestFixture::Run moving(this->fixture_);
  for (int i = 0; i < oracles::trials(200, 60); ++i) {
    const Demand demand = this->some_demand(random);
    typename TestFixture::Run fresh(this->fixture_);
    const auto order = random() % 3 == 0 ? ApplyOrder::best_first : ApplyOrder::nearest_first;
    const Budget budget = i % 8 == 0 ? Budget{random() % 20'000} : Budget{};
    ASSERT_EQ(moving.answer(demand, budget, FocusChange::changed, order),
              fresh.answer(demand, budget))
        << "query " << i;
    ASSERT_EQ(moving.engine.standing().n_cells, fresh.engine.standing().n_cells);
    ASSERT_EQ(moving.engine.standing().error_bound, fresh.engine.standing().error_bound);
  }
}

TYPED_TEST(engine, answers_a_budget_with_the_longest_prefix_of_one_order) {
  std::mt19937 random(3);
  typename TestFixture::Run moving(this->fixture_);
  const std::uint64_t base = moving.engine.standing().n_cells;
  for (int i = 0; i < 60; ++i) {
    const Demand demand = this->some_demand(random);
    const Budget budget{base + random() % 1200};
    const auto expected = this->prefix(this->fixture_, demand, budget.max_cells);
    typename TestFixture::Run fresh(this->fixture_);
    ASSERT_EQ(fresh.answer(demand, budget), expected) << "query " << i;
    ASSERT_LE(fresh.engine.standing().n_cells, budget.max_cells);
    ASSERT_EQ(moving.answer(demand, budget), expected) << "query " << i;
    ASSERT_TRUE(moving.engine.standing().budget_met);
    this->expect_consistent(moving);
  }
}

TYPED_TEST(engine, contains_smaller_budgets_in_larger_ones) {
  const Demand demand = isovalue_demand(60, 5);
  typename TestFixture::Run run(this->fixture_);
  std::vector<NodeId> smaller;
  double bound = std::numeric_limits<double>::infinity();
  for (std::uint64_t cells = 0; cells < 1500; cells += 37) {
    const auto larger = run.answer(demand, {cells}, FocusChange::same);
    EXPECT_TRUE(std::includes(larger.begin(), larger.end(), smaller.begin(), smaller.end()));
    EXPECT_LE(run.engine.standing().error_bound, bound);
    bound = run.engine.standing().error_bound;
    smaller = larger;
  }
}

TYPED_TEST(engine, leaves_the_base_where_the_budget_is_smaller) {
  typename TestFixture::Run run(this->fixture_);
  run.answer(uniform_demand(0));
  EXPECT_TRUE(run.answer(uniform_demand(0), {1}).empty());
  EXPECT_FALSE(run.engine.standing().budget_met);
  EXPECT_TRUE(run.engine.standing().is_settled);
}

TYPED_TEST(engine, stays_consistent_after_every_step) {
  std::mt19937 random(4);
  typename TestFixture::Run run(this->fixture_);
  for (int i = 0; i < 12; ++i) {
    const Budget budget =
        random() % 2 == 0 ? Budget{} : Budget{run.model.n_base_cells() + random() % 400};
    run.engine.set_query(this->some_demand(random), budget);
    while (run.engine.step())
      if (random() % 7 == 0) this->expect_consistent(run);
    const Mesh mesh = this->fixture_.mesh(run.model, run.engine.cut());
    for (const auto& [face, n_cells] : mesh.faces()) {
      ASSERT_LE(n_cells, 2);
      if (n_cells == 1) {
        ASSERT_TRUE(this->fixture_.may_end_at(face)) << "a crack, query " << i;
      }
    }
    ASSERT_EQ(mesh.cells.size(), run.engine.standing().n_cells);
  }
}

TYPED_TEST(engine, survives_changes_of_the_query_at_any_step) {
  std::mt19937 random(5);
  typename TestFixture::Run run(this->fixture_);
  Demand demand;
  for (int i = 0; i < oracles::trials(10000, 2000); ++i) {
    const bool is_same = random() % 3 == 0;
    if (!is_same) demand = this->some_demand(random);
    const Budget budget = random() % 2 == 0 ? Budget{} : Budget{random() % 2000};
    run.engine.set_query(demand, budget, is_same ? FocusChange::same : FocusChange::changed);
    for (std::size_t n = random() % 30; n > 0 && run.engine.step(); --n) {
    }
    if (i % 20 == 0) this->expect_consistent(run);
    if (i % 200 != 0) continue;
    typename TestFixture::Run fresh(this->fixture_);
    run.engine.finish();
    ASSERT_EQ(run.engine.cut().applied(), fresh.answer(demand, budget)) << "change " << i;
    this->expect_bound(run, demand);
  }
}

TYPED_TEST(engine, knows_its_error_bound_after_every_step) {
  typename TestFixture::Run run(this->fixture_);
  const Demand demand = isovalue_demand(60, 3);
  run.engine.set_query(demand);
  double last = std::numeric_limits<double>::infinity();
  int i = 0;
  while (run.engine.step()) {
    const double bound = run.engine.standing().error_bound;
    EXPECT_LE(bound, last);
    last = bound;
    if (++i % 50 == 0) this->expect_bound(run, demand);
  }
  EXPECT_LE(last, 3.0 * (1 + 1.0 / 128));
}

TYPED_TEST(engine, repeats_an_interrupted_answer_from_its_number_of_steps) {
  std::mt19937 random(6);
  for (int i = 0; i < 20; ++i) {
    const Demand demand = this->some_demand(random);
    typename TestFixture::Run first(this->fixture_);
    typename TestFixture::Run second(this->fixture_);
    std::uint64_t ticks = random() % 500;
    first.engine.set_query(demand);
    first.engine.run([&] { return ticks-- == 0; });  // a clock of steps
    const std::uint64_t n_steps = first.engine.standing().n_steps;
    second.engine.set_query(demand);
    second.engine.run([&] { return second.engine.standing().n_steps == n_steps; });
    EXPECT_EQ(first.engine.cut().applied(), second.engine.cut().applied());
  }
}

TYPED_TEST(engine, does_nothing_at_a_deadline_of_zero) {
  typename TestFixture::Run run(this->fixture_);
  run.engine.set_query(uniform_demand(0));
  run.engine.run([] { return true; });
  EXPECT_EQ(run.engine.standing().n_applied, 0U);
  EXPECT_FALSE(run.engine.standing().is_settled);
  EXPECT_GT(run.engine.standing().error_bound, 0);
}

TYPED_TEST(engine, drags_an_isovalue_through_the_range_as_fresh_queries_do) {
  typename TestFixture::Run dragged(this->fixture_);
  for (double isovalue = -5; isovalue < 130; isovalue += 1.7) {
    typename TestFixture::Run fresh(this->fixture_);
    ASSERT_EQ(dragged.answer(isovalue_demand(isovalue, 10)),
              fresh.answer(isovalue_demand(isovalue, 10)));
  }
}

TYPED_TEST(engine, never_promises_too_much_after_a_new_query) {
  std::mt19937 random(8);
  typename TestFixture::Run run(this->fixture_);
  run.answer(this->some_demand(random));
  for (int i = 0; i < oracles::trials(30, 12); ++i) {
    const Demand demand = this->some_demand(random);
    const Budget budget = random() % 3 == 0 ? Budget{random() % 2000} : Budget{};
    run.engine.set_query(demand, budget);
    do {
      ASSERT_GE(run.engine.standing().error_bound, this->error_bound(run, demand));
    } while (random() % 40 != 0 && run.engine.step());
  }
}

TYPED_TEST(engine, takes_demands_below_zero_for_none) {
  typename TestFixture::Run run(this->fixture_);
  run.answer(uniform_demand(1));
  EXPECT_TRUE(run.answer([](const NodeFacts& node) { return -1 - node.error; }).empty());
  EXPECT_TRUE(run.answer([](const NodeFacts&) { return -0.0; }).empty());
  run.answer([](const NodeFacts& node) { return node.error - 20; },
             {run.model.n_base_cells() + 50});
  EXPECT_LE(run.engine.standing().n_cells, run.model.n_base_cells() + 50);
}

TYPED_TEST(engine, is_never_over_a_budget_that_the_base_meets) {
  typename TestFixture::Run run(this->fixture_);
  const Budget budget{run.model.n_base_cells() + 61};
  run.engine.set_query(uniform_demand(0), budget);
  while (run.engine.step()) ASSERT_LE(run.engine.standing().n_cells, budget.max_cells);
}

TYPED_TEST(engine, answers_queries_that_change_before_all_is_evaluated) {
  typename TestFixture::Run run(this->fixture_);
  run.answer(uniform_demand(0));
  const std::size_t n_all = run.engine.standing().n_applied;
  for (int i = 0; i < 2000; ++i) {
    run.engine.set_query(isovalue_demand(60, 30 + i % 2), {}, FocusChange::same);
    for (int k = 0; k < 3; ++k) run.engine.step();
  }
  EXPECT_LT(run.engine.standing().n_applied, n_all);
}

TYPED_TEST(engine, undoes_what_it_applied) {
  typename TestFixture::Run run(this->fixture_);
  const auto base = run.engine.standing().n_cells;
  run.answer(uniform_demand(0));
  EXPECT_GT(run.engine.standing().n_applied, 100U);
  EXPECT_TRUE(run.answer(uniform_demand(1e300)).empty());
  EXPECT_EQ(run.engine.standing().n_cells, base);
}

TYPED_TEST(engine, says_when_a_demand_is_not_monotone) {
  typename TestFixture::Run run(this->fixture_);
  run.answer([](const NodeFacts& node) { return 1000 - node.error; });
  EXPECT_FALSE(run.engine.standing().is_nested);
}

}  // namespace
}  // namespace lode::test
