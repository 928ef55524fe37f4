#include "lode/delaunay/tile_insertion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <type_traits>

#include "lode/delaunay/grid_domain.h"
#include "lode/delaunay/line_splitter.h"
#include "lode/delaunay/seams.h"
#include "lode/delaunay/tin_links.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/fractal_terrain.h"

namespace lode::delaunay {
namespace {

struct TiledAnswer {
  Tin tin;
  TileLayout layout{2, 2, 1};
  GreedyReport report;
  std::uint64_t n_samples = 0;
  std::uint64_t n_left_out = 0;
};

template <typename T>
TiledAnswer insert_tiles(const HeightGrid& grid, double max_error, std::int32_t side,
                         int n_threads = 2, TinLinks links = TinLinks::kept) {
  const HeightRange range = height_range(grid);
  Progress progress;
  auto tiles = insert_in_tiles<T>(
      grid, range.lower, range.upper,
      {.max_error = max_error, .side = side, .links = links, .threads = {n_threads}}, progress);
  EXPECT_TRUE(tiles) << tiles.error().message;
  if (!tiles) return {};
  Tin tin = to_tin(*tiles, {n_threads});
  return {std::move(tin), tiles->layout, tiles->report, tiles->n_samples, tiles->n_left_out};
}

bool is_on_line(const TileLayout& layout, LatticePoint a, LatticePoint b) {
  return (a.x == b.x && std::ranges::binary_search(layout.columns(), a.x)) ||
         (a.y == b.y && std::ranges::binary_search(layout.rows(), a.y));
}

/// No triangle crosses a seam, and edges that are not on one are Delaunay. Returns how many on
/// seams are not.
int expect_tiles_delaunay(const TiledAnswer& answer) {
  const Tin& tin = answer.tin;
  int n_constrained = 0;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
    std::array<LatticePoint, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = tin.vertices[tin.triangles[t][i]];
    const auto [left, right] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [low, high] = std::minmax({at[0].y, at[1].y, at[2].y});
    for (const std::int32_t x : answer.layout.columns()) EXPECT_FALSE(left < x && x < right);
    for (const std::int32_t y : answer.layout.rows()) EXPECT_FALSE(low < y && y < high);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t twin = tin.twins[t][i];
      if (twin == kNoHalfEdge) continue;
      const LatticePoint across = tin.vertices[tin.triangles[twin / 4][(twin % 4 + 2) % 3]];
      if (test::circle_sign(at[0], at[1], at[2], across) <= 0) continue;
      EXPECT_TRUE(is_on_line(answer.layout, at[i], at[(i + 1) % 3]));
      ++n_constrained;
    }
  }
  return n_constrained;
}

/// That vertices on lines that were cut along are those of the seams, and no others.
template <typename T>
void expect_seams(const TiledAnswer& answer, const HeightGrid& grid, double max_error) {
  const HeightRange range = height_range(grid);
  const GridCells cells(grid);
  const LatticePacking packing(grid.n_columns);
  const SampleRows<T> rows{std::get<HeightGrid::Samples<T>>(grid.heights).data(), grid.stride,
                           packing};
  Seams seams = find_seams(answer.layout, rows, &cells,
                           {.range = range.upper - range.lower, .max_error = max_error});
  std::set<std::uint32_t> expected;
  for (std::size_t i = 0; i < seams.n_sides(); ++i) {
    const LatticePoint first = seams.part(i).first;
    const bool is_row = first.y == seams.part(i).last.y;
    EXPECT_LE(seams.side(i).error, max_error);
    for (const std::int32_t place : seams.side(i).places)
      expected.insert(
          packing.pack(is_row ? LatticePoint{place, first.y} : LatticePoint{first.x, place}));
  }
  std::set<std::uint32_t> found;
  for (const LatticePoint& p : answer.tin.vertices)
    if (is_on_line(answer.layout, p, p)) found.insert(packing.pack(p));
  EXPECT_EQ(found, expected);
}

template <typename T>
void expect_right(const HeightGrid& grid, double max_error, std::int32_t side) {
  SCOPED_TRACE(testing::Message() << grid.n_columns << " x " << grid.n_rows << ", error "
                                  << max_error << ", side " << side);
  const TiledAnswer answer = insert_tiles<T>(grid, max_error, side);
  test::expect_fills(answer.tin, grid);
  expect_tiles_delaunay(answer);
  expect_seams<T>(answer, grid, max_error);
  EXPECT_EQ(answer.tin.twins, find_twins(answer.tin.triangles));
  // Of floats of 64 bits long doubles round, by less than 2^-60 of heights up to 2^12.
  const long double rounding = std::is_same_v<T, double> ? 0x1p-48L : 0;
  const long double largest = test::largest_error(answer.tin, grid);
  EXPECT_LE(largest, static_cast<long double>(max_error) + rounding);
  EXPECT_LE(largest, static_cast<long double>(answer.report.achieved_error) + rounding);
  EXPECT_LE(answer.report.achieved_error, max_error);
  const auto domain = find_domain(grid);
  ASSERT_TRUE(domain);
  EXPECT_EQ(answer.n_samples, domain->n_samples);
  EXPECT_EQ(answer.n_left_out, domain->n_left_out);
}

