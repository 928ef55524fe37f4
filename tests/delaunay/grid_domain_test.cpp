#include "lode/delaunay/grid_domain.h"

#include "lode/delaunay/lattice_mesh.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::delaunay {
namespace {

HeightGrid flat(std::int32_t n_columns, std::int32_t n_rows) {
  return test::make_grid<std::int16_t>(n_columns, n_rows,
                                       [](std::int32_t, std::int32_t) { return 0; });
}

Tin triangulate(const HeightGrid& grid, const GridDomain& domain) {
  return to_tin(LatticeMesh(LatticePacking(grid.n_columns), domain.triangles));
}

TEST(grid_domain, of_a_whole_lattice_is_two_triangles) {
  for (const auto& [n_columns, n_rows] : {std::pair{2, 2}, {2, 9}, {17, 2}, {30, 40}}) {
    const HeightGrid grid = flat(n_columns, n_rows);
    const auto domain = find_domain(grid);
    ASSERT_TRUE(domain) << domain.error().message;
    EXPECT_EQ(domain->triangles.size(), 2U);
    EXPECT_EQ(domain->n_samples, static_cast<std::uint64_t>(n_columns * n_rows));
    test::expect_fills(triangulate(grid, *domain), grid);
  }
}

TEST(grid_domain, has_the_outline_exactly_whatever_is_missing) {
  oracles::Random random(11);
  int n_with_cells = 0;
  for (int round = 0; round < 120; ++round) {
    const auto n_columns = static_cast<std::int32_t>(2 + random.below(14));
    const auto n_rows = static_cast<std::int32_t>(2 + random.below(14));
    HeightGrid grid = flat(n_columns, n_rows);
    // From a few holes to a few islands that touch at corners.
    const std::uint64_t n_missing =
        random.below(static_cast<std::uint64_t>(n_columns * n_rows) / (1 + random.below(6)) + 1) +
        1;
    for (std::uint64_t i = 0; i < n_missing; ++i)
      test::set_missing(
          grid, static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_columns))),
          static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(n_rows))));
    std::uint64_t n_cells = 0;
    std::set<std::pair<std::int32_t, std::int32_t>> samples;
    for (std::int32_t y = 0; y + 1 < n_rows; ++y)
      for (std::int32_t x = 0; x + 1 < n_columns; ++x)
        if (test::has_cell(grid, x, y)) {
          ++n_cells;
          samples.insert({{x, y}, {x + 1, y}, {x, y + 1}, {x + 1, y + 1}});
        }
    const auto domain = find_domain(grid);
    ASSERT_EQ(domain.has_value(), n_cells > 0);
    if (n_cells == 0) continue;
    ++n_with_cells;
    EXPECT_EQ(domain->n_cells, n_cells);
    EXPECT_EQ(domain->n_samples, samples.size());
    EXPECT_EQ(domain->n_samples + domain->n_left_out + grid.n_missing(),
              static_cast<std::uint64_t>(grid.n_samples()));
    const Tin tin = triangulate(grid, *domain);
    test::expect_fills(tin, grid);
    test::expect_locally_delaunay(tin);
  }
  EXPECT_GT(n_with_cells, 60);
}

TEST(grid_domain, refuses_what_spans_no_area_and_says_why) {
  HeightGrid nothing = flat(5, 4);
  for (std::int32_t y = 0; y < 4; ++y)
    for (std::int32_t x = 0; x < 5; ++x) test::set_missing(nothing, x, y);
  for (const auto& [grid, words] : {std::pair{flat(1, 1), "1 x 1"},
                                    {flat(1, 9), "1 x 9"},
                                    {flat(9, 1), "9 x 1"},
                                    {nothing, "20 of 20 samples are missing"}}) {
    const auto domain = find_domain(grid);
    ASSERT_FALSE(domain);
    EXPECT_NE(domain.error().message.find(words), std::string::npos) << domain.error().message;
  }
}

}  // namespace
}  // namespace lode::delaunay
