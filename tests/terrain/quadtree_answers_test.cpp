// Heights, profiles and lines of sight of the models whose surfaces do not meet.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/files.h"
#include "lode/api/terrain_sight.h"
#include "lode/models/terrain/quaternary_triangulation/quaternary_triangulation.h"
#include "lode/models/terrain/squares/cell_walk.h"
#include "lode/models/terrain/surface_quadtree/surface_quadtree.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

using delaunay::test::make_grid;
using delaunay::test::set_missing;
using quaternary_triangulation::HalfSquare;
using squares::Square;

constexpr TerrainModel kSurface = TerrainModel::surface_quadtree;
constexpr TerrainModel kQuaternary = TerrainModel::quaternary_triangulation;

HeightGrid hills_with_gaps() {
  HeightGrid grid = make_grid<float>(70, 45, [](int x, int y) {
    return 200 * std::sin(0.13 * x) * std::cos(0.09 * y) +
           (x > 40 ? 0.7 * y : 30 * std::sin(x * y));
  });
  for (std::int32_t y = 10; y < 14; ++y)
    for (std::int32_t x = 20; x < 31; ++x) set_missing(grid, x, y);
  set_missing(grid, 0, 0);
  return grid;
}

/// Full resolution: linear on two triangles a cell, cut along the diagonal whose ends differ less.
std::optional<double> full_height(const HeightGrid& grid, double x, double y) {
  for (const double dx : {0.0, -1.0})
    for (const double dy : {0.0, -1.0}) {
      const auto i = static_cast<std::int32_t>(std::floor(x) + dx);
      const auto j = static_cast<std::int32_t>(std::floor(y) + dy);
      if (!delaunay::test::has_cell(grid, i, j) || x > i + 1 || y > j + 1) continue;
      const double a = grid.height(i, j);
      const double b = grid.height(i + 1, j);
      const double c = grid.height(i + 1, j + 1);
      const double d = grid.height(i, j + 1);
      const double u = x - i;
      const double v = y - j;
      if (std::abs(a - c) <= std::abs(b - d))
        return u >= v ? a + u * (b - a) + v * (c - b) : a + v * (d - a) + u * (c - d);
      return u + v <= 1 ? a + u * (b - a) + v * (d - a) : c + (1 - u) * (d - c) + (1 - v) * (b - c);
    }
  return std::nullopt;
}

/// A leaf, from its definition.
struct OracleLeaf {
  Square square;
  bool is_upper = false;
  bool is_triangle = false;

  [[nodiscard]] bool holds(double x, double y) const {
    const double u = x - square.x();
    const double v = y - square.y();
    if (u < 0 || v < 0 || u > square.side() || v > square.side()) return false;
    return !is_triangle || (is_upper ? v >= u : u >= v);
  }
  [[nodiscard]] long double height(const HeightGrid& grid, double x, double y) const {
    const auto z = [&](int i, int j) -> long double {
      return grid.height(square.x() + i * square.side(), square.y() + j * square.side());
    };
    const long double u = (static_cast<long double>(x) - square.x()) / square.side();
    const long double v = (static_cast<long double>(y) - square.y()) / square.side();
    if (!is_triangle)
      return (1 - u) * (1 - v) * z(0, 0) + u * (1 - v) * z(1, 0) + (1 - u) * v * z(0, 1) +
             u * v * z(1, 1);
    if (is_upper) return (1 - v) * z(0, 0) + (v - u) * z(0, 1) + u * z(1, 1);
    return (1 - u) * z(0, 0) + (u - v) * z(1, 0) + v * z(1, 1);
  }
};

std::vector<OracleLeaf> leaves_of(TerrainModel model, const HeightGrid& grid, double tolerance) {
  Progress progress;
  std::vector<OracleLeaf> all;
  if (model == kSurface) {
    const auto tree = surface_quadtree::SurfaceQuadtree::build(grid, {1}, progress);
    for (const Square& square : tree->leaves(tolerance)) all.push_back({square});
  } else {
    const auto tree = quaternary_triangulation::QuaternaryTriangulation::build(grid, {1}, progress);
    for (const HalfSquare& half : tree->leaves(tolerance))
      all.push_back({half.square, half.is_upper, true});
  }
  // The documented order of those that meet at a place.
  std::ranges::sort(all, {}, [](const OracleLeaf& leaf) {
    return std::tuple(leaf.square.level, leaf.square.row, leaf.square.column, leaf.is_upper);
  });
  return all;
}

const OracleLeaf* leaf_at(const std::vector<OracleLeaf>& leaves, double x, double y) {
  const auto found =
      std::ranges::find_if(leaves, [&](const OracleLeaf& leaf) { return leaf.holds(x, y); });
  return found == leaves.end() ? nullptr : &*found;
}

