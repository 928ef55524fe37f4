#include "lode/mappers/box_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace lode {
namespace {

std::vector<Box3f> random_boxes(std::size_t n, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<Box3f> boxes(n);
  for (Box3f& box : boxes) {
    // Sizes over three orders of magnitude.
    const float size = 0.3F * std::pow(unit(random), 6.0F);
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] = unit(random);
      box.upper[i] = box.lower[i] + size * unit(random);
    }
  }
  return boxes;
}

bool do_meet(const Box3f& a, const Box3f& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (a.lower[i] > b.upper[i] || b.lower[i] > a.upper[i]) return false;
  return true;
}

TEST(box_pairs, finds_each_meeting_pair_once) {
  std::mt19937 random(1);
  for (const std::size_t n : {1U, 2U, 7U, 8U, 9U, 17U, 64U, 65U, 1000U}) {
    const auto boxes = random_boxes(n, random);
    std::vector<IndexPair> expected;
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = i + 1; j < n; ++j)
        if (do_meet(boxes[i], boxes[j])) expected.push_back({i, j});
    for (const int threads : {1, 3}) {
      std::vector<std::vector<IndexPair>> found(static_cast<std::size_t>(threads));
      Progress progress;
      ASSERT_TRUE(visit_box_pairs(boxes, {threads}, progress, [&](auto pairs, int worker) {
        auto& own = found[static_cast<std::size_t>(worker)];
        own.insert(own.end(), pairs.begin(), pairs.end());
      }));
      std::vector<IndexPair> all;
      for (const auto& own : found) all.insert(all.end(), own.begin(), own.end());
      std::sort(all.begin(), all.end());
      EXPECT_EQ(all, expected) << n << " boxes, " << threads << " threads";
    }
  }
}

TEST(box_pairs, stops_when_cancelled) {
  std::mt19937 random(2);
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(visit_box_pairs(random_boxes(100, random), {1}, progress, [](auto, int) {}));
}

}  // namespace
}  // namespace lode
