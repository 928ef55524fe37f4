// The contract of every multiresolution model. The tests know nothing of any model; a model joins
// by one line in models.h.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "lode/refine/focus.h"
#include "lode/refine/one_shot.h"
#include "tests/contract/models.h"

namespace lode::test {
namespace {

template <typename M>
class contract : public ::testing::Test {
 protected:
  using Opened = decltype(std::declval<const M&>().refinable());
  using Parents = std::map<NodeId, std::vector<NodeId>>;

  M model_ = M::make(1, {2});

  /// A user's own demand, with no order in it: only the closure makes it a cut.
  static auto random_demand(std::uint32_t seed) {
    return [seed](const NodeFacts& facts) {
      const auto bits = static_cast<std::uint32_t>(std::hash<double>{}(
          facts.bounds.centre[0] * 7.1 + facts.bounds.centre[1] * 3.3 + facts.error + seed));
      return bits % 3 != 0 ? 1.0 : 0.0;
    };
  }

  static std::vector<NodeId> ids(const M& model, const Demand& demand) {
    auto refinable = model.refinable();
    return one_shot(refinable, demand).applied();
  }

  /// Calls body(node) for every node that discovery reaches.
  template <typename F>
  void for_each_node(const F& body) const {
    for (const NodeId node : ids(model_, uniform_demand(0))) body(node);
  }

  static std::vector<NodeId> parents_of(const Opened& model, NodeId node) {
    std::vector<NodeId> parents;
    model.add_parents(node, parents);
    return parents;
  }

  /// Takes a model from its base to a cut, and keeps each node's complete list.
  static Parents apply_all(Opened& model, const std::vector<NodeId>& nodes) {
    Parents result;
    const auto is_applied = [&](NodeId node) { return result.count(node) != 0; };
    std::set<NodeId> waiting(nodes.begin(), nodes.end());
    while (!waiting.empty()) {
      const std::size_t n_before = waiting.size();
      for (auto at = waiting.begin(); at != waiting.end();) {
        const auto parents = parents_of(model, *at);
        const bool is_ready = std::all_of(parents.begin(), parents.end(), is_applied);
        if (is_ready) {
          model.apply(*at);
          result.emplace(*at, parents);
        }
        at = is_ready ? waiting.erase(at) : std::next(at);
      }
      if (waiting.size() == n_before) {
        ADD_FAILURE() << "the nodes are no cut: nothing more can be applied";
        return result;
      }
    }
    return result;
  }

  static std::map<NodeId, int> count_dependents(const Parents& parents) {
    std::map<NodeId, int> result;
    for (const auto& [node, needed] : parents)
      for (const NodeId parent : needed) ++result[parent];
    return result;
  }
};

template <typename M>
class stored_contract : public contract<M> {
 protected:
  struct TemporaryFile {
    std::string path;
    TemporaryFile()
        : path((std::filesystem::temp_directory_path() /
                ("lode_contract_" + std::to_string(::getpid()) + ".lode"))
                   .string()) {}
    ~TemporaryFile() { std::filesystem::remove(path); }
  };
};

TYPED_TEST_SUITE(contract, AllModels);
TYPED_TEST_SUITE(stored_contract, StoredModels);

TYPED_TEST(contract, random_cuts_are_conforming) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    auto model = this->model_.refinable();
    const Cut cut = one_shot(model, this->random_demand(seed));
    const Mesh mesh = this->model_.mesh(model, cut);
    for (const auto& [face, n_cells] : mesh.faces()) {
      ASSERT_LE(n_cells, 2);
      if (n_cells == 1) {
        ASSERT_TRUE(this->model_.may_end_at(face)) << "a crack, seed " << seed;
      }
    }
  }
}

TYPED_TEST(contract, cuts_are_closed_under_parents) {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    auto model = this->model_.refinable();
    const Cut cut = one_shot(model, this->random_demand(seed));
    for (const NodeId node : cut.applied())
      for (const NodeId parent : this->parents_of(model, node)) ASSERT_TRUE(cut.contains(parent));
  }
}

TYPED_TEST(contract, parents_are_the_same_after_a_node_has_been_undone) {
  std::mt19937 random(3);
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    auto model = this->model_.refinable();
    const auto parents = this->apply_all(model, this->ids(this->model_, this->random_demand(seed)));
    auto n_dependents = this->count_dependents(parents);
    std::vector<NodeId> free;
    for (const auto& [node, needed] : parents)
      if (n_dependents[node] == 0) free.push_back(node);
    std::size_t n_undone = 0;
    for (; !free.empty(); ++n_undone) {
      std::swap(free[random() % free.size()], free.back());
      const NodeId node = free.back();
      free.pop_back();
      model.undo(node);
      ASSERT_EQ(this->parents_of(model, node), parents.at(node));
      for (const NodeId parent : parents.at(node))
        if (--n_dependents[parent] == 0) free.push_back(parent);
    }
    ASSERT_EQ(n_undone, parents.size());
  }
}

