// Labels, pages of nodes of midpoints, and their bytes.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "lode/models/tetra_mt/midpoint/field_blocks.h"
#include "lode/models/tetra_mt/midpoint/forest_blocks.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/midpoint_fixtures.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Cut;
using oracles::noise_mesh;
using oracles::Random;

/// With regions, and values that steps do not hold.
TetraMesh mixed_mesh(int n) {
  TetraMesh mesh = noise_mesh(n, Cut::in_six, 6);
  mesh.region_ids = {3, 5, 9};
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(centre[0] < 0.5 ? 0 : centre[1] < 0.34 ? 1 : 2);
  }
  return mesh;
}

TEST(midpoint_pages, table_finds_every_node_and_leaf) {
  Random random(5);
  std::vector<PageCounts> counts;
  for (int page = 0; page < 40; ++page) {
    PageCounts& made = counts.emplace_back();
    made.n_leaves = static_cast<std::uint32_t>(random.below(30));
    auto epoch = static_cast<std::uint32_t>(random.below(9));
    for (std::size_t g = 0; g <= random.below(6); ++g) {
      made.groups.push_back({epoch, 1 + static_cast<std::uint32_t>(random.below(40))});
      epoch += 1 + static_cast<std::uint32_t>(random.below(3));
    }
  }
  const PageTable table(7, counts);
  std::uint32_t n_nodes = 0;
  std::pair<std::uint32_t, std::uint32_t> last{0, 0};
  std::vector<std::uint32_t> next(counts.size(), 0);
  for (std::uint32_t node = 0; node < table.n_nodes(); ++node) {
    const auto [page, place] = table.locate(node);
    EXPECT_LT(place, table.n_nodes_of(page));
    EXPECT_EQ(table.node_at(page, place), node);
    EXPECT_EQ(place, next[page]++);
    std::uint32_t end = 0;
    std::uint32_t epoch = 0;
    for (const PageCounts::Group& group : counts[page].groups)
      if (end <= place) {
        end += group.n;
        epoch = group.epoch;
      }
    const std::pair<std::uint32_t, std::uint32_t> here{epoch, 40 - page};
    EXPECT_GE(here, last);
    last = here;
    ++n_nodes;
  }
  EXPECT_EQ(n_nodes, table.n_nodes());
  for (std::uint32_t page = 0; page < counts.size(); ++page) {
    EXPECT_EQ(next[page], table.n_nodes_of(page));
    EXPECT_EQ(table.first_leaf(page) + counts[page].n_leaves, table.first_leaf(page + 1));
    for (std::uint32_t leaf = table.first_leaf(page); leaf < table.first_leaf(page + 1); ++leaf)
      EXPECT_EQ(table.page_of_leaf(leaf), page);
  }
}

TEST(midpoint_pages, labels_fall_along_splits_and_are_there_once) {
  const Hierarchy hierarchy = test::midpoints_of(mixed_mesh(15), 200);
  std::set<std::uint32_t> seen(hierarchy.roots.begin(), hierarchy.roots.end());
  EXPECT_EQ(seen.size(), hierarchy.roots.size());
  for (std::uint32_t node = 0; node < hierarchy.n_nodes(); ++node) {
    const auto [first, second] = hierarchy.children(node);
    EXPECT_LT(first, hierarchy.n_vertices + node);
    EXPECT_LT(second, first);
    EXPECT_TRUE(seen.insert(first).second);
    EXPECT_TRUE(seen.insert(second).second);
    EXPECT_EQ(hierarchy.parent(first), hierarchy.n_vertices + node);
    EXPECT_EQ(hierarchy.parent(second), hierarchy.n_vertices + node);
  }
  EXPECT_EQ(seen.size(), hierarchy.n_labels());
  std::set<std::uint32_t> vertices(hierarchy.mesh_vertices.begin(), hierarchy.mesh_vertices.end());
  EXPECT_EQ(vertices.size(), hierarchy.n_vertices);
}

TEST(midpoint_pages, bits_give_all_back) {
  TetraMesh mesh = mixed_mesh(18);
  mesh.positions[40] = mesh.positions[40] * (1 + 0x1p-50);
  const Hierarchy hierarchy = test::midpoints_of(mesh, 200);
  ASSERT_GT(hierarchy.pages.n_pages(), 10U);
  ASSERT_FALSE(hierarchy.mixed_nodes.empty());
  ASSERT_GT(hierarchy.exact.size(), 0U);
  std::uint32_t n_nodes = 0;
  for (std::uint32_t page = 0; page < hierarchy.pages.n_pages(); ++page) {
    const ForestContent content = content_of(hierarchy, page);
    n_nodes += content.n_nodes();
    const auto bytes = encode_page(content, hierarchy, page);
    const auto read = decode_page(bytes, "page", hierarchy, page);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(*read, content);
    // As pages have them in memory.
    const ForestPage packed(content, hierarchy.pages, page, hierarchy.n_vertices);
    for (std::uint32_t place = 0; place < content.n_nodes(); ++place) {
      EXPECT_EQ(packed.record(place), content.records[place]);
      EXPECT_EQ(packed.children(place), content.children[place]);
      EXPECT_EQ(packed.parent(place), content.parents[place]);
      EXPECT_TRUE(std::ranges::equal(packed.regions(place), content.regions[place]));
    }
  }
  EXPECT_EQ(n_nodes, hierarchy.n_nodes());
  std::vector<PageCounts> pages;
  const auto table = encode_table(hierarchy.page_counts);
  ASSERT_TRUE(decode_table(table, "table", hierarchy.pages.n_pages(), pages));
  EXPECT_EQ(pages, hierarchy.page_counts);
}