class quadtree_answers : public testing::TestWithParam<std::pair<TerrainModel, double>> {
 protected:
  [[nodiscard]] static TerrainModel model() { return GetParam().first; }
  [[nodiscard]] static double tolerance() { return GetParam().second; }

  [[nodiscard]] TerrainTin tin(bool is_everywhere) const {
    Progress progress;
    const auto built = BuiltTerrain::build(*grid_, {.model = model()}, progress);
    EXPECT_TRUE(built);
    TerrainOptions options{.max_error = tolerance()};
    if (is_everywhere) options.samples = grid_;
    auto tin = TerrainTin::select(built->terrain(), options, {}, progress, TinUse::places);
    EXPECT_TRUE(tin) << tin.error().message;
    return std::move(tin).value();
  }
  /// Anywhere, on columns and rows, on diagonals, and at samples; also beside the raster.
  [[nodiscard]] Place random_place(oracles::Random& random) const {
    Place at{{random.uniform(-1, grid_->n_columns), random.uniform(-1, grid_->n_rows)}};
    const auto kind = random.below(5);
    if (kind == 1 || kind == 3) at[0] = std::round(at[0]);
    if (kind == 2 || kind == 3) at[1] = std::round(at[1]);
    if (kind == 4) at[1] = std::floor(at[1]) + (at[0] - std::floor(at[0]));
    return at;
  }

  std::shared_ptr<const HeightGrid> grid_ = std::make_shared<HeightGrid>(hills_with_gaps());
};

TEST_P(quadtree_answers, have_the_heights_of_the_smallest_leaf_at_a_place) {
  const auto leaves = leaves_of(model(), *grid_, tolerance());
  const TerrainTin tin = this->tin(false);
  oracles::Random random(5);
  std::vector<Place> places;
  for (int i = 0; i < 4000; ++i) places.push_back(random_place(random));
  std::vector<TerrainHeight> heights;
  Progress progress;
  ASSERT_TRUE(tin.heights(places, heights, {2}, progress));
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto [x, y] = std::pair(places[i][0], places[i][1]);
    const OracleLeaf* leaf = leaf_at(leaves, x, y);
    ASSERT_EQ(heights[i].where == TerrainHeight::Where::inside, leaf != nullptr) << x << " " << y;
    if (leaf == nullptr) continue;
    EXPECT_NEAR(heights[i].height, static_cast<double>(leaf->height(*grid_, x, y)), 1e-11);
    EXPECT_LE(heights[i].bound, tolerance() + 1e-11);
  }
}

TEST_P(quadtree_answers, are_within_their_bounds_at_samples_and_exact_at_vertices) {
  const auto leaves = leaves_of(model(), *grid_, tolerance());
  const TerrainTin tin = this->tin(false);
  std::vector<Place> places;
  for (std::int32_t y = 0; y < grid_->n_rows; ++y)
    for (std::int32_t x = 0; x < grid_->n_columns; ++x)
      if (full_height(*grid_, x, y)) places.push_back({{x + 0.0, y + 0.0}});
  std::vector<TerrainHeight> heights;
  Progress progress;
  ASSERT_TRUE(tin.heights(places, heights, {2}, progress));
  std::map<std::pair<double, double>, double> height_at;
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(heights[i].where, TerrainHeight::Where::inside);
    const auto x = static_cast<std::int32_t>(places[i][0]);
    const auto y = static_cast<std::int32_t>(places[i][1]);
    EXPECT_LE(std::abs(heights[i].height - grid_->height(x, y)), heights[i].bound);
    height_at[{places[i][0], places[i][1]}] = heights[i].height;
  }
  for (const OracleLeaf& leaf : leaves)
    for (int i = 0; i < 4; ++i) {
      const std::int32_t u = (i & 1) * leaf.square.side();
      const std::int32_t v = (i >> 1) * leaf.square.side();
      if (leaf.is_triangle && u != v && (v > u) != leaf.is_upper) continue;
      const std::int32_t x = leaf.square.x() + u;
      const std::int32_t y = leaf.square.y() + v;
      EXPECT_EQ((height_at.at({x + 0.0, y + 0.0})), grid_->height(x, y));
    }
}