TYPED_TEST(contract, every_sample_is_within_the_tolerance_of_a_cut) {
  for (const double tolerance : {0.0, 10.0, 40.0, 90.0}) {
    auto model = this->model_.refinable();
    const Cut cut = one_shot(model, uniform_demand(tolerance));
    const Mesh mesh = this->model_.mesh(model, cut);
    for (const MeshVertex& sample : this->model_.samples()) {
      const auto value = mesh.value_at(sample.position);
      ASSERT_TRUE(value);
      ASSERT_LE(std::abs(*value - sample.value), tolerance + 1e-9);
    }
  }
}

TYPED_TEST(contract, attributes_are_nested_along_discovery) {
  auto model = this->model_.refinable();
  this->for_each_node([&](const auto& node) {
    const NodeFacts facts = facts_of(model, node);
    std::vector<NodeId> children;
    model.add_children(node, children);
    for (const NodeId child : children) {
      const NodeFacts below = facts_of(model, child);
      EXPECT_LE(below.error, facts.error);
      EXPECT_LE(below.world_error, facts.world_error);
      EXPECT_TRUE(facts.range.contains(below.range));
      EXPECT_TRUE(facts.bounds.contains(below.bounds));
      EXPECT_TRUE(facts.is_at_border || !below.is_at_border);
    }
  });
}

TYPED_TEST(contract, an_infinite_tolerance_leaves_the_base) {
  EXPECT_TRUE(this->ids(this->model_, uniform_demand(1e300)).empty());
}

TYPED_TEST(contract, a_cut_applies_nothing_that_is_not_needed) {
  for (const double tolerance : {5.0, 30.0, 60.0}) {
    auto model = this->model_.refinable();
    const Demand demand = uniform_demand(tolerance);
    const auto parents = this->apply_all(model, this->ids(this->model_, demand));
    auto n_dependents = this->count_dependents(parents);
    // Where errors are nested along parents, whatever is applied wants it itself; elsewhere at
    // least whatever could be undone.
    for (const auto& [node, needed] : parents)
      if (TypeParam::kIsNestedAlongParents || n_dependents[node] == 0) {
        EXPECT_GT(demand(facts_of(model, node)), 0);
      }
  }
}

TYPED_TEST(contract, a_smaller_tolerance_contains_a_larger_ones_cut) {
  auto coarse = this->ids(this->model_, isovalue_demand(60, 40));
  auto fine = this->ids(this->model_, isovalue_demand(60, 10));
  EXPECT_LT(coarse.size(), fine.size());
  EXPECT_TRUE(std::includes(fine.begin(), fine.end(), coarse.begin(), coarse.end()));
}

TYPED_TEST(stored_contract, any_number_of_threads_builds_the_same_model) {
  const TypeParam other = TypeParam::make(1, {1});
  for (const double tolerance : {0.0, 20.0})
    EXPECT_EQ(this->ids(this->model_, uniform_demand(tolerance)),
              this->ids(other, uniform_demand(tolerance)));
  const auto a = this->model_.refinable();
  const auto b = other.refinable();
  this->for_each_node([&](const auto& node) { EXPECT_EQ(a.facts(node), b.facts(node)); });
}

TYPED_TEST(stored_contract, saving_and_opening_is_the_identity) {
  const typename TestFixture::TemporaryFile file;
  ASSERT_TRUE(this->model_.save(file.path));
  const auto opened = TypeParam::open(file.path);
  ASSERT_TRUE(opened) << opened.error().message;
  const auto a = this->model_.refinable();
  const auto b = opened->refinable();
  this->for_each_node([&](const auto& node) { EXPECT_EQ(a.facts(node), b.facts(node)); });
  EXPECT_EQ(this->model_.samples().size(), opened->samples().size());
}

TYPED_TEST(stored_contract, a_flipped_byte_is_an_error_or_changes_nothing) {
  const typename TestFixture::TemporaryFile file;
  ASSERT_TRUE(this->model_.save(file.path));
  std::ifstream in(file.path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  in.close();
  std::mt19937 random(5);
  const auto expected = this->ids(this->model_, uniform_demand(20));
  for (int i = 0; i < 150; ++i) {
    std::string broken = bytes;
    broken[random() % broken.size()] ^= static_cast<char>(1 << (random() % 8));
    std::ofstream(file.path, std::ios::binary) << broken;
    const auto opened = TypeParam::open(file.path);
    if (opened) {
      EXPECT_EQ(this->ids(*opened, uniform_demand(20)), expected);
    } else {
      EXPECT_NE(opened.error().message.find(file.path), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace lode::test