TEST(midpoint_pages, bits_give_fields_back) {
  const TetraMesh mesh = test::with_fields(mixed_mesh(15));
  const Hierarchy hierarchy = test::midpoints_of(mesh, 200);
  std::size_t n_exact = 0;
  for (std::size_t f = 1; f < mesh.fields.size(); ++f) {
    const FurtherField& field = hierarchy.further[f - 1];
    n_exact += field.exact.size();
    for (std::uint32_t page = 0; page < hierarchy.pages.n_pages(); ++page) {
      const ForestPage nodes(content_of(hierarchy, page), hierarchy.pages, page,
                             hierarchy.n_vertices);
      const FieldPage content = field_page_of(hierarchy, nodes, field, page);
      const auto bytes = encode_field_page(content, hierarchy, hierarchy.fields[f], page, nodes);
      const auto read =
          decode_field_page(bytes, "page", hierarchy, hierarchy.fields[f], page, nodes);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(*read, content);
    }
    const auto bytes = encode_field_roots(field.roots, hierarchy, 0, hierarchy.roots.size());
    StreamReader in(bytes, "roots");
    FieldRoots roots;
    ASSERT_TRUE(
        read_field_roots(in, hierarchy.roots.size(), hierarchy, hierarchy.fields[f], roots));
    EXPECT_EQ(roots, field.roots);
  }
  EXPECT_GT(n_exact, 1000U);
}

TEST(midpoint_pages, any_bytes_of_fields_are_read_as_something_or_refused) {
  const Hierarchy hierarchy = test::midpoints_of(test::with_fields(mixed_mesh(12)), 200);
  Random random(8);
  int n_read = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const auto page = static_cast<std::uint32_t>(random.below(hierarchy.pages.n_pages()));
    const std::size_t f = 1 + random.below(hierarchy.further.size());
    const ForestField& head = hierarchy.fields[f];
    const ForestPage nodes(content_of(hierarchy, page), hierarchy.pages, page,
                           hierarchy.n_vertices);
    auto bytes = encode_field_page(field_page_of(hierarchy, nodes, hierarchy.further[f - 1], page),
                                   hierarchy, head, page, nodes);
    bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1 + random.below(255));
    if (trial % 5 == 0) bytes.resize(random.below(bytes.size()));
    const auto read = decode_field_page(bytes, "page", hierarchy, head, page, nodes);
    if (read) {
      ++n_read;
      EXPECT_EQ(read->nodes.size(), hierarchy.pages.n_nodes_of(page));
      for (const FieldPage::Node& node : read->nodes)
        for (const std::uint32_t word : node.child_facts) {
          EXPECT_EQ(word, NodeCodes::without_ball(word));
          EXPECT_TRUE(head.codes.has_range(NodeCodes::parts(word)));
        }
      for (const std::uint32_t leaf : read->exact.leaves())
        EXPECT_LE(std::abs(*read->exact.find(leaf)), head.scale.step());
    }
    auto columns =
        encode_field_roots(hierarchy.further[f - 1].roots, hierarchy, 0, hierarchy.roots.size());
    columns[random.below(columns.size())] ^= static_cast<std::byte>(1 + random.below(255));
    StreamReader in(columns, "roots");
    FieldRoots roots;
    if (!read_field_roots(in, hierarchy.roots.size(), hierarchy, head, roots)) continue;
    EXPECT_EQ(roots.codes.size(), hierarchy.roots.size());
    EXPECT_TRUE(std::ranges::all_of(roots.codes, [](std::int32_t code) { return code >= 0; }));
  }
  EXPECT_GT(n_read, 5);
}

TEST(midpoint_pages, any_bytes_are_read_as_something_or_refused) {
  const Hierarchy hierarchy = test::midpoints_of(mixed_mesh(14), 200);
  Random random(3);
  const auto some_page = [&] {
    return static_cast<std::uint32_t>(random.below(hierarchy.pages.n_pages()));
  };
  int n_read = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const std::uint32_t page = some_page();
    auto bytes = encode_page(content_of(hierarchy, page), hierarchy, page);
    if (trial % 3 == 0) {
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(random.below(256));
    } else {
      // What comes last decides nothing of what is before.
      const std::size_t n_last = trial % 3 == 1 ? bytes.size() : 20;
      bytes[bytes.size() - 1 - random.below(n_last)] ^=
          static_cast<std::byte>(1 + random.below(255));
    }
    if (trial % 5 == 0) bytes.resize(random.below(bytes.size()));
    const auto read = decode_page(bytes, "page", hierarchy, page);
    if (!read) continue;
    ++n_read;
    const ForestPage packed(*read, hierarchy.pages, page, hierarchy.n_vertices);
    EXPECT_EQ(read->n_nodes(), hierarchy.pages.n_nodes_of(page));
    for (std::uint32_t place = 0; place < read->n_nodes(); ++place) {
      const std::uint32_t label = hierarchy.n_vertices + hierarchy.pages.node_at(page, place);
      EXPECT_LT(packed.children(place).first, label);
      EXPECT_LT(packed.children(place).second, packed.children(place).first);
      EXPECT_GT(packed.parent(place), label);
    }
    std::vector<PageCounts> pages;
    static_cast<void>(decode_table(bytes, "table", 20, pages).has_value());
  }
  EXPECT_GT(n_read, 5);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
