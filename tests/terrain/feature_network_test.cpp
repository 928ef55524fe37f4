#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_features.h"
#include "lode/delaunay/full_tin.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/delaunay/point_fixtures.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

using terrain_features::CriticalKind;
using terrain_features::LineKind;
using Position = std::array<double, 2>;

/// Rows from north to south, with gaps, level places and an island.
HeightGrid rough_raster(std::uint64_t seed) {
  oracles::Random random(seed);
  HeightGrid grid = delaunay::test::make_grid<float>(41, 33, [&](int x, int y) {
    return 40 * std::sin(0.4 * x) * std::cos(0.3 * y) + static_cast<double>(random.below(30));
  });
  for (int i = 0; i < 12; ++i) delaunay::test::set_missing(grid, 12 + i % 4, 9 + i / 4);
  for (int y = 0; y < 33; ++y) delaunay::test::set_missing(grid, 36, y);
  grid.to_world = {500000.25, 30, 0, 4000000.5, 0, -20};
  return grid;
}

TerrainFeatures network_of(const Terrain& terrain, std::optional<double> least_relief) {
  Progress progress;
  auto made = find_terrain_features(terrain, least_relief, progress);
  if (!made) ADD_FAILURE() << made.error().message;
  return made ? *std::move(made) : TerrainFeatures{};
}

Position position_of(const Vec3d& p) { return {p[0], p[1]}; }

std::set<Position> positions_of(const TerrainFeatures& features) {
  std::set<Position> positions;
  for (const TerrainFeatures::Point& point : features.points)
    positions.insert(position_of(point.at));
  return positions;
}

/// Places of samples without all four cells: what may be on the outline.
std::set<Position> outline_of(const HeightGrid& grid) {
  using delaunay::test::has_cell;
  std::set<Position> positions;
  for (int y = 0; y < grid.n_rows; ++y)
    for (int x = 0; x < grid.n_columns; ++x) {
      const auto at = grid.world(x, y);
      if (!(has_cell(grid, x, y) && has_cell(grid, x - 1, y) && has_cell(grid, x, y - 1) &&
            has_cell(grid, x - 1, y - 1)))
        positions.insert({at[0], at[1]});
    }
  return positions;
}

TEST(feature_network, has_each_edge_once_and_meets_at_ends_alone) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    for (const double relief : {0.0, 12.0, 45.0}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", relief " << relief);
      const HeightGrid grid = rough_raster(seed);
      const TerrainFeatures features = network_of(Terrain(grid), relief);
      const std::set<Position> critical = positions_of(features);
      const std::set<Position> outline = outline_of(grid);
      ASSERT_FALSE(features.lines.empty());
      for (const LineKind kind : {LineKind::ridge, LineKind::channel}) {
        std::set<std::pair<Position, Position>> edges;
        std::map<Position, int> n_ends;
        std::map<Position, int> n_inside;
        for (const TerrainFeatures::Line& line : features.lines) {
          if (line.kind != kind) continue;
          ASSERT_GE(line.points.size(), 2U);
          for (std::size_t i = 0; i < line.points.size(); ++i) {
            const bool is_end = i == 0 || i + 1 == line.points.size();
            ++(is_end ? n_ends : n_inside)[position_of(line.points[i])];
            if (i > 0)
              EXPECT_TRUE(edges
                              .insert(std::minmax(position_of(line.points[i - 1]),
                                                  position_of(line.points[i])))
                              .second);
          }
        }
        for (const auto& [at, n] : n_inside) {
          EXPECT_EQ(n, 1) << "two lines cross";
          EXPECT_FALSE(n_ends.contains(at)) << "a line ends inside of another";
          EXPECT_FALSE(critical.contains(at));
        }
        for (const auto& [at, n] : n_ends)
          EXPECT_TRUE(critical.contains(at) || n >= 3 ||
                      (kind == LineKind::channel && outline.contains(at)))
              << "an end of " << n << " lines is neither critical nor a junction";
      }
    }
}