/// Hills in tenths, as terrain-RGB has them, where the type has fractions.
template <typename T>
double hilly(std::int32_t x, std::int32_t y) {
  const double whole = std::round(700 * std::sin(0.31 * x) * std::cos(0.23 * y + 0.01 * x * y)) +
                       ((x * 7 + y * 13) % 31 == 0 ? 150 : 0) + 1000;
  return std::is_floating_point_v<T> ? whole / 10 : whole;
}

template <typename T>
class tile_insertion : public testing::Test {};
using TiledTypes = testing::Types<std::int16_t, std::uint16_t, float, double>;
TYPED_TEST_SUITE(tile_insertion, TiledTypes);

TYPED_TEST(tile_insertion, joins_tiles_within_the_error_whatever_their_sizes) {
  for (const auto& [n_columns, n_rows] :
       {std::pair{2, 2}, {2, 30}, {30, 2}, {9, 9}, {16, 17}, {18, 33}, {34, 31}}) {
    const HeightGrid grid = test::make_grid<TypeParam>(n_columns, n_rows, hilly<TypeParam>);
    for (const double max_error : {0.0, 0.3, 3.0, 40.0})
      for (const std::int32_t side : {1, 7, 8, 100}) expect_right<TypeParam>(grid, max_error, side);
  }
}

TYPED_TEST(tile_insertion, keeps_gaps_that_cross_seams_or_touch_them) {
  const HeightGrid full = test::make_grid<TypeParam>(33, 31, hilly<TypeParam>);
  const auto masked = [&](const auto& is_missing) {
    HeightGrid grid = full;
    for (std::int32_t y = 0; y < grid.n_rows; ++y)
      for (std::int32_t x = 0; x < grid.n_columns; ++x)
        if (is_missing(x, y)) test::set_missing(grid, x, y);
    return grid;
  };
  const std::vector<HeightGrid> grids{
      // Slanted borders, steps of which end at seams and between them.
      masked([](int x, int y) { return x + 2 * y < 25 || x > 40 - y / 2; }),
      // A hole that touches the corner of four tiles, and one across a seam.
      masked([](int x, int y) { return (x == 9 && y == 9) || (x > 13 && x < 19 && y == 20); }),
      // Two islands, and single samples without a cell.
      masked([](int x, int y) { return x + y > 26 && x + y < 38 && (x != 16 || y != 16); }),
      // Tiles without cells; cells beside a seam on one side alone.
      masked([](int x, int y) { return y > 15 && x < 16 && x != 8; }),
      masked([](int x, int y) { return y == 8 && x % 9 > 3; }),
      // Samples here and there.
      masked([](int x, int y) { return (x * 31 + y * 17) % 23 == 0; })};
  for (const HeightGrid& grid : grids)
    for (const double max_error : {0.0, 3.0, 500.0})
      for (const std::int32_t side : {5, 8, 100}) expect_right<TypeParam>(grid, max_error, side);
}

TYPED_TEST(tile_insertion, makes_the_same_for_any_number_of_threads) {
  HeightGrid grid = test::make_grid<TypeParam>(150, 130, hilly<TypeParam>);
  for (std::int32_t i = 0; i < 90; ++i) test::set_missing(grid, 30 + i, 20 + i);
  const double max_error = std::is_floating_point_v<TypeParam> ? 2 : 20;
  const TiledAnswer one = insert_tiles<TypeParam>(grid, max_error, 32, 1);
  ASSERT_GT(one.tin.triangles.size(), 4000U);
  EXPECT_GT(expect_tiles_delaunay(one), 0);
  for (const int n_threads : {2, 5}) {
    const TiledAnswer other = insert_tiles<TypeParam>(grid, max_error, 32, n_threads);
    EXPECT_EQ(one.tin.vertices, other.tin.vertices);
    EXPECT_EQ(one.tin.triangles, other.tin.triangles);
    EXPECT_EQ(one.tin.twins, other.tin.twins);
    EXPECT_EQ(one.tin.errors, other.tin.errors);
    EXPECT_EQ(one.report.achieved_error, other.report.achieved_error);
  }
  const TiledAnswer without = insert_tiles<TypeParam>(grid, max_error, 32, 2, TinLinks::left_out);
  EXPECT_EQ(one.tin.triangles, without.tin.triangles);
  EXPECT_TRUE(without.tin.twins.empty() && without.tin.errors.empty());
}

TYPED_TEST(tile_insertion, of_a_plain_has_nothing_but_corners_of_tiles) {
  const HeightGrid plain = test::make_grid<TypeParam>(33, 17, [](int, int) { return 12; });
  const TiledAnswer answer = insert_tiles<TypeParam>(plain, 0, 8);
  EXPECT_EQ(answer.tin.vertices.size(), 15U);
  EXPECT_EQ(answer.tin.triangles.size(), 16U);
  EXPECT_EQ(answer.report.achieved_error, 0);
}

