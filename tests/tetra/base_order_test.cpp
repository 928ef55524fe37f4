// The base of a file as bits, and the order in which it takes few.

#include "lode/models/tetra_mt/base_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/file_fixtures.h"
#include "tests/tetra/region_meshes.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;

const std::string kWhat = "block";

/// By sorted corners and whether these are an even permutation, with maker and region.
using Turned = std::tuple<Tetrahedron, bool, std::uint32_t, std::uint32_t>;
std::vector<Turned> turned(const BaseTetrahedra& base) {
  std::vector<Turned> all;
  for (std::size_t i = 0; i < base.corners.size(); ++i) {
    Tetrahedron sorted = base.corners[i];
    bool is_even = true;
    for (std::size_t n = 0; n < 4; ++n)  // bubbles
      for (std::size_t k = 0; k + 1 < 4; ++k)
        if (sorted[k] > sorted[k + 1]) {
          std::swap(sorted[k], sorted[k + 1]);
          is_even = !is_even;
        }
    all.emplace_back(sorted, is_even, base.makers[i], base.regions.empty() ? 0 : base.regions[i]);
  }
  std::ranges::sort(all);
  return all;
}

/// In any order, turned in any way that leaves their orientation.
BaseTetrahedra shuffled(const BaseTetrahedra& base, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::size_t> order(base.corners.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  BaseTetrahedra result;
  for (const std::size_t i : order) {
    Tetrahedron t = base.corners[i];
    for (std::uint64_t n = random.below(3); n > 0; --n)
      std::rotate(t.begin() + 1, t.begin() + 2, t.end());
    if (random.below(2) == 0) {
      std::swap(t[0], t[1]);
      std::swap(t[2], t[3]);
    }
    result.corners.push_back(t);
    result.makers.push_back(base.makers[i]);
    if (!base.regions.empty()) result.regions.push_back(base.regions[i]);
  }
  return result;
}

struct Case {
  BaseTetrahedra base;
  BaseLimits limits;
};

Case case_of(const Hierarchy& hierarchy) {
  Case one{{hierarchy.base, hierarchy.base_makers, hierarchy.base_regions},
           {.n_vertices = hierarchy.n_base_vertices,
            .outside = hierarchy.outside(),
            .n_nodes = hierarchy.n_nodes()}};
  if (!hierarchy.base_regions.empty())
    one.limits.n_labels = {static_cast<std::uint32_t>(hierarchy.region_ids.size()),
                           static_cast<std::uint32_t>(hierarchy.patches.size()) + 1};
  return one;
}

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back(case_of(test::hierarchy_of(test::noise(), 300)));
  all.push_back(case_of(test::hierarchy_of(test::noise(), 1000000)));  // nothing collapses
  for (const TetraMesh& mesh : {test::random_regions(8, 5, 4, 2), test::scattered_regions(6, 0.3)})
    all.push_back(case_of(test::hierarchy_of(mesh, 100)));
  // Any four corners: faces of many tetrahedra, the same tetrahedron twice, many components.
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    Case any{{}, {.n_vertices = seed % 2 == 0 ? 9U : 3000000U, .outside = 4000000, .n_nodes = 50}};
    any.limits.n_labels = {3, 4};
    for (int i = 0; i < 200; ++i) {
      Tetrahedron t{};
      for (std::size_t k = 0; k < 4;) {
        t[k] = random.below(9) == 0 ? any.limits.outside
                                    : static_cast<std::uint32_t>(random.below(9)) *
                                          ((any.limits.n_vertices - 1) / 8);
        if (std::find(t.begin(), t.begin() + k, t[k]) == t.begin() + static_cast<long>(k)) ++k;
      }
      const bool is_outer = std::ranges::find(t, any.limits.outside) != t.end();
      any.base.corners.push_back(t);
      any.base.makers.push_back(
          random.below(4) == 0 ? kNone : static_cast<std::uint32_t>(random.below(50)));
      any.base.regions.push_back(static_cast<std::uint32_t>(random.below(is_outer ? 4 : 3)));
    }
    all.push_back(std::move(any));
  }
  all.push_back({{}, {.n_vertices = 4, .outside = 4}});
  all.push_back({{{{2, 0, 1, 3}}, {kNone}, {}}, {.n_vertices = 4, .outside = 4}});
  return all;
}

TEST(base_order, has_the_same_tetrahedra_turned_alike) {
  for (const Case& one : cases()) {
    const BaseTetrahedra ordered = in_base_order(shuffled(one.base, 1));
    EXPECT_EQ(turned(ordered), turned(one.base));
    EXPECT_EQ(in_base_order(ordered), ordered);
  }
}

TEST(base_bytes, say_any_base_in_any_order) {
  for (const Case& one : cases())
    for (const BaseTetrahedra& base : {one.base, shuffled(one.base, 2), in_base_order(one.base)}) {
      const auto bytes = encode_base(base, one.limits);
      const auto found = decode_base(bytes, base.corners.size(), one.limits, kWhat);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(*found, base);
    }
}

TEST(base_bytes, are_few_in_the_base_order) {
  const Case one = case_of(test::hierarchy_of(test::noise(), 1000000));
  EXPECT_EQ(in_base_order(one.base), one.base) << "hierarchies have it";
  const std::size_t n = encode_base(one.base, one.limits).size();
  EXPECT_LT(n, one.base.corners.size() / 2);
  EXPECT_LT(8 * n, encode_base(shuffled(one.base, 3), one.limits).size());
}

TEST(base_bytes, of_no_base_are_refused_or_read_as_one) {
  Random random(1);
  int n_refused = 0;
  for (const Case& one : cases()) {
    const auto bytes = encode_base(one.base, one.limits);
    for (int trial = 0; trial < 60 && !bytes.empty(); ++trial) {
      std::vector<std::byte> changed = bytes;
      changed[random.below(changed.size())] ^= static_cast<std::byte>(1 + random.below(255));
      const std::size_t n = one.base.corners.size() + random.below(3);
      const auto found = decode_base(changed, n, one.limits, kWhat);
      n_refused += found ? 0 : 1;
      if (!found) {
        EXPECT_EQ(found.error().message.find(kWhat), 0U) << found.error().message;
        continue;
      }
      ASSERT_EQ(found->corners.size(), n);
      for (std::size_t i = 0; i < n; ++i) {
        Tetrahedron t = found->corners[i];
        const bool is_outer = std::ranges::find(t, one.limits.outside) != t.end();
        for (const std::uint32_t v : t)
          EXPECT_TRUE(v < one.limits.n_vertices || v == one.limits.outside);
        std::ranges::sort(t);
        EXPECT_EQ(std::ranges::adjacent_find(t), t.end());
        EXPECT_TRUE(found->makers[i] < one.limits.n_nodes || found->makers[i] == kNone);
        if (one.limits.has_labels()) EXPECT_LT(found->regions[i], one.limits.n_labels[is_outer]);
      }
    }
  }
  EXPECT_GT(n_refused, 0);
}

}  // namespace
}  // namespace lode::tetra_mt
