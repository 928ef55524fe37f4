// Rasters that go round the earth: surfaces of them have the same vertices on both sides.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include "lode/api/built_terrain.h"
#include "lode/api/round_terrain.h"
#include "lode/api/terrain.h"
#include "lode/api/terrain_tin.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode {
namespace {

constexpr std::int32_t kTurn = 72;
constexpr std::int32_t kRows = 61;

HorizontalMetric metric() {
  return {.is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
}

bool has_gaps(std::uint32_t seed) { return seed % 2 == 1; }

/// Rough, with gaps beside the seam on one side, on the other, and on both.
template <typename T>
HeightGrid wrapped_globe(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> rough(-100, 100);
  HeightGrid grid = test::make_grid<T>(kTurn, kRows, [&](int x, int y) {
    const double z = 300 * std::sin(0.1 * y) * std::cos(x * 0.2) + rough(random);
    return std::is_integral_v<T> ? std::round(z) : z;
  });
  grid.to_world = {0, 5, 0, 75, 0, -2.5};
  if (has_gaps(seed)) {
    for (const auto& [x, y] : {std::pair{1, 9}, {kTurn - 1, 20}, {1, 33}, {kTurn - 1, 33}, {0, 45}})
      delaunay::test::set_missing(grid, x, y);
  }
  return cut_open_at(grid, kTurn, 0);
}

std::set<int> rows_at(const Surface& surface, const HeightGrid& grid, double column) {
  std::set<int> rows;
  for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
    const Vec3d p = surface.world_position(v);
    const Vec<double, 2> at = grid.lattice(p[0], p[1]);
    if (std::abs(at[0] - column) < 0.1) rows.insert(static_cast<int>(std::lround(at[1])));
  }
  return rows;
}

/// Rows on either side where cells are on both.
bool has_cells_on_both(const HeightGrid& grid, int y) {
  const auto has_cell = [&](int x, int row) {
    if (row < 0 || row + 1 >= kRows) return false;
    return grid.has_height(x, row) && grid.has_height(x + 1, row) && grid.has_height(x, row + 1) &&
           grid.has_height(x + 1, row + 1);
  };
  return (has_cell(0, y) || has_cell(0, y - 1)) &&
         (has_cell(kTurn - 1, y) || has_cell(kTurn - 1, y - 1));
}

int n_unequal(const Surface& surface, const HeightGrid& grid) {
  const std::set<int> left = rows_at(surface, grid, 0);
  const std::set<int> right = rows_at(surface, grid, kTurn);
  int n = 0;
  for (int y = 0; y < kRows; ++y)
    n += static_cast<int>(left.contains(y) != right.contains(y) && has_cells_on_both(grid, y));
  return n;
}

VerifyReport verified(const HeightGrid& grid, const Surface& surface,
                      const TerrainOptions& options) {
  Progress progress;
  const TinShape shape =
      options.order == InsertionOrder::tiles ? TinShape::tiles : TinShape::delaunay;
  return verify_terrain(grid, surface,
                        {.max_error = *options.max_error, .shape = shape, .matches_sides = true},
                        progress)
      .value();
}

/// How many rows do not match where nothing is done for it.
template <typename T>
int expect_matching_sides(std::uint32_t seed) {
  const HeightGrid grid = wrapped_globe<T>(seed);
  HeightGrid plain = grid;
  plain.is_round = false;
  EXPECT_TRUE(grid.is_round);
  int n_unequal_before = 0;
  Progress progress;
  for (const InsertionOrder order :
       {InsertionOrder::levels, InsertionOrder::strict, InsertionOrder::tiles})
    for (const double max_error : {0.0, 60.0, 90.0}) {
      SCOPED_TRACE(testing::Message() << name_of(order) << " within " << max_error);
      const TerrainOptions options{.max_error = max_error, .order = order};
      const Surface made = extract_terrain(grid, options, progress)->surface;
      EXPECT_EQ(n_unequal(made, grid), 0);
      const VerifyReport report = verified(grid, made, options);
      EXPECT_TRUE(report.passed());
      EXPECT_EQ(std::ranges::count(report.checks, "sides have the same vertices, as it goes round",
                                   &VerifyReport::Check::name),
                1);
      const Surface other = extract_terrain(plain, options, progress)->surface;
      n_unequal_before += n_unequal(other, grid);
      EXPECT_TRUE(verified(plain, other, options).passed());
      EXPECT_EQ(verified(grid, other, options).passed(), n_unequal(other, grid) == 0);
    }
  return n_unequal_before;
}

TEST(wrapped_terrain, has_the_same_vertices_on_both_sides) {
  int n_unequal_before = 0;
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    const int n = expect_matching_sides<std::int16_t>(seed) + expect_matching_sides<float>(seed) +
                  expect_matching_sides<double>(seed);
    // An edge of the outline is split at the worst sample on it, whatever lies beside it: where
    // there are no gaps both sides come out alike by themselves.
    if (!has_gaps(seed)) EXPECT_EQ(n, 0);
    n_unequal_before += n;
  }
  EXPECT_GT(n_unequal_before, 0) << "what is tested happens by itself";
}

