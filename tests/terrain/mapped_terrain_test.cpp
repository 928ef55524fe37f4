// Meshes of terrain in another CRS, whose errors are measured there again.
#include "lode/api/mapped_terrain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "lode/api/files.h"
#include "tests/terrain/mapped_fixtures.h"

namespace lode {
namespace {

using test::degree_grid;
using test::FunctionMap;
using test::open_target;
using test::to_utm;

Result<MappedTerrain> try_map(const std::shared_ptr<const HeightGrid>& grid, double max_error,
                              const PlaceMap& map, Threads threads = {2},
                              const std::optional<PlaceBox>& clip = {}) {
  Progress progress;
  return extract_mapped_terrain(
      Terrain(grid), {.max_error = max_error, .threads = threads},
      {.map = map, .name = "other", .clip = clip, .samples = MeasuredSamples(grid)}, progress);
}

MappedTerrain map_grid(const std::shared_ptr<const HeightGrid>& grid, double max_error,
                       const PlaceMap& map, Threads threads = {2},
                       const std::optional<PlaceBox>& clip = {}) {
  auto made = try_map(grid, max_error, map, threads, clip);
  if (!made) ADD_FAILURE() << made.error().message;
  return std::move(made).value();
}

/// Each sample against each triangle.
class BruteForce {
 public:
  BruteForce(const HeightGrid& grid, const PlaceMap& map, const MappedTerrain& mapped,
             const Surface& own)
      : grid_(grid), map_(map), mapped_(mapped), own_(own) {}

  MappedErrors measure() const {
    MappedErrors found;
    for (std::int32_t y = 0; y < grid_.n_rows; ++y)
      for (std::int32_t x = 0; x < grid_.n_columns; ++x) {
        if (!is_in_domain(x, y) || !is_in_rectangle(x, y)) continue;
        const Place world = grid_.world(x, y);
        Place at = world;
        map_.apply({&at, 1});
        const auto error = error_at(at, grid_.height(x, y));
        if (error) {
          ++found.n_samples;
          if (*error > found.error) found.worst = world;
          found.error = std::max(found.error, *error);
        } else if (is_in_own(x, y)) {
          ++found.n_without;
        }
      }
    return found;
  }

 private:
  /// Of the own surface.
  bool is_in_rectangle(std::int32_t x, std::int32_t y) const {
    const auto column = [&](std::uint32_t v) { return std::round(node_of(v)[0]); };
    const auto row = [&](std::uint32_t v) { return std::round(node_of(v)[1]); };
    std::array<bool, 4> sides{};
    for (std::uint32_t v = 0; v < own_.positions.size(); ++v) {
      sides[0] = sides[0] || column(v) <= x;
      sides[1] = sides[1] || column(v) >= x;
      sides[2] = sides[2] || row(v) <= y;
      sides[3] = sides[3] || row(v) >= y;
    }
    return std::ranges::all_of(sides, [](bool side) { return side; });
  }
  Place node_of(std::uint32_t v) const {
    const Vec3d world = own_.world_position(v);
    return grid_.lattice(world[0], world[1]);
  }
  bool is_in_domain(std::int32_t x, std::int32_t y) const {
    for (const std::int32_t dx : {-1, 0})
      for (const std::int32_t dy : {-1, 0})
        if (delaunay::test::has_cell(grid_, x + dx, y + dy)) return true;
    return false;
  }
  static long double doubled_area(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return (static_cast<long double>(b[0]) - a[0]) * (static_cast<long double>(c[1]) - a[1]) -
           (static_cast<long double>(b[1]) - a[1]) * (static_cast<long double>(c[0]) - a[0]);
  }
  std::optional<double> error_at(const Place& at, double height) const {
    const Vec3d p{{at[0], at[1], height}};
    std::optional<double> error;
    for (const auto& triangle : mapped_.terrain.surface.triangles) {
      const auto corner = [&](std::size_t i) { return mapped_.terrain.places[triangle[i]]; };
      const long double area = doubled_area(corner(0), corner(1), corner(2));
      EXPECT_GT(area, 0);
      const long double a = doubled_area(p, corner(1), corner(2));
      const long double b = doubled_area(corner(0), p, corner(2));
      const long double c = doubled_area(corner(0), corner(1), p);
      if (a < 0 || b < 0 || c < 0) continue;
      const long double z = (a * corner(0)[2] + b * corner(1)[2] + c * corner(2)[2]) / area;
      error = std::max(error.value_or(0), static_cast<double>(std::abs(z - height)));
    }
    return error;
  }
  bool is_in_own(std::int32_t x, std::int32_t y) const {
    const auto node = [&](std::uint32_t v) {
      const Place at = node_of(v);
      return Vec3d{{std::round(at[0]), std::round(at[1]), 0}};
    };
    const Vec3d p{{static_cast<double>(x), static_cast<double>(y), 0}};
    return std::ranges::any_of(own_.triangles, [&](const auto& t) {
      const std::array sides{doubled_area(node(t[0]), node(t[1]), p),
                             doubled_area(node(t[1]), node(t[2]), p),
                             doubled_area(node(t[2]), node(t[0]), p)};
      return std::ranges::all_of(sides, [](long double s) { return s <= 0; }) ||
             std::ranges::all_of(sides, [](long double s) { return s >= 0; });
    });
  }