TEST_P(quadtree_answers, are_within_their_bounds_everywhere_where_these_say_so) {
  const TerrainTin tin = this->tin(true);
  EXPECT_TRUE(tin.report().is_everywhere);
  oracles::Random random(7);
  std::vector<Place> places;
  for (int i = 0; i < 20000; ++i) {
    places.push_back(random_place(random));
    // In the middle of a diagonal.
    if (i % 3 == 0)
      places.back() = {{std::floor(places.back()[0]) + 0.5, std::floor(places.back()[1]) + 0.5}};
  }
  std::vector<TerrainHeight> heights;
  Progress progress;
  ASSERT_TRUE(tin.heights(places, heights, {2}, progress));
  double largest = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto full = full_height(*grid_, places[i][0], places[i][1]);
    ASSERT_EQ(heights[i].where == TerrainHeight::Where::inside, full.has_value());
    if (!full) continue;
    EXPECT_LE(std::abs(heights[i].height - *full), heights[i].bound);
    largest = std::max(largest, std::abs(heights[i].height - *full));
  }
  EXPECT_LE(largest, tin.report().achieved_error);
  // No bound for its own sake.
  EXPECT_GT(largest, tin.report().achieved_error / 4);
}

/// Rows that follow each other, all that they say of the way, against leaves and full resolution.
void expect_profile(const TerrainProfile& profile, const HeightGrid& grid,
                    const std::vector<OracleLeaf>& leaves, oracles::Random& random) {
  std::size_t n_steps = 0;
  for (std::size_t i = 0; i < profile.points.size(); ++i) {
    const auto& here = profile.points[i];
    // Each row is on a leaf that holds its place, but for rounding.
    double nearest = INFINITY;
    for (const OracleLeaf& leaf : leaves) {
      const double x =
          std::clamp(here.at[0], leaf.square.x() + 0.0, leaf.square.x() + leaf.square.side() + 0.0);
      const double y =
          std::clamp(here.at[1], leaf.square.y() + 0.0, leaf.square.y() + leaf.square.side() + 0.0);
      if (std::hypot(x - here.at[0], y - here.at[1]) > 1e-12) continue;
      nearest =
          std::min(nearest, std::abs(static_cast<double>(leaf.height(grid, x, y)) - here.height));
    }
    EXPECT_LT(nearest, 1e-9);
    if (i + 1 == profile.points.size() || profile.points[i + 1].part != here.part) continue;
    const auto& next = profile.points[i + 1];
    EXPECT_LE(here.distance, next.distance);
    if (here.distance == next.distance) {
      n_steps += here.at == next.at ? 1 : 0;
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const double share = random.uniform();
      const Place at = here.at * (1 - share) + next.at * share;
      const auto full = full_height(grid, at[0], at[1]);
      if (!full) continue;
      const double z = here.height * (1 - share) + next.height * share;
      EXPECT_LE(std::abs(z - *full), std::max(here.bound, next.bound) + 1e-9);
    }
  }
  EXPECT_GE(n_steps, profile.n_steps);
}

TEST_P(quadtree_answers, have_profiles_that_are_within_their_bounds_between_rows) {
  const auto leaves = leaves_of(model(), *grid_, tolerance());
  const TerrainTin tin = this->tin(true);
  oracles::Random random(11);
  Progress progress;
  std::uint64_t n_steps = 0;
  for (int i = 0; i < 300; ++i) {
    const Place from = random_place(random);
    Place to = random_place(random);
    if (i % 4 == 1) to[0] = from[0];
    if (i % 4 == 2) to[1] = from[1];
    if (i % 4 == 3) to = from + Place{{to[1] - from[1], to[1] - from[1]}};
    if (from == to) continue;
    SCOPED_TRACE(testing::Message() << from[0] << "," << from[1] << " " << to[0] << "," << to[1]);
    const auto profile = tin.profile(from, to, progress);
    ASSERT_TRUE(profile) << profile.error().message;
    expect_profile(*profile, *grid_, leaves, random);
    n_steps += profile->n_steps;
    // Terrain and gaps make up the whole way.
    for (int k = 0; k < 30; ++k) {
      const double share = random.uniform();
      const Place at = from * (1 - share) + to * share;
      const double distance = share * profile->length;
      const bool is_in_gap = std::ranges::any_of(profile->gaps, [&](const auto& gap) {
        return gap.begin < distance && distance < gap.end;
      });
      const bool is_near_side = std::ranges::any_of(profile->gaps, [&](const auto& gap) {
        return std::abs(gap.begin - distance) < 1e-9 || std::abs(gap.end - distance) < 1e-9;
      });
      // Along an outline rounding may leave the domain.
      if (!is_near_side && i % 4 == 0)
        EXPECT_EQ(is_in_gap, !full_height(*grid_, at[0], at[1])) << at[0] << " " << at[1];
    }
  }
  if (tolerance() > 0) EXPECT_GT(n_steps, 100U);
}