TEST(feature_network, is_what_the_features_of_all_samples_are) {
  const HeightGrid grid = rough_raster(3);
  const auto full = delaunay::to_full_tin(grid);
  ASSERT_TRUE(full);
  for (const double relief : {0.0, 12.0}) {
    Progress progress;
    const auto wanted = terrain_features::find_features(full->tin, relief, progress);
    ASSERT_TRUE(wanted);
    const TerrainFeatures features = network_of(Terrain(grid), relief);
    EXPECT_EQ(features.all, wanted->all);
    EXPECT_EQ(features.kept, wanted->kept);
    EXPECT_EQ(features.euler_number, wanted->euler_number);
    ASSERT_EQ(features.points.size(), wanted->points.size());
    const auto place_of = [&](std::uint32_t vertex) {
      const auto at = grid.world(full->tin.vertices[vertex].x, full->tin.vertices[vertex].y);
      return Vec3d{{at[0], at[1], full->tin.heights[vertex]}};
    };
    for (std::size_t i = 0; i < features.points.size(); ++i) {
      EXPECT_EQ(features.points[i].kind, wanted->points[i].kind);
      EXPECT_EQ(features.points[i].relief, wanted->points[i].relief);
      EXPECT_EQ(features.points[i].at, place_of(wanted->points[i].vertex));
    }
    // Put together again, line by line.
    std::vector<std::vector<Vec3d>> lines;
    std::size_t at = 0;
    for (const terrain_features::FeatureLine& line : wanted->lines) {
      std::vector<Vec3d> places;
      for (const std::uint32_t vertex : line.vertices) places.push_back(place_of(vertex));
      std::vector<Vec3d> joined;
      while (joined.size() < places.size() && at < features.lines.size()) {
        const TerrainFeatures::Line& part = features.lines[at++];
        EXPECT_EQ(part.kind, line.kind);
        EXPECT_GE(part.relief, relief);
        joined.insert(joined.end(), part.points.begin() + (joined.empty() ? 0 : 1),
                      part.points.end());
      }
      EXPECT_EQ(joined, places);
    }
    EXPECT_EQ(at, features.lines.size());
  }
}

TEST(feature_network, rises_along_ridges_and_falls_along_channels_where_all_is_kept) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const TerrainFeatures features = network_of(Terrain(rough_raster(seed)), 0);
    for (const TerrainFeatures::Line& line : features.lines)
      for (std::size_t i = 1; i < line.points.size(); ++i)
        if (line.kind == LineKind::ridge)
          EXPECT_GE(line.points[i][2], line.points[i - 1][2]);
        else
          EXPECT_LE(line.points[i][2], line.points[i - 1][2]);
  }
}

TEST(feature_network, has_the_counts_that_euler_asks_for) {
  for (const std::optional<double> relief : {std::optional(0.0), std::optional(30.0), {}}) {
    const TerrainFeatures features = network_of(Terrain(rough_raster(5)), relief);
    std::int64_t sum = 0;
    for (const TerrainFeatures::Point& point : features.points)
      sum += point.kind == CriticalKind::pass ? -std::int64_t{point.multiplicity} : 1;
    EXPECT_EQ(sum, features.euler_number);
  }
}

TEST(feature_network, of_a_relief_above_all_is_the_highest_peak) {
  const HeightGrid grid = delaunay::test::make_grid<std::int16_t>(
      30, 20, [](int x, int y) { return std::lround(90 * std::sin(0.5 * x) * std::cos(0.4 * y)); });
  const TerrainFeatures features = network_of(Terrain(grid), 1e9);
  EXPECT_TRUE(features.lines.empty());
  ASSERT_EQ(features.points.size(), 1U);
  EXPECT_EQ(features.points[0].kind, CriticalKind::peak);
  EXPECT_EQ(features.points[0].at[2], height_range(grid).upper);
  EXPECT_TRUE(std::isinf(features.points[0].relief));
  EXPECT_GT(features.all.peaks, 5U);
  EXPECT_EQ(network_of(Terrain(grid), {}).least_relief,
            0.01 * (height_range(grid).upper - height_range(grid).lower));
}

bool is_same(const TerrainFeatures& a, const TerrainFeatures& b) {
  if (a.all != b.all || a.kept != b.kept || a.lines.size() != b.lines.size()) return false;
  for (std::size_t i = 0; i < a.lines.size(); ++i)
    if (a.lines[i].points != b.lines[i].points) return false;
  return true;
}

TEST(feature_network, of_models_with_all_heights_is_that_of_their_raster) {
  const HeightGrid grid = rough_raster(7);
  const TerrainFeatures wanted = network_of(Terrain(grid), 12);
  Progress progress;
  for (const TerrainModel model : kBuiltTerrainModels) {
    SCOPED_TRACE(name_of(model));
    const auto built = BuiltTerrain::build(grid, {.model = model, .levels = {20, 0}}, progress);
    ASSERT_TRUE(built) << built.error().message;
    const auto found = find_terrain_features(built->terrain(), 12, progress);
    if (is_on_squares(model) || model == TerrainModel::implicit_delaunay_pyramid) {
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_TRUE(is_same(*found, wanted));
    } else {
      ASSERT_FALSE(found);
      EXPECT_NE(found.error().message.find("keeps all heights"), std::string::npos);
    }
  }
}

TEST(feature_network, stops_when_cancelled_and_refuses_what_has_no_cells) {
  HeightGrid grid = rough_raster(1);
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(find_terrain_features(Terrain(grid), 0, progress));
  grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 0);
  Progress other;
  const auto none = find_terrain_features(Terrain(grid), 0, other);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("four"), std::string::npos) << none.error().message;
}

}  // namespace
}  // namespace lode