  const HeightGrid& grid_;
  const PlaceMap& map_;
  const MappedTerrain& mapped_;
  const Surface& own_;
};

/// Bends rows and columns by several of them.
Place bend(const Place& p) {
  const double x = p[0] - 7.6;
  const double y = p[1] - 46.5;
  return {{x + 0.13 * y * y + 0.05 * x * y, y - 0.11 * x * x}};
}

TEST(mapped_terrain, has_the_errors_that_all_samples_against_all_triangles_have) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  const FunctionMap bent(bend);
  std::uint64_t n_without = 0;
  for (const PlaceMap* map : {utm.map.get(), static_cast<const PlaceMap*>(&bent)})
    for (const double max_error : {0.0, 40.0, 300.0})
      for (const bool is_clipped : {false, true}) {
        std::optional<PlaceBox> clip;
        if (is_clipped) clip = PlaceBox{{{7.3, 46.2}}, {{7.9, 46.7}}};
        const MappedTerrain mapped = map_grid(grid, max_error, *map, {2}, clip);
        Progress progress;
        const auto own = extract_terrain(Terrain(grid), {.max_error = max_error}, progress, clip);
        ASSERT_TRUE(own);
        EXPECT_EQ(own->surface.triangles, mapped.terrain.surface.triangles);
        EXPECT_EQ(own->surface.values, mapped.terrain.surface.values);
        EXPECT_EQ(own->report.achieved_error, mapped.terrain.report.achieved_error);
        EXPECT_EQ(mapped.measured_at, MeasuredAt::samples);
        const MappedErrors wanted = BruteForce(*grid, *map, mapped, own->surface).measure();
        EXPECT_EQ(mapped.errors.n_samples, wanted.n_samples);
        EXPECT_EQ(mapped.errors.n_without, wanted.n_without);
        EXPECT_NEAR(mapped.errors.error, wanted.error, 1e-9);
        if (wanted.error > 0) EXPECT_EQ(mapped.errors.worst, wanted.worst);
        n_without += wanted.n_without;
      }
  EXPECT_GT(n_without, 50U) << "outlines bend";
}

TEST(mapped_terrain, errs_as_in_its_own_crs_where_the_map_changes_nothing) {
  const auto grid = degree_grid();
  const FunctionMap same([](const Place& p) { return p; });
  const MappedTerrain mapped = map_grid(grid, 40, same);
  EXPECT_EQ(mapped.errors.n_without, 0U);
  EXPECT_EQ(mapped.errors.n_samples, mapped.terrain.report.n_samples);
  EXPECT_LE(mapped.errors.error, mapped.terrain.report.achieved_error + 1e-9);
  EXPECT_GE(mapped.errors.error, 0.999 * mapped.terrain.report.achieved_error);
}

TEST(mapped_terrain, is_the_same_for_any_number_of_threads) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  const MappedTerrain one = map_grid(grid, 40, *utm.map, {1});
  const MappedTerrain four = map_grid(grid, 40, *utm.map, {4});
  EXPECT_EQ(one.terrain.places, four.terrain.places);
  EXPECT_EQ(one.errors.error, four.errors.error);
  EXPECT_EQ(one.errors.worst, four.errors.worst);
  EXPECT_EQ(one.errors.n_samples, four.errors.n_samples);
  EXPECT_EQ(one.errors.n_without, four.errors.n_without);
}