TEST_P(quadtree_answers, go_along_sides_on_the_smallest_leaf) {
  const auto leaves = leaves_of(model(), *grid_, tolerance());
  const TerrainTin tin = this->tin(false);
  Progress progress;
  for (std::int32_t x = 32; x < 70; x += 4) {
    const auto profile = tin.profile({{x + 0.0, 16.0}}, {{x + 0.0, 44.0}}, progress);
    ASSERT_TRUE(profile);
    EXPECT_TRUE(profile->gaps.empty());
    for (std::size_t i = 0; i + 1 < profile->points.size(); ++i) {
      const auto& here = profile->points[i];
      const auto& next = profile->points[i + 1];
      if (here.distance == next.distance) continue;
      const double y = (here.at[1] + next.at[1]) / 2;
      const OracleLeaf* leaf = leaf_at(leaves, x, y);
      ASSERT_NE(leaf, nullptr);
      EXPECT_NEAR((here.height + next.height) / 2, static_cast<double>(leaf->height(*grid_, x, y)),
                  1e-9);
    }
  }
}

TEST_P(quadtree_answers, never_see_what_full_resolution_does_not) {
  const TerrainTin tin = this->tin(true);
  oracles::Random random(13);
  Progress progress;
  const auto full = TerrainTin::select(*grid_, {.max_error = 0}, {}, progress);
  ASSERT_TRUE(full);
  int n_decided = 0;
  int n_undecided = 0;
  for (int i = 0; i < 400; ++i) {
    const TerrainSightOptions options{.from = random_place(random),
                                      .to = random_place(random),
                                      .observer_height = random.uniform(0, 60),
                                      .target_height = random.uniform(0, 60)};
    const auto coarse = tin.sight(options, progress);
    const auto fine = full->sight(options, progress);
    ASSERT_EQ(coarse.has_value(), fine.has_value());
    if (!coarse) continue;
    if (coarse->verdict == SightVerdict::undecided) {
      ++n_undecided;
      continue;
    }
    ++n_decided;
    EXPECT_EQ(coarse->verdict, fine->verdict);
  }
  EXPECT_GT(n_decided, 40);
  if (tolerance() >= 20) EXPECT_GT(n_undecided, 10);
}

INSTANTIATE_TEST_SUITE_P(models, quadtree_answers,
                         testing::Values(std::pair(kSurface, 60.0), std::pair(kSurface, 20.0),
                                         std::pair(kSurface, 0.0), std::pair(kQuaternary, 60.0),
                                         std::pair(kQuaternary, 20.0), std::pair(kQuaternary, 0.0)),
                         [](const auto& one) {
                           return std::string(name_of(one.param.first)) + "_" +
                                  std::to_string(static_cast<int>(one.param.second));
                         });

TEST(quadtree_answers_exact, ask_full_resolution_in_the_end) {
  const auto grid = std::make_shared<HeightGrid>(hills_with_gaps());
  Progress progress;
  for (const TerrainModel model : {kSurface, kQuaternary}) {
    const auto built = BuiltTerrain::build(*grid, {.model = model}, progress);
    ASSERT_TRUE(built);
    const TerrainOptions wanted{.max_error = 60, .samples = grid};
    int n_rounds = 0;
    for (double y = 16; y < 44; ++y) {
      const auto sight = find_terrain_sight(built->terrain(), wanted, {},
                                            {.from = {{2.3, y + 0.2}},
                                             .to = {{66.1, y}},
                                             .observer_height = 2,
                                             .effort = SightEffort::until_decided},
                                            progress);
      ASSERT_TRUE(sight) << sight.error().message;
      EXPECT_NE(sight->verdict, SightVerdict::undecided);
      n_rounds += static_cast<int>(sight->n_rounds);
    }
    EXPECT_GT(n_rounds, 28);
  }
}