TEST(wrapped_terrain, has_contours_that_go_on_across_the_seam) {
  const HeightGrid grid = wrapped_globe<std::int16_t>(2);
  Progress progress;
  const TerrainTin tin = TerrainTin::select(grid, {.max_error = 60}, metric(), progress).value();
  const std::vector<double> levels{-150.5, 0.5, 100.5};
  const TerrainContours contours = tin.contours(levels, progress).value();
  // Level and latitude of ends; lines go with higher ground on their left, so one that leaves on
  // one side comes in on the other.
  std::multiset<std::pair<double, double>> out[2];
  std::multiset<std::pair<double, double>> in[2];
  for (const auto& line : contours.lines) {
    if (line.is_ring) continue;
    for (const bool is_end : {false, true}) {
      const auto& p = is_end ? line.points.back() : line.points.front();
      if (p[0] != 0 && p[0] != 360) continue;
      (is_end ? out : in)[p[0] == 0 ? 0 : 1].insert({line.height, p[1]});
    }
  }
  EXPECT_GT(out[0].size() + out[1].size(), 5U);
  EXPECT_EQ(out[0], in[1]);
  EXPECT_EQ(out[1], in[0]);
}

TEST(wrapped_terrain, has_the_same_surface_on_any_number_of_threads) {
  const HeightGrid grid = wrapped_globe<std::int16_t>(3);
  Progress progress;
  const auto made = [&](InsertionOrder order, int n) {
    const TerrainOptions options{.max_error = 30, .order = order, .threads = {n}};
    return extract_terrain(grid, options, progress)->surface;
  };
  for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::tiles}) {
    const Surface one = made(order, 1);
    const Surface many = made(order, 5);
    EXPECT_EQ(one.triangles, many.triangles);
    EXPECT_EQ(one.positions, many.positions);
  }
}

/// Rows with a vertex on one side alone, where an edge of the other side goes by; by trying all.
std::uint64_t n_hanging(const TerrainSurface& made, const HeightGrid& grid) {
  const Surface& surface = made.surface;
  const auto column = [&](std::uint32_t v) {
    const Vec3d p = surface.world_position(v);
    return grid.lattice(p[0], p[1]);
  };
  std::uint64_t n = 0;
  for (const auto& [own, other] : {std::pair{0, kTurn}, {kTurn, 0}})
    for (const int row : rows_at(surface, grid, own)) {
      bool is_in_edge = false;
      for (const auto& t : surface.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
          const auto a = column(t[i]);
          const auto b = column(t[(i + 1) % 3]);
          is_in_edge =
              is_in_edge || (std::abs(a[0] - other) < 0.1 && std::abs(b[0] - other) < 0.1 &&
                             std::min(a[1], b[1]) < row - 0.1 && std::max(a[1], b[1]) > row + 0.1);
        }
      n += is_in_edge ? 1 : 0;
    }
  return n;
}

TEST(wrapped_terrain, counts_vertices_on_one_side_alone) {
  std::uint64_t n_in_all = 0;
  Progress progress;
  for (std::uint32_t seed = 1; seed <= 2; ++seed) {
    const HeightGrid grid = wrapped_globe<float>(seed);
    const TerrainOptions options{.max_error = 90, .is_closed = true};
    EXPECT_EQ(extract_terrain(grid, options, progress)->report.n_one_sided, 0U);
    for (const TerrainModel model :
         {TerrainModel::delaunay_pyramid, TerrainModel::ternary_triangulation,
          TerrainModel::restricted_quadtree, TerrainModel::right_triangle_bisection}) {
      SCOPED_TRACE(testing::Message() << seed << " " << name_of(model));
      const auto built = BuiltTerrain::build(grid, {.model = model, .levels = {90}}, progress);
      ASSERT_TRUE(built);
      const auto made = extract_terrain(built->terrain(), options, progress);
      ASSERT_TRUE(made);
      EXPECT_EQ(made->report.n_one_sided, n_hanging(*made, grid));
      n_in_all += made->report.n_one_sided;
      const auto open = extract_terrain(built->terrain(), {.max_error = 90}, progress);
      EXPECT_EQ(open->report.n_one_sided, 0U) << "only where it is asked for";
    }
  }
  EXPECT_GT(n_in_all, 0U);
}

}  // namespace
}  // namespace lode
