#include "lode/delaunay/lattice_mesh.h"

#include <numeric>

#include "lode/delaunay/predicates.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::delaunay {
namespace {

Point to_point(LatticePoint p) { return {{static_cast<double>(p.x), static_cast<double>(p.y)}}; }

LatticePoint random_point(oracles::Random& random, std::uint64_t size) {
  return {static_cast<std::int32_t>(random.below(size)),
          static_cast<std::int32_t>(random.below(size))};
}

TEST(lattice_predicates, agree_with_exact_numbers_at_every_size) {
  oracles::Random random(1);
  for (const std::uint64_t size : {3U, 5U, 100U, 1U << 14U, 1U << 16U, 1U << 24U, 1U << 30U})
    for (int i = 0; i < 400; ++i) {
      std::array<LatticePoint, 4> p{};
      for (LatticePoint& point : p) point = random_point(random, size);
      // Cocircular and collinear ones come by themselves only where the lattice is small.
      if (i % 4 == 1) p[3] = {p[0].x + p[2].x - p[1].x, p[0].y + p[2].y - p[1].y};
      if (i % 4 == 2) p[3] = p[static_cast<std::size_t>(i / 4) % 3];
      const std::int64_t area = doubled_area(p[0], p[1], p[2]);
      EXPECT_EQ((area > 0) - (area < 0),
                orientation(to_point(p[0]), to_point(p[1]), to_point(p[2])));
      if (area <= 0) continue;
      EXPECT_EQ(is_in_circle(p[0], p[1], p[2], p[3]),
                side_of_circle(to_point(p[0]), to_point(p[1]), to_point(p[2]), to_point(p[3])) > 0);
      EXPECT_EQ(is_in_circle(p[0], p[1], p[2], p[3]),
                test::circle_sign(p[0], p[1], p[2], p[3]) > 0);
    }
}

TEST(lattice_packing, keeps_rows_in_order_and_refuses_what_does_not_fit) {
  for (const std::int32_t n_columns : {2, 3, 1024, 1025}) {
    const LatticePacking packing(n_columns);
    std::uint32_t last = 0;
    for (std::int32_t y = 0; y < 3; ++y)
      for (const std::int32_t x : {0, 1, n_columns - 1}) {
        const LatticePoint p{x, y};
        EXPECT_EQ(packing.unpack(packing.pack(p)), p);
        EXPECT_GE(packing.pack(p), last);
        last = packing.pack(p);
      }
  }
  EXPECT_TRUE(LatticePacking::fits(65536, 65536));
  EXPECT_FALSE(LatticePacking::fits(65537, 65536));
  EXPECT_TRUE(LatticePacking::fits(1 << 24, 256));
  EXPECT_FALSE(LatticePacking::fits((1 << 24) + 1, 2));
}

/// Inserts nodes in any order, each into the triangle that holds it, and looks at all of it.
void insert_all(std::int32_t n_columns, std::int32_t n_rows, std::vector<LatticePoint> nodes) {
  const HeightGrid grid = test::make_grid<std::int16_t>(
      n_columns, n_rows, [](std::int32_t, std::int32_t) { return 0; });
  const LatticePacking packing(n_columns);
  const LatticePoint far{n_columns - 1, n_rows - 1};
  const auto corner = [&](std::int32_t x, std::int32_t y) { return packing.pack({x, y}); };
  const std::vector<std::array<std::uint32_t, 3>> base{
      {corner(0, 0), corner(far.x, 0), corner(far.x, far.y)},
      {corner(0, 0), corner(far.x, far.y), corner(0, far.y)}};
  LatticeMesh mesh(packing, base);
  std::set<std::uint32_t> inserted{corner(0, 0), corner(far.x, 0), corner(0, far.y),
                                   corner(far.x, far.y)};
  std::uint64_t n_on_outline = 4;
  for (const LatticePoint& p : nodes) {
    if (!inserted.insert(packing.pack(p)).second) continue;
    const bool is_outer = p.x == 0 || p.y == 0 || p.x == far.x || p.y == far.y;
    n_on_outline += static_cast<std::uint64_t>(is_outer);
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
      std::array<LatticePoint, 3> v{};
      for (std::size_t i = 0; i < 3; ++i) v[i] = packing.unpack(mesh.triangles()[t].corner[i]);
      if (doubled_area(v[0], v[1], p) < 0 || doubled_area(v[1], v[2], p) < 0 ||
          doubled_area(v[2], v[0], p) < 0)
        continue;
      EXPECT_EQ(mesh.growth(packing.pack(p), t), is_outer ? 1U : 2U);
      const std::size_t n_before = mesh.triangles().size();
      (void)mesh.insert(packing.pack(p), t);
      EXPECT_EQ(mesh.triangles().size(), n_before + (is_outer ? 1 : 2));
      break;
    }
  }
  const Tin tin = to_tin(mesh);
  EXPECT_EQ(tin.vertices.size(), inserted.size());
  // Euler: V - E + F = 1 without the outer face, and 3 F = 2 E - (edges of the outline).
  EXPECT_EQ(tin.triangles.size(), 2 * tin.vertices.size() - 2 - n_on_outline);
  test::expect_fills(tin, grid);
  test::expect_empty_circles(tin);
}

TEST(lattice_mesh, is_delaunay_whatever_is_inserted_in_whatever_order) {
  oracles::Random random(7);
  for (int round = 0; round < 30; ++round) {
    const auto n_columns = static_cast<std::int32_t>(2 + random.below(30));
    const auto n_rows = static_cast<std::int32_t>(2 + random.below(30));
    std::vector<LatticePoint> nodes;
    for (std::uint64_t i = random.below(80); i > 0; --i)
      nodes.push_back(
          {static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_columns))),
           static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_rows)))});
    insert_all(n_columns, n_rows, nodes);
  }
}

TEST(lattice_mesh, takes_all_nodes_of_a_lattice_which_are_cocircular_everywhere) {
  std::vector<LatticePoint> nodes;
  for (std::int32_t y = 0; y < 9; ++y)
    for (std::int32_t x = 0; x < 9; ++x) nodes.push_back({x, y});
  insert_all(9, 9, nodes);
  std::reverse(nodes.begin(), nodes.end());
  insert_all(9, 9, nodes);
}

TEST(lattice_mesh, is_delaunay_where_circles_need_more_than_64_bits) {
  constexpr std::int32_t kSide = 20000;
  oracles::Random random(3);
  std::vector<LatticePoint> nodes;
  for (int i = 0; i < 60; ++i) nodes.push_back(random_point(random, kSide));
  const LatticePacking packing(kSide);
  const std::uint32_t a = packing.pack({0, 0});
  const std::uint32_t c = packing.pack({kSide - 1, kSide - 1});
  LatticeMesh mesh(packing,
                   std::vector<std::array<std::uint32_t, 3>>{{a, packing.pack({kSide - 1, 0}), c},
                                                             {a, c, packing.pack({0, kSide - 1})}});
  for (const LatticePoint& p : nodes)
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
      std::array<LatticePoint, 3> v{};
      for (std::size_t i = 0; i < 3; ++i) v[i] = packing.unpack(mesh.triangles()[t].corner[i]);
      if (doubled_area(v[0], v[1], p) < 0 || doubled_area(v[1], v[2], p) < 0 ||
          doubled_area(v[2], v[0], p) < 0)
        continue;
      (void)mesh.insert(packing.pack(p), t);
      break;
    }
  const Tin tin = to_tin(mesh);
  EXPECT_EQ(tin.vertices.size(), nodes.size() + 4);
  test::expect_empty_circles(tin);
}

}  // namespace
}  // namespace lode::delaunay
