#include "lode/delaunay/triangle_rows.h"

#include "tests/delaunay/lattice_fixtures.h"

namespace lode::delaunay {
namespace {

using Nodes = std::set<std::pair<std::int32_t, std::int32_t>>;

/// By the signs of areas; of columns and rows that are multiples of 2^bits, in such steps.
Nodes nodes_in(const std::array<LatticePoint, 3>& v, std::int32_t size, int bits) {
  Nodes nodes;
  for (std::int32_t y = 0; (y << bits) < size; ++y)
    for (std::int32_t x = 0; (x << bits) < size; ++x) {
      const LatticePoint p{x << bits, y << bits};
      if (doubled_area(v[0], v[1], p) >= 0 && doubled_area(v[1], v[2], p) >= 0 &&
          doubled_area(v[2], v[0], p) >= 0)
        nodes.insert({x, y});
    }
  return nodes;
}

template <typename Rows>
Nodes nodes_of(Rows rows) {
  Nodes nodes;
  for (; rows.has_row(); rows.next())
    for (std::int32_t x = rows.first(); x <= rows.last(); ++x)
      EXPECT_TRUE(nodes.insert({x, rows.y()}).second);
  return nodes;
}

TEST(triangle_rows, have_exactly_the_nodes_of_the_closed_triangle_all_or_sparse) {
  oracles::Random random(2);
  for (int round = 0; round < 3000; ++round) {
    const std::uint64_t size = 2 + random.below(round % 10 == 0 ? 80 : 12);
    std::array<LatticePoint, 3> v{};
    for (LatticePoint& p : v)
      p = {static_cast<std::int32_t>(random.below(size)),
           static_cast<std::int32_t>(random.below(size))};
    if (doubled_area(v[0], v[1], v[2]) < 0) std::swap(v[1], v[2]);
    if (doubled_area(v[0], v[1], v[2]) == 0) continue;
    const auto limit = static_cast<std::int32_t>(size);
    EXPECT_EQ(nodes_of(TriangleRows(v[0], v[1], v[2])), nodes_in(v, limit, 0));
    for (const int bits : {1, 2, 4})
      EXPECT_EQ(nodes_of(SparseRows(v[0], v[1], v[2], bits)), nodes_in(v, limit, bits));
  }
}

TEST(triangle_rows, that_skip_go_on_as_if_every_row_had_been_looked_at) {
  oracles::Random random(3);
  for (int round = 0; round < 2000; ++round) {
    std::array<LatticePoint, 3> v{};
    for (LatticePoint& p : v)
      p = {static_cast<std::int32_t>(random.below(90)),
           static_cast<std::int32_t>(random.below(30))};
    if (doubled_area(v[0], v[1], v[2]) < 0) std::swap(v[1], v[2]);
    if (doubled_area(v[0], v[1], v[2]) == 0) continue;
    const auto row = static_cast<std::int32_t>(random.below(30));
    const std::int32_t top = std::max({v[0].y, v[1].y, v[2].y});
    TriangleRows rows(v[0], v[1], v[2]);
    for (auto steps = random.below(3); steps > 0 && rows.y() < top; --steps) rows.next();
    Nodes expected = nodes_of(rows);
    if (row <= top) std::erase_if(expected, [&](const auto& node) { return node.second < row; });
    rows.skip_to(row);
    EXPECT_EQ(nodes_of(rows), expected) << "to row " << row;
  }
}

}  // namespace
}  // namespace lode::delaunay
