// What the two models of vertex splits know of dependencies, compared step by step.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "tests/contract/split_models.h"

namespace lode::test {
namespace {

class split_models : public ::testing::Test {
 protected:
  SplitHierarchy hierarchy_ = build_split_hierarchy(1);
  ParentTable parents_ = find_parents(hierarchy_);

  [[nodiscard]] std::vector<Label> nodes() const {
    std::vector<Label> result;
    for (std::size_t i = 0; i < hierarchy_.splits.size(); ++i)
      result.push_back(hierarchy_.label(i));
    return result;
  }

  /// By tables.
  [[nodiscard]] bool can_split(const std::set<Label>& applied, Label v) const {
    const auto& needed = parents_[hierarchy_.place(v)];
    return applied.count(v) == 0 &&
           std::includes(applied.begin(), applied.end(), needed.begin(), needed.end());
  }
  [[nodiscard]] bool can_collapse(const std::set<Label>& applied, Label v) const {
    return applied.count(v) != 0 && std::none_of(applied.begin(), applied.end(), [&](Label other) {
             const auto& needed = parents_[hierarchy_.place(other)];
             return std::binary_search(needed.begin(), needed.end(), v);
           });
  }

  [[nodiscard]] std::set<Label> ancestors(Label v) const {
    std::set<Label> found;
    std::vector<Label> open{v};
    while (!open.empty()) {
      const auto& needed = parents_[hierarchy_.place(open.back())];
      open.pop_back();
      for (const Label parent : needed)
        if (found.insert(parent).second) open.push_back(parent);
    }
    return found;
  }

  /// Twelve by nine samples at a distance of one, and no triangle turned over.
  void expect_valid(const SplitMesh& mesh) const {
    double area = 0;
    for (const Triangle& triangle : mesh.triangles()) {
      EXPECT_GT(hierarchy_.signed_area(triangle), 0);
      area += hierarchy_.signed_area(triangle);
    }
    // Some 200 sums of numbers below 100.
    EXPECT_NEAR(area, 11 * 8, 200 * 100 * 0x1p-52);
  }

  /// Walks at random among consistent sets, mostly up or mostly down in turn, and calls
  /// body(model, applied) at each.
  template <typename F>
  void walk(std::uint32_t seed, const F& body) const {
    std::mt19937 random(seed);
    SplitLabels model(hierarchy_);
    std::set<Label> applied;
    for (int step = 0; step < 600; ++step) {
      body(model, applied);
      const bool is_up = random() % 8 != 0 ? step / 150 % 2 == 0 : random() % 2 == 0;
      std::vector<Label> possible;
      for (const Label v : nodes())
        if (is_up ? can_split(applied, v) : can_collapse(applied, v)) possible.push_back(v);
      if (possible.empty()) continue;
      const Label v = possible[random() % possible.size()];
      if (is_up) {
        model.apply(node_of(v));
        applied.insert(v);
      } else {
        model.undo(node_of(v));
        applied.erase(v);
      }
    }
  }
};

TEST_F(split_models, hierarchies_are_deep_and_their_dependencies_cross_the_forest) {
  EXPECT_GE(hierarchy_.splits.size(), 80U);
  EXPECT_LE(hierarchy_.base.size(), 24U);
  std::size_t n_crossing = 0;
  std::size_t most_ancestors = 0;
  for (const Label v : nodes()) {
    for (const Label parent : parents_[hierarchy_.place(v)])
      n_crossing += parent == hierarchy_.forest_parents[v] ? 0 : 1;
    most_ancestors = std::max(most_ancestors, ancestors(v).size());
  }
  EXPECT_GT(n_crossing, nodes().size());
  EXPECT_GT(most_ancestors, 20U);
}

TEST_F(split_models, a_node_depends_on_what_discovers_it_if_not_always_directly) {
  std::size_t n_indirect = 0;
  for (const Label v : nodes()) {
    const Label maker = hierarchy_.forest_parents[v];
    if (maker == kNoLabel) continue;
    EXPECT_EQ(ancestors(v).count(maker), 1U);
    const auto& needed = parents_[hierarchy_.place(v)];
    n_indirect += std::binary_search(needed.begin(), needed.end(), maker) ? 0 : 1;
  }
  EXPECT_GT(n_indirect, 0U);
}

TEST_F(split_models, labels_and_tables_allow_the_same_splits_and_collapses) {
  for (std::uint32_t seed = 0; seed < 4; ++seed)
    walk(seed, [&](const SplitLabels& model, const std::set<Label>& applied) {
      expect_valid(model.mesh());
      for (const Label v : nodes()) {
        ASSERT_EQ(model.can_split(node_of(v)), can_split(applied, v)) << v;
        ASSERT_EQ(model.can_collapse(node_of(v)), can_collapse(applied, v)) << v;
      }
    });
}

TEST_F(split_models, labels_find_the_same_star_whenever_a_split_is_possible) {
  walk(7, [&](const SplitLabels& model, const std::set<Label>&) {
    for (const Label v : nodes()) {
      if (!model.can_split(node_of(v))) continue;
      const auto& star = model.mesh().star(v);
      const auto& before = hierarchy_.split(v).before;
      ASSERT_EQ(star, std::set<Triangle>(before.begin(), before.end()));
    }
  });
}

TEST_F(split_models, labels_name_what_is_missing_first_and_the_whole_list_once_nothing_is) {
  std::size_t n_longer = 0;
  walk(9, [&](const SplitLabels& model, const std::set<Label>& applied) {
    for (const Label v : nodes()) {
      if (applied.count(v) != 0) continue;
      std::vector<NodeId> named;
      model.add_parents(node_of(v), named);
      std::set<Label> labels;
      for (const NodeId node : named) labels.insert(label_of(node));
      ASSERT_EQ(labels.size(), named.size());
      const std::set<Label> all = ancestors(v);
      ASSERT_TRUE(std::includes(all.begin(), all.end(), labels.begin(), labels.end()));
      const bool is_ready = can_split(applied, v);
      const auto is_applied = [&](Label w) { return applied.count(w) != 0; };
      if (!is_ready) {
        ASSERT_FALSE(labels.empty());
        ASSERT_TRUE(std::none_of(labels.begin(), labels.end(), is_applied));
        continue;
      }
      ASSERT_TRUE(std::all_of(labels.begin(), labels.end(), is_applied));
      const auto& table = parents_[hierarchy_.place(v)];
      ASSERT_TRUE(std::includes(labels.begin(), labels.end(), table.begin(), table.end()));
      n_longer += labels.size() > table.size() ? 1 : 0;
    }
  });
  EXPECT_GT(n_longer, 0U);
}

}  // namespace
}  // namespace lode::test
