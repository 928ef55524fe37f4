#include "lode/refine/cut.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "lode/refine/error_counts.h"

namespace lode::test {
namespace {

TEST(cut, finds_what_was_inserted_and_not_erased) {
  std::mt19937_64 random(1);
  Cut cut;
  std::map<std::uint64_t, Cut::Place> expected;
  for (int i = 0; i < 200000; ++i) {
    // Ids that lie close together, and collide.
    const std::uint64_t id = random() % 3000 << (random() % 3 * 20);
    const auto found = expected.find(id);
    if (found == expected.end()) {
      expected[id] = cut.insert(NodeId{id}, {});
    } else if (random() % 2 == 0) {
      cut.erase(found->second);
      expected.erase(found);
    } else {
      cut.set_state(found->second, Cut::State::applied);
    }
    ASSERT_EQ(cut.size(), expected.size());
    const std::uint64_t other = random() % 3000 << (random() % 3 * 20);
    const auto there = expected.find(other);
    ASSERT_EQ(cut.find(NodeId{other}), there == expected.end() ? Cut::kNowhere : there->second);
  }
  std::size_t n_applied = 0;
  for (const auto& [id, at] : expected) n_applied += cut.contains(NodeId{id}) ? 1 : 0;
  EXPECT_EQ(n_applied, cut.n_applied());
  EXPECT_EQ(cut.applied().size(), n_applied);
}

TEST(error_counts, keep_the_largest_of_a_changing_set) {
  std::mt19937 random(2);
  ErrorCounts counts;
  std::multiset<float> errors;
  for (int i = 0; i < 20000; ++i) {
    if (errors.empty() || random() % 2 == 0) {
      const float error = random() % 50 == 0 ? std::numeric_limits<float>::infinity()
                                             : static_cast<float>(random() % 1000) / 64;
      counts.add(error);
      errors.insert(error);
    } else {
      const auto at =
          std::next(errors.begin(), static_cast<std::ptrdiff_t>(random() % errors.size()));
      counts.remove(*at);
      errors.erase(at);
    }
    const float largest = errors.empty() ? 0 : *errors.rbegin();
    ASSERT_GE(counts.largest(), largest);
    ASSERT_LE(counts.largest(), largest * (1 + 1.0F / 128));
  }
}

}  // namespace
}  // namespace lode::test
