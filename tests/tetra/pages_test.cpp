// Codes of hierarchies, and pages of them.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "lode/models/tetra_mt/gradient_codes.h"
#include "lode/models/tetra_mt/page_blocks.h"
#include "lode/models/tetra_mt/page_gradients.h"
#include "lode/models/tetra_mt/page_primers.h"
#include "tests/oracles/random.h"
#include "tests/tetra/file_fixtures.h"

namespace lode::tetra_mt {
namespace {

using oracles::Random;
using test::hierarchy_of;
using test::noise;

TEST(value_scale, codes_are_outside_of_values_and_close_also_beside_outliers) {
  Random random(3);
  std::vector<double> values;
  for (int i = 0; i < 20'000; ++i) values.push_back(random.uniform(-1, 3));
  for (int i = 0; i < 5'000; ++i) values.push_back(0.5);
  values.push_back(1e20);
  const ValueScale scale = ValueScale::of(values);
  for (std::size_t i = 0; i < values.size(); i += 7) {
    const double below = scale.value(scale.code_below(values[i]));
    const double above = scale.value(scale.code_above(values[i]));
    EXPECT_LE(below, values[i]);
    EXPECT_GE(above, values[i]);
    if (values[i] < 2.9) {
      EXPECT_LT(above - below, 0.003);
    }
  }
  for (std::uint16_t code = 1; code <= ValueScale::kLargest; ++code)
    EXPECT_GE(scale.value(code), scale.value(code - 1));
  EXPECT_EQ(scale.value(0), std::ranges::min(values));
  EXPECT_EQ(scale.value(ValueScale::kLargest), 1e20);
  EXPECT_EQ(scale.error(scale.error_code(0)), 0);
  for (const float error : {1e19F, 3.3e12F, 1e20F}) {
    EXPECT_GE(scale.error(scale.error_code(error)), error);
    EXPECT_LE(scale.error(scale.error_code(error)), error * 1.008F);
  }
  EXPECT_GT(scale.error(scale.error_code(1e-9F)), 0);
}

TEST(gradient_codes, point_where_gradients_do) {
  Random random(2);
  for (int trial = 0; trial < 20'000; ++trial) {
    const double size = std::exp2(random.uniform(-60, 0));
    Vec3f g;
    for (std::size_t i = 0; i < 3; ++i) g[i] = static_cast<float>(size * random.uniform(-1, 1));
    if (trial % 5 == 0) g[trial % 3] = 0;
    if (trial % 7 == 0) g[trial / 3 % 3] = 0;
    const Vec3f found = gradient_of(gradient_code(g));
    const Vec3d wide_wanted{{g[0], g[1], g[2]}};
    const Vec3d wide_found{{found[0], found[1], found[2]}};
    if (length(wide_wanted) == 0) {
      EXPECT_EQ(found, Vec3f());
      continue;
    }
    const Vec3d off = normalized(wide_wanted) - normalized(wide_found);
    EXPECT_LT(length(off), 1.7e-3);
    if (length(wide_wanted) > 0x1p-60) {
      EXPECT_GE(length(wide_wanted), 0.999 * length(wide_found));
      EXPECT_LE(length(wide_wanted), 1.251 * length(wide_found));
    }
  }
  EXPECT_EQ(gradient_of(gradient_code({})), Vec3f());
  for (std::size_t i = 0; i < 3; ++i)
    for (const float sign : {-1.0F, 1.0F}) {
      Vec3f axis;
      axis[i] = sign;
      EXPECT_EQ(gradient_of(gradient_code(axis)), axis);
    }
}

TEST(box_codes, hold_boxes_closely_and_nest) {
  Random random(8);
  const Vec3d lower{{-3, 10, 1e6}};
  const Vec3d upper{{5, 10.5, 1e6 + 3}};
  const BoxCodes codes(lower, upper);
  const auto point = [&] {
    Vec3d p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = random.uniform(lower[i], upper[i]);
    return p;
  };
  const auto holds = [](const Box3d& outer, const Box3d& inner) {
    for (std::size_t i = 0; i < 3; ++i)
      if (outer.lower[i] > inner.lower[i] || outer.upper[i] < inner.upper[i]) return false;
    return true;
  };
  for (int trial = 0; trial < 20'000; ++trial) {
    const Vec3d vertex = point();
    const double share = std::pow(random.uniform(0, 1), 6);
    Box3d box{vertex, vertex};
    double width = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      box.lower[i] -= share * (vertex[i] - lower[i]);
      box.upper[i] += share * (upper[i] - vertex[i]);
      width = std::max(width, box.upper[i] - box.lower[i]);
    }
    const Box3d found = codes.box(vertex, codes.code(vertex, box));
    EXPECT_TRUE(holds(found, box));
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LE(found.upper[i] - found.lower[i], box.upper[i] - box.lower[i] + 0.6 * width + 0.002);
    // Round another vertex of it, it holds what was found here.
    Box3d joined = found;
    const Vec3d other = point();
    for (std::size_t i = 0; i < 3; ++i) {
      joined.lower[i] = std::min(joined.lower[i], other[i]);
      joined.upper[i] = std::max(joined.upper[i], other[i]);
    }
    EXPECT_TRUE(holds(codes.box(other, codes.code(other, joined)), found));
  }
  // Beyond a line by less than what is left of it where the domain's corner is taken away.
  const BoxCodes round_zero({{-6, -6, -6}}, {{6, 6, 6}});
  for (const double beyond : {4e-16, 5e-324}) {
    const Box3d upward{{{-2, -2, -2}}, {{beyond, beyond, beyond}}};
    const Box3d downward{{{-beyond, -beyond, -beyond}}, {{2, 2, 2}}};
    const Vec3d low{{-1, -1, -1}};
    const Vec3d high{{1, 1, 1}};
    EXPECT_TRUE(holds(round_zero.box(low, round_zero.code(low, upward)), upward));
    EXPECT_TRUE(holds(round_zero.box(high, round_zero.code(high, downward)), downward));
  }
  const BoxCodes none({{1, 1, 1}}, {{1, 1, 1}});
  EXPECT_EQ(none.box({{1, 1, 1}}, 0), (Box3d{{{1, 1, 1}}, {{1, 1, 1}}}));
}

TEST(box_codes, have_lines_of_any_domain_and_coordinate) {
  const Vec3d origin;
  const double least = std::numeric_limits<double>::denorm_min();
  const BoxCodes narrow(origin, {{least, least, 0}});  // which no steps divide
  EXPECT_EQ(narrow.lines_round({origin, {{least, least, 0}}}, 15), BoxCodes::Lines{.exponent = 15});
  EXPECT_EQ(narrow.lines(origin, 15), BoxCodes::Lines{});
  const BoxCodes codes(origin, {{1, 1, 1}});
  const BoxCodes::Lines far = codes.lines_round({{{-1e300, 0, 0}}, {{0, 1e300, 0.5}}}, 15);
  EXPECT_EQ(far.lower, (std::array{-(1 << 20), 0, 0}));
  EXPECT_EQ(far.upper, (std::array{0, 1 << 20, 1 << 13}));
}

TEST(tetra_pages, come_back_from_their_bytes) {
  const TetraMesh mesh = noise();
  const Hierarchy hierarchy = hierarchy_of(mesh, 300);
  const HierarchyHead head = head_of(hierarchy, mesh.tetrahedra.size());
  ASSERT_GT(head.shape.n_pages(), 3U);
  // Models are as pages before left them: both ways alike.
  LinkModels written{};
  LinkModels read{};
  FieldModels written_field{};
  FieldModels read_field{};
  for (std::uint32_t page = 0; page < head.shape.n_pages(); ++page) {
    const PageContent content = content_of(hierarchy, page);
    PageContent found;
    soften(written);
    soften(read);
    const auto links = encode_links(content, page, head.shape, written);
    const auto decoded = decode_links(links, "page", page, head.shape, read, found);
    ASSERT_TRUE(decoded) << decoded.error().message;
    EXPECT_EQ(found, content);
    const NumberedField field = field_of(hierarchy, 0);
    const ValueScale scale = base_of(field, head.shape).scale;
    const FieldContent values = content_of(field, scale, head.shape, page);
    ASSERT_EQ(values.values.size(), content.n_nodes());
    const PageTree tree = PageTree::of(content, page);
    const bool is_narrow = head.fields[0].has_narrow_values;
    soften(written_field);
    soften(read_field);
    const auto bytes = encode_field(values, scale, tree, is_narrow, written_field);
    const auto again = decode_field(bytes, "page", scale, tree, is_narrow, read_field);
    ASSERT_TRUE(again);
    EXPECT_EQ(*again, values);
    const FieldPage packed(values, head.fields[0].has_narrow_values);
    for (std::uint32_t i = 0; i < content.n_nodes(); ++i) {
      EXPECT_EQ(packed.value(i), values.values[i]);
      EXPECT_EQ(packed.facts(i), values.facts[i]);
    }
  }
}

TEST(page_primers, are_few_spread_and_of_any_number_of_pages) {
  EXPECT_TRUE(primers_of(0).empty());
  for (const std::uint32_t n : {1U, 2U, 3U, 5U, 508U, 0xFFFFFFFFU}) {
    const auto primers = primers_of(n);
    EXPECT_EQ(primers.size(), std::min(n, kMostPrimers));
    EXPECT_TRUE(std::ranges::is_sorted(primers, std::less_equal()));
    EXPECT_LT(primers.back(), n);
    if (n > 100) EXPECT_EQ(primers[0], n / 6);
  }
  const auto taught = Primers<BitModel, std::uint32_t>::of(
      5, [](std::uint32_t page, BitModel& model) -> Result<std::uint32_t> {
        EXPECT_LE(model.n_seen, kMostTaught);
        for (int i = 0; i < 40; ++i) model.learn(false);
        return 10 * page;
      });
  ASSERT_NE(taught->models(), nullptr);
  EXPECT_EQ(taught->models()->n_seen, kMostTaught);
  EXPECT_GT(taught->models()->zero, 60000);
  EXPECT_EQ(*taught->find(4), 40U);
  EXPECT_EQ(taught->find(1), nullptr);
  EXPECT_FALSE((Primers<BitModel, int>::of(
      9, [](std::uint32_t page, BitModel&) -> Result<int> { return fail("page {}", page); })));
}

/// Each node discovers the one before, and has most nodes of its block: all of them wait for all.
TEST(tetra_pages, with_children_that_all_have_come_back_soon) {
  const PageShape shape{.n_base_vertices = 4, .n_nodes = kPageNodes};
  constexpr std::uint32_t kBlock = 100;
  PageContent content;
  for (std::uint32_t i = 0; i < kPageNodes; ++i) {
    content.positions.push_back({{1.0 * i, 0, 0}});
    content.boxes.push_back(0);
    content.targets.push_back(0);
    const std::uint32_t begin = i / kBlock * kBlock;
    if (i > 0) content.children.items.push_back(i - 1);
    for (std::uint32_t k = begin; k + 1 < i; ++k) content.children.items.push_back(k);
    content.children.end_list();
    content.n_discovered.push_back(i > 0 ? 1 : 0);
    for (std::uint32_t k = 0; k < content.children[i].size(); ++k)
      content.makers.items.push_back(static_cast<std::uint8_t>(k));
    content.makers.end_list();
    content.regions.end_list();
  }
  for (std::uint32_t i = 0; i < kPageNodes; ++i) {
    const std::uint32_t end = std::min(kPageNodes, (i / kBlock + 1) * kBlock + 1);
    for (std::uint32_t k = i + 1; k < end; ++k) {
      const auto children = content.children[k];
      if (std::ranges::find(children, i) != children.end()) content.parents.items.push_back(k);
    }
    content.parents.end_list();
  }
  LinkModels models{};
  const auto bytes = encode_links(content, 0, shape, models);
  models = {};
  PageContent found;
  ASSERT_TRUE(decode_links(bytes, "page", 0, shape, models, found));
  EXPECT_EQ(found, content);
}

/// What whole pages take is what this is for: of noise, whose links are the most random.
TEST(page_primers, make_pages_smaller) {
  const Hierarchy hierarchy = hierarchy_of(noise(), 300);
  const PageShape shape = head_of(hierarchy, 1).shape;
  std::size_t n_alone = 0;
  std::size_t n_taught = 0;
  const auto primers = Primers<LinkModels, int>::of(
      shape.n_pages(), [&](std::uint32_t page, LinkModels& models) -> Result<int> {
        static_cast<void>(encode_links(content_of(hierarchy, page), page, shape, models));
        return 0;
      });
  for (std::uint32_t page = 0; page < shape.n_pages(); ++page) {
    if (primers->find(page) != nullptr) continue;
    LinkModels alone{};
    LinkModels taught = *primers->models();
    n_alone += encode_links(content_of(hierarchy, page), page, shape, alone).size();
    n_taught += encode_links(content_of(hierarchy, page), page, shape, taught).size();
  }
  EXPECT_LT(n_taught, n_alone - n_alone / 50);
}

TEST(page_gradients, come_back_and_others_are_refused) {
  Random random(7);
  std::vector<std::uint32_t> codes{0, 255U << 24 | 2500U << 12 | 2500U, 0, 1U << 24};
  while (codes.size() < 600)
    codes.push_back(gradient_code(
        {{static_cast<float>(random.uniform(-1, 1)), static_cast<float>(random.uniform(-1, 1)),
          static_cast<float>(random.uniform(-9, 9))}}));
  GradientModels written{};
  const auto bytes = encode_gradients(codes, written);
  GradientModels read{};
  const auto found = decode_gradients(bytes, codes.size(), "page", read);
  ASSERT_TRUE(found);
  EXPECT_EQ(*found, codes);
  int n_refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    auto others = bytes;
    others[random.below(others.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (trial % 5 == 0) others.resize(random.below(others.size()));
    read = {};
    const auto came = decode_gradients(others, codes.size(), "page", read);
    if (!came) ++n_refused;
    for (const std::uint32_t code : came ? *came : codes)
      EXPECT_TRUE((code & 4095) <= kGradientSteps && (code >> 12 & 4095) <= kGradientSteps);
  }
  EXPECT_GT(n_refused, 300);
}

/// Nodes with so many links to other pages that their bits take more than 255 bytes, which is told
/// before them.
TEST(tetra_pages, hold_nodes_with_more_links_than_a_byte_counts) {
  const PageShape shape{.n_base_vertices = 64, .n_nodes = 64 * kPageNodes};
  constexpr std::uint32_t kPage = 3;
  PageContent content;
  for (std::uint32_t i = 0; i < 70; ++i) {
    content.positions.push_back({{0.5 * i, 1, 2}});
    content.boxes.push_back(i);
    content.targets.push_back(i % 64);
    const bool is_long = i == 5 || i == 20 || i == 31 || i == 69;
    for (std::uint32_t k = 0; is_long && k < kMaxBrought; ++k)
      content.children.items.push_back(7 * k % 500 + kPageNodes * (4 + k % 59));
    const auto begin = content.children.items.begin() + content.children.begins.back();
    std::sort(begin, content.children.items.end());
    content.children.items.erase(std::unique(begin, content.children.items.end()),
                                 content.children.items.end());
    content.children.end_list();
    const std::size_t n = content.children[i].size();
    content.n_discovered.push_back(static_cast<std::uint8_t>(n));
    content.parents.end_list();
    for (std::uint32_t k = 0; k < n; ++k)
      content.makers.items.push_back(static_cast<std::uint8_t>((7 * k) % n));
    content.makers.end_list();
    content.regions.end_list();
  }
  const NodePage page(content, kPage, shape);
  for (std::uint32_t i = 0; i < content.n_nodes(); ++i) {
    EXPECT_EQ(page.position(i), content.positions[i]);
    EXPECT_EQ(page.box(i), content.boxes[i]) << i;
    NodePage::Links links = page.links(i);
    EXPECT_EQ(links.target(), content.targets[i]) << i;
    ASSERT_EQ(links.n_children(), content.children[i].size()) << i;
    for (const std::uint32_t child : content.children[i]) EXPECT_EQ(links.next_node(), child);
    links.start_makers();
    const std::size_t n_makers = content.makers[i].size();
    EXPECT_TRUE(links.have_makers(n_makers)) << i;
    // Of a bit or more each.
    if (content.children[i].size() > 1) EXPECT_FALSE(links.have_makers(n_makers + 8)) << i;
    for (const std::uint8_t maker : content.makers[i]) EXPECT_EQ(links.next_maker(), maker);
  }
}

TEST(tetra_pages, refuse_bytes_that_are_not_theirs) {
  const Hierarchy hierarchy = hierarchy_of(noise(), 300);
  const HierarchyHead head = head_of(hierarchy, 1);
  const PageContent content = content_of(hierarchy, 1);
  LinkModels models{};
  const auto links = encode_links(content, 1, head.shape, models);
  Random random(1);
  int n_refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    auto bytes = links;
    for (std::size_t k = 0; k <= random.below(3); ++k)
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (trial % 5 == 0) bytes.resize(random.below(bytes.size()));
    PageContent found;
    models = {};
    if (!decode_links(bytes, "page", 1, head.shape, models, found))
      ++n_refused;
    else
      static_cast<void>(NodePage(found, 1, head.shape).n_bytes());
  }
  EXPECT_GT(n_refused, 1000);
}

}  // namespace
}  // namespace lode::tetra_mt