/// Beside as few as the strict order finds; and tiles follow from what there is to see.
TEST(tiles_of_a_fractal, cost_few_triangles) {
  const HeightGrid grid = oracles::make_fractal_terrain(1024, 5);
  std::size_t n_tiles = 0;
  for (const double share : {0.01, 0.002, 0.0005}) {
    const double max_error = share * 65535;
    Progress progress;
    const LatticePacking packing(grid.n_columns);
    LatticeMesh mesh(packing, find_domain(grid)->triangles);
    ASSERT_TRUE(insert_greedily(
        mesh,
        SampleRows<std::uint16_t>{std::get<HeightGrid::Samples<std::uint16_t>>(grid.heights).data(),
                                  grid.stride, packing},
        0, 65535, {.max_error = max_error, .order = InsertionOrder::strict}, progress));
    const TiledAnswer tiles = insert_tiles<std::uint16_t>(grid, max_error, 0);
    const double strict = static_cast<double>(mesh.triangles().size());
    EXPECT_LE(static_cast<double>(tiles.tin.triangles.size()), 1.015 * strict) << share;
    EXPECT_GT(tiles.layout.n_tiles(), n_tiles / 2);
    n_tiles = tiles.layout.n_tiles();
  }
  EXPECT_EQ(n_tiles, 64U);
}

TEST(tile_layout, cuts_into_tiles_that_are_as_equal_as_can_be) {
  for (std::int32_t n = 2; n < 60; ++n)
    for (const std::int32_t side : {1, 2, 7, 16, 1000}) {
      const TileLayout layout(n, 2, side);
      EXPECT_EQ(layout.columns().front(), 0);
      EXPECT_EQ(layout.columns().back(), n - 1);
      EXPECT_EQ(layout.n_tiles(), layout.n_across());
      std::int32_t least = n;
      std::int32_t most = 0;
      for (std::size_t i = 0; i < layout.n_tiles(); ++i) {
        const LatticePart part = layout.part(i);
        EXPECT_EQ(part.last.y - part.first.y, 1);
        least = std::min(least, part.last.x - part.first.x);
        most = std::max(most, part.last.x - part.first.x);
      }
      EXPECT_GE(least, 1);
      EXPECT_LE(most - least, 1);
      EXPECT_LE(most, 2 * side);
    }
}

/// In fractions, which long doubles hold: heights of 17 bits, lines of 7.
TEST(line_splitter, keeps_integers_within_the_tolerance_and_states_the_largest_error) {
  std::vector<std::int16_t> line(120);
  for (std::size_t i = 0; i < line.size(); ++i)
    line[i] = static_cast<std::int16_t>(400 * std::sin(0.2 * static_cast<double>(i)) +
                                        static_cast<double>((i * 37) % 50));
  for (const double max_error : {0.0, 1.0, 7.5, 100.0, 1e4}) {
    LineSplitter<std::int16_t> splitter(65535, max_error);
    std::vector<std::int32_t> kept{0};
    const double stated = splitter.split(line.data(), 0, 119, kept);
    kept.push_back(119);
    EXPECT_TRUE(std::ranges::is_sorted(kept));
    long double largest = 0;
    for (std::size_t k = 0; k + 1 < kept.size(); ++k)
      for (std::int32_t i = kept[k]; i <= kept[k + 1]; ++i) {
        const std::int32_t n = kept[k + 1] - kept[k];
        const auto at = [&](std::int32_t j) { return line[static_cast<std::size_t>(j)]; };
        const auto scaled = static_cast<long double>(
            (at(i) - at(kept[k])) * n - (at(kept[k + 1]) - at(kept[k])) * (i - kept[k]));
        largest = std::max(largest, std::abs(scaled) / static_cast<long double>(n));
      }
    EXPECT_LE(largest, static_cast<long double>(stated));
    EXPECT_LE(static_cast<long double>(stated), largest * (1 + 0x1p-51L));
    EXPECT_LE(stated, max_error);
    if (max_error == 1e4) EXPECT_EQ(kept.size(), 2U);
  }
}

TEST(tile_insertion_stop, ends_with_an_error_when_cancelled_or_without_cells) {
  HeightGrid grid = test::make_grid<std::int16_t>(40, 33, hilly<std::int16_t>);
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(
      insert_in_tiles<std::int16_t>(grid, 0, 3000, {.max_error = 1, .side = 8}, cancelled));
  Progress progress;
  for (std::int32_t y = 0; y < 33; ++y)
    for (std::int32_t x = y % 2; x < 40; x += 2) test::set_missing(grid, x, y);
  EXPECT_FALSE(insert_in_tiles<std::int16_t>(grid, 0, 3000, {.max_error = 1}, progress));
  const HeightGrid row = test::make_grid<std::int16_t>(40, 1, hilly<std::int16_t>);
  EXPECT_FALSE(insert_in_tiles<std::int16_t>(row, 0, 3000, {.max_error = 1}, progress));
}

}  // namespace
}  // namespace lode::delaunay