TEST(mapped_terrain, has_vertices_in_float64_where_their_samples_are) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  const MappedTerrain mapped = map_grid(grid, 40, *utm.map);
  Progress progress;
  const auto own = extract_terrain(Terrain(grid), {.max_error = 40}, progress);
  ASSERT_TRUE(own);
  ASSERT_EQ(mapped.terrain.places.size(), own->surface.positions.size());
  for (std::uint32_t v = 0; v < mapped.terrain.places.size(); ++v) {
    const Vec3d world = own->surface.world_position(v);
    const Place node = grid->lattice(world[0], world[1]);
    const Place wanted = to_utm(grid->world(std::round(node[0]), std::round(node[1])), 9);
    ASSERT_NEAR(mapped.terrain.places[v][0], wanted[0], 1e-6);
    ASSERT_NEAR(mapped.terrain.places[v][1], wanted[1], 1e-6);
    ASSERT_EQ(mapped.terrain.places[v][2], mapped.terrain.surface.values[v]);
  }
}

TEST(mapped_terrain, is_refused_where_triangles_turn_or_places_are_missing) {
  const auto grid = degree_grid();
  const auto reason = [&](const std::function<Place(const Place&)>& function) {
    const auto made = try_map(grid, 40, FunctionMap(function));
    return made ? std::string() : made.error().message;
  };
  const std::string folded = reason([](const Place& p) {
    return Place{{std::abs(p[0] - 7.6), p[1]}};
  });
  EXPECT_NE(folded.find("turn over"), std::string::npos) << folded;
  EXPECT_NE(folded.find("smaller tolerance"), std::string::npos) << folded;
  const std::string missing = reason([](const Place& p) {
    return p[0] < 7.02 && p[1] > 46.98 ? Place{{NAN, NAN}} : p;
  });
  EXPECT_NE(missing.find("got 1 of "), std::string::npos) << missing;
  EXPECT_NE(missing.find("7.01, 46.99"), std::string::npos) << missing;
  // Of samples in triangles alone.
  const Place hole = grid->world(3, 1);
  const auto at_sample = [&](const Place& p) {
    return std::abs(p[0] - hole[0]) + std::abs(p[1] - hole[1]) < 1e-9 ? Place{{NAN, NAN}} : p;
  };
  const auto made = try_map(grid, 2000, FunctionMap(at_sample));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("got 1 that have none"), std::string::npos)
      << made.error().message;
}

TEST(mapped_terrain, is_cancelled) {
  const auto grid = degree_grid();
  const FunctionMap same([](const Place& p) { return p; });
  Progress progress([&](std::string_view phase, double, std::uint64_t) {
    if (phase.starts_with("measuring in")) progress.cancel();
  });
  const auto made = extract_mapped_terrain(
      Terrain(grid), {.max_error = 40, .threads = {1}},
      {.map = same, .name = "other", .samples = MeasuredSamples(grid)}, progress);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message, cancelled_error().message);
}

TEST(mapped_terrain, of_a_model_without_samples_is_measured_at_the_vertices_that_it_keeps) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  Progress progress;
  const auto built = BuiltTerrain::build(
      *grid, {.model = TerrainModel::delaunay_pyramid, .levels = {200.0, 20.0}}, progress);
  ASSERT_TRUE(built);
  const auto mapped = extract_mapped_terrain(built->terrain(), {.max_error = 200},
                                             {.map = *utm.map, .name = "other"}, progress);
  ASSERT_TRUE(mapped);
  EXPECT_EQ(mapped->measured_at, MeasuredAt::kept_vertices);
  const auto finest = extract_terrain(built->terrain(), {.max_error = 20}, progress);
  ASSERT_TRUE(finest);
  EXPECT_EQ(mapped->errors.n_samples + mapped->errors.n_without, finest->surface.positions.size());
  const auto all = extract_mapped_terrain(
      built->terrain(), {.max_error = 200},
      {.map = *utm.map, .name = "other", .samples = MeasuredSamples(grid)}, progress);
  ASSERT_TRUE(all);
  EXPECT_GE(all->errors.error, mapped->errors.error);
  EXPECT_GT(mapped->errors.error, 20);
}

}  // namespace
}  // namespace lode