TEST(quadtree_answers_real, hold_on_st_helens) {
  const char* data = std::getenv("LODE_DATA");
  const auto folder = data != nullptr
                          ? std::filesystem::path(data)
                          : std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data";
  const std::string path =
      (folder / "terrain/st_helens_327x468_int16.tif").lexically_normal().string();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  Progress progress;
  const auto read = read_heights(path, {}, progress);
  ASSERT_TRUE(read) << read.error().message;
  const auto grid = std::make_shared<HeightGrid>(read->grid);
  const auto metric = read_metric(grid->crs);
  ASSERT_TRUE(metric);
  const auto full = TerrainTin::select(*grid, {.max_error = 0}, *metric, progress);
  ASSERT_TRUE(full);
  std::vector<Place> places;
  for (std::int32_t y = 0; y < grid->n_rows; ++y)
    for (std::int32_t x = 0; x < grid->n_columns; ++x) places.push_back(grid->world(x, y));
  for (const TerrainModel model : {kSurface, kQuaternary}) {
    const auto built = BuiltTerrain::build(*grid, {.model = model}, progress);
    ASSERT_TRUE(built);
    const auto tin = TerrainTin::select(built->terrain(), {.max_error = 10, .samples = grid},
                                        *metric, progress, TinUse::places);
    ASSERT_TRUE(tin);
    std::vector<TerrainHeight> heights;
    std::vector<TerrainHeight> exact;
    ASSERT_TRUE(tin->heights(places, heights, {2}, progress));
    ASSERT_TRUE(full->heights(places, exact, {2}, progress));
    std::size_t n_beyond = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      ASSERT_EQ(heights[i].where, exact[i].where);
      const double off = std::abs(heights[i].height - exact[i].height);
      n_beyond += off <= std::min(heights[i].bound, 10 + 1e-9) ? 0 : 1;
    }
    EXPECT_EQ(n_beyond, 0U);
    oracles::Random random(31);
    for (int i = 0; i < 100; ++i) {
      const Place from = places[random.below(places.size())];
      const Place to = from * 0.8 + places[random.below(places.size())] * 0.2;
      const TerrainSightOptions options{
          .from = from, .to = to, .observer_height = 30, .target_height = 30};
      const auto coarse = tin->sight(options, progress);
      const auto fine = full->sight(options, progress);
      ASSERT_EQ(coarse.has_value(), fine.has_value());
      if (coarse && coarse->verdict != SightVerdict::undecided)
        EXPECT_EQ(coarse->verdict, fine->verdict);
    }
  }
}

TEST(quadtree_answers_refused, are_what_goes_on_from_triangle_to_triangle) {
  const HeightGrid grid = hills_with_gaps();
  Progress progress;
  const auto built = BuiltTerrain::build(grid, {.model = kSurface}, progress);
  ASSERT_TRUE(built);
  const auto tin = TerrainTin::select(built->terrain(), {.max_error = 20}, {}, progress);
  ASSERT_FALSE(tin);
  EXPECT_NE(tin.error().message.find("without gaps"), std::string::npos);
}

TEST(cell_walk, tiles_a_segment_with_the_cells_that_hold_it) {
  const squares::CellGrid grid{13, 9};
  oracles::Random random(3);
  for (int i = 0; i < 3000; ++i) {
    const auto place = [&] {
      delaunay::Point p{{random.uniform(-4, 17), random.uniform(-4, 13)}};
      if (random.below(2) == 0) p = {{std::round(p[0]), std::round(p[1])}};
      return p;
    };
    const delaunay::Point a = place();
    delaunay::Point b = place();
    if (i % 4 == 1) b[0] = a[0];
    if (i % 4 == 2) b[1] = a[1];
    if (i % 4 == 3) b = a + delaunay::Point{{b[0] - a[0], b[0] - a[0]}};
    if (a == b) continue;
    SCOPED_TRACE(testing::Message() << a[0] << "," << a[1] << " " << b[0] << "," << b[1]);
    double covered = 0;
    double last = 0;
    walk_cells(grid, a, b, [&](const squares::WalkStep& step) {
      EXPECT_LE(last, step.begin);
      EXPECT_LT(step.begin, step.end);
      last = step.end;
      covered += step.end - step.begin;
      const double t = (step.begin + step.end) / 2;
      const delaunay::Point p = a * (1 - t) + b * t;
      for (const squares::CellHalf& half : step.halves.get()) {
        const double u = p[0] - half.x;
        const double v = p[1] - half.y;
        EXPECT_GE(std::min({u, v, 1 - u, 1 - v}), -1e-12);
        EXPECT_GE(half.is_upper ? v - u : u - v, -1e-12);
      }
    });
    // What of the segment is in the rectangle.
    double enters = 0;
    double leaves = 1;
    for (std::size_t k = 0; k < 2; ++k) {
      const double high = k == 0 ? grid.n_columns : grid.n_rows;
      if (a[k] == b[k]) {
        if (a[k] < 0 || a[k] > high) leaves = enters;
        continue;
      }
      const double t = -a[k] / (b[k] - a[k]);
      const double s = (high - a[k]) / (b[k] - a[k]);
      enters = std::max(enters, std::min(t, s));
      leaves = std::min(leaves, std::max(t, s));
    }
    EXPECT_NEAR(covered, std::max(0.0, leaves - enters), 1e-12);
  }
}

}  // namespace
}  // namespace lode
