// Meshes of terrain in another CRS, whose errors are measured there again.
#include "lode/api/mapped_terrain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

#include "lode/api/files.h"
#include "lode/io/gdal_crs.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode {
namespace {

using delaunay::test::make_grid;
using delaunay::test::set_missing;

class FunctionMap final : public PlaceMap {
 public:
  explicit FunctionMap(std::function<Place(const Place&)> function)
      : function_(std::move(function)) {}
  void apply(std::span<Place> places) const override {
    for (Place& place : places) place = function_(place);
  }
  [[nodiscard]] std::unique_ptr<const PlaceMap> copy() const override {
    return std::make_unique<FunctionMap>(function_);
  }

 private:
  std::function<Place(const Place&)> function_;
};

/// Universal Transverse Mercator of WGS 84 by Krueger's series (1912) up to n^4, which is short of
/// the projection by terms of n^5 = 1.3e-14 of the earth's radius, 1e-7 m.
Place to_utm(const Place& degrees, double central) {
  constexpr double kRadian = std::numbers::pi / 180;
  const double f = 1 / 298.257223563;
  const double n = f / (2 - f);
  const double n2 = n * n;
  const double radius = 6378137 / (1 + n) * (1 + n2 / 4 + n2 * n2 / 64);
  const std::array<double, 4> alpha{n / 2 - 2 * n2 / 3 + 5 * n2 * n / 16 + 41 * n2 * n2 / 180,
                                    13 * n2 / 48 - 3 * n2 * n / 5 + 557 * n2 * n2 / 1440,
                                    61 * n2 * n / 240 - 103 * n2 * n2 / 140,
                                    49561 * n2 * n2 / 161280};
  const double s = std::sin(degrees[1] * kRadian);
  const double l = (degrees[0] - central) * kRadian;
  const double e = 2 * std::sqrt(n) / (1 + n);
  const double t = std::sinh(std::atanh(s) - e * std::atanh(e * s));
  const double xi = std::atan(t / std::cos(l));
  const double eta = std::atanh(std::sin(l) / std::hypot(1, t));
  Place sum{{eta, xi}};
  for (std::size_t j = 0; j < 4; ++j) {
    const double k = 2 * (static_cast<double>(j) + 1);
    sum[0] += alpha[j] * std::cos(k * xi) * std::sinh(k * eta);
    sum[1] += alpha[j] * std::sin(k * xi) * std::cosh(k * eta);
  }
  return {{500000 + 0.9996 * radius * sum[0], 0.9996 * radius * sum[1]}};
}

TargetCrs open_target(const std::string& source, const std::string& target,
                      const Place& middle = {{9, 46}}) {
  auto made = open_target_crs(source, target, middle);
  if (!made) ADD_FAILURE() << made.error().message;
  return std::move(made).value();
}

TEST(target_crs, has_coordinates_of_a_transverse_mercator_by_its_series) {
  const TargetCrs target = open_target("EPSG:4326", "EPSG:32632");
  EXPECT_EQ(target.name, "WGS 84 / UTM zone 32N");
  std::vector<Place> places;
  for (double x = 6; x <= 12; x += 0.25)
    for (double y = 0.5; y < 84; y += 1.5) places.push_back({{x, y}});
  std::vector<Place> mapped = places;
  target.map->apply(mapped);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Place wanted = to_utm(places[i], 9);
    ASSERT_NEAR(mapped[i][0], wanted[0], 1e-6) << places[i][0] << ' ' << places[i][1];
    ASSERT_NEAR(mapped[i][1], wanted[1], 1e-6) << places[i][0] << ' ' << places[i][1];
  }
  const TargetCrs back = open_target("EPSG:32632", "EPSG:4326", {{500000, 5e6}});
  back.map->copy()->apply(mapped);
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_NEAR(mapped[i][0], places[i][0], 1e-10);
    ASSERT_NEAR(mapped[i][1], places[i][1], 1e-10);
  }
}

TEST(target_crs, has_no_place_for_what_it_has_none) {
  const TargetCrs mercator = open_target("EPSG:4326", "EPSG:3857");
  std::vector<Place> places{{{9, 46}}, {{9, 91}}, {{INFINITY, 3}}, {{9, 46}}};
  mercator.map->apply(places);
  EXPECT_EQ(places[0], places[3]);
  EXPECT_NEAR(places[0][0], 9 * 6378137 * std::numbers::pi / 180, 1e-6);
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_TRUE(std::isnan(places[i][0])) << i;
    EXPECT_TRUE(std::isnan(places[i][1])) << i;
  }
}

TEST(target_crs, has_longitudes_without_jumps) {
  const TargetCrs shifted = open_target("EPSG:4326", "EPSG:4258", {{180, -17}});
  std::vector<Place> places{{{179.5, -17}}, {{180.5, -17}}, {{359, 3}}};
  shifted.map->apply(places);
  EXPECT_NEAR(places[0][0], 179.5, 1e-4);
  EXPECT_NEAR(places[1][0], 180.5, 1e-4);
  EXPECT_NEAR(places[2][0], 359, 1e-4);
  const TargetCrs fiji = open_target("EPSG:32760", "EPSG:4326", {{820000, 8.1e6}});
  places = {{{700000, 8.1e6}}, {{900000, 8.1e6}}};
  fiji.map->apply(places);
  // 200 km at 17 degrees south, on either side of where they jump.
  EXPECT_NEAR(places[1][0] - places[0][0], 1.88, 0.01);
}

TEST(target_crs, refuses_what_is_not_one_of_x_and_y) {
  const auto reason = [](const std::string& source, const std::string& target) {
    const auto made = open_target_crs(source, target, {{9, 46}});
    return made ? std::string() : made.error().message;
  };
  for (const char* with_heights : {"EPSG:5773", "EPSG:4979", "EPSG:4326+5773"})
    EXPECT_NE(reason("EPSG:4326", with_heights).find("--to-vertical-crs"), std::string::npos)
        << with_heights << reason("EPSG:4326", with_heights);
  EXPECT_NE(reason("EPSG:4326", "EPSG:4978").find("geocentric"), std::string::npos);
  EXPECT_NE(reason("EPSG:4326", "utm").find("WKT"), std::string::npos);
  EXPECT_NE(reason("EPSG:4156", "EPSG:5513").find("EPSG:5514"), std::string::npos)
      << reason("EPSG:4156", "EPSG:5513");
  EXPECT_EQ(reason("EPSG:4156", "EPSG:5514"), "");
  EXPECT_NE(reason("EPSG:4326", R"(LOCAL_CS["site",UNIT["metre",1]])").find("no place"),
            std::string::npos);
  EXPECT_NE(reason("", "EPSG:32632").find("--crs"), std::string::npos);
  EXPECT_NE(reason(R"(LOCAL_CS["site",UNIT["metre",1]])", "EPSG:32632").find("site"),
            std::string::npos);
}

TEST(target_crs, says_where_datums_are_guessed) {
  EXPECT_FALSE(open_target("EPSG:4326", "EPSG:32632").is_guess);
  EXPECT_FALSE(open_target("EPSG:4326", "EPSG:3035").is_guess);
  const std::string unknown =
      R"(GEOGCS["here",DATUM["somewhere",SPHEROID["Clarke 1866",6378206.4,294.9786982138982]],)"
      R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
  EXPECT_TRUE(open_target(unknown, "EPSG:32632").is_guess);
}

TEST(target_crs, keeps_what_heights_are_above) {
  const auto wkt = [](const std::string& crs) { return io::to_wkt(crs).value(); };
  EXPECT_EQ(vertical_name(open_target("EPSG:4326", "EPSG:32632").crs), "");
  EXPECT_EQ(vertical_name(open_target(wkt("EPSG:4326+5773"), "EPSG:32632").crs), "EGM96 height");
  EXPECT_EQ(vertical_name(open_target(wkt("EPSG:4979"), "EPSG:32632").crs), "ellipsoid");
  const auto other = open_target_crs(wkt("EPSG:4979"), "EPSG:31467", {{9, 46}});
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("--to-vertical-crs"), std::string::npos);
}

double waves(std::int32_t x, std::int32_t y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

/// Two hundredths of a degree apart, rows from the north; some are missing.
std::shared_ptr<const HeightGrid> degree_grid() {
  HeightGrid grid = make_grid<std::int16_t>(60, 50, waves);
  grid.to_world = {7.01, 0.02, 0, 46.99, 0, -0.02};
  grid.crs = "EPSG:4326";
  for (std::int32_t i = 0; i < 40; ++i) set_missing(grid, 20 + i % 8, 11 + i / 8);
  set_missing(grid, 58, 48);
  set_missing(grid, 59, 47);
  return std::make_shared<const HeightGrid>(std::move(grid));
}

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

/// On a sphere of radius 1 seen from a pole: radii and angles.
Place to_disc(const Place& p) { return {{p[1] * std::cos(p[0]), p[1] * std::sin(p[0])}}; }

TEST(mapped_distance, is_along_what_a_segment_becomes) {
  HorizontalMetric metric{.is_known = true};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(
      HorizontalMetric{.is_known = true, .length_unit = 0.5, .unit = "half"});
  metric.map = std::make_shared<const FunctionMap>(to_disc);
  EXPECT_NEAR(metric.distance({{0.1, 3}}, {{2.6, 3}}), 7.5, 1e-9) << "an arc";
  EXPECT_NEAR(metric.distance({{0.1, 3}}, {{0.1, 5}}), 2, 1e-12) << "a ray";
  // Archimedes' spiral r = a from 0 to a: (a sqrt(1 + a^2) + asinh(a)) / 2.
  EXPECT_NEAR(metric.distance({{0, 0}}, {{2, 2}}), (2 * std::sqrt(5) + std::asinh(2)) / 2, 1e-9);
  EXPECT_EQ(metric.metres(), 0.5);
  metric.map = std::make_shared<const FunctionMap>([](const Place&) { return Place{{NAN, NAN}}; });
  EXPECT_TRUE(std::isnan(metric.distance({{0, 0}}, {{2, 2}})));
}

TEST(mapped_distance, is_none_where_the_map_jumps) {
  HorizontalMetric metric{.is_known = true};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(HorizontalMetric{.is_known = true});
  for (const double jump : {0.5, 20.0, 4e7}) {
    metric.map = std::make_shared<const FunctionMap>([&](const Place& p) {
      return Place{{p[0] + (p[0] > 0.3 ? jump : 0), p[1]}};
    });
    EXPECT_TRUE(std::isnan(metric.distance({{-2, 0}}, {{2, 1}}))) << jump;
    EXPECT_NEAR(metric.distance({{-2, 0}}, {{0.25, 1}}), std::hypot(2.25, 1), 1e-12) << jump;
  }
  // Places that are one but for rounding.
  metric.map = std::make_shared<const FunctionMap>([&](const Place& p) {
    return Place{{p[0] + 1e-9 * std::sin(1e9 * p[0]), p[1]}};
  });
  EXPECT_NEAR(metric.distance({{1, 0}}, {{1 + 1e-9, 0}}), 1e-9, 1e-6);
  // Mercator's scale grows without bound, but does not jump.
  const TargetCrs mercator = open_target("EPSG:4326", "EPSG:3857");
  HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  degrees.elsewhere = std::make_shared<const HorizontalMetric>(mercator.metric);
  degrees.map = mercator.map;
  const double radius = kWgs84Ellipsoid.semi_major;
  const double north = radius * std::asinh(std::tan(89.5 * std::numbers::pi / 180));
  EXPECT_NEAR(degrees.distance({{10, 0}}, {{10, 89.5}}), north, 1e-3);
  EXPECT_NEAR(degrees.distance({{10, 50}}, {{10.001, 50}}), radius * 0.001 * std::numbers::pi / 180,
              1e-6);
}

TEST(mapped_distance, crosses_where_longitudes_jump) {
  HorizontalMetric metric{.is_known = true};
  HorizontalMetric degrees{
      .is_known = true, .ellipsoid = kWgs84Ellipsoid, .angle_unit = std::numbers::pi / 180};
  metric.elsewhere = std::make_shared<const HorizontalMetric>(degrees);
  metric.map = std::make_shared<const FunctionMap>([](const Place& p) {
    return Place{{std::remainder(p[0], 360), p[1]}};
  });
  const Place from{{179, 10}};
  const Place to{{183, 12}};
  EXPECT_NEAR(metric.distance(from, to), degrees.distance(from, to), 1e-6);
}

TEST(mapped_profile, has_distances_of_the_plane_it_is_measured_in) {
  const auto grid = degree_grid();
  const TargetCrs utm = open_target("EPSG:4326", "EPSG:32632");
  const auto read = read_metric(grid->crs);
  ASSERT_TRUE(read);
  HorizontalMetric metric = *read;
  metric.elsewhere = std::make_shared<const HorizontalMetric>(utm.metric);
  metric.map = utm.map;
  Progress progress;
  const auto tin = TerrainTin::select(Terrain(grid), {.max_error = 40}, metric, progress);
  ASSERT_TRUE(tin);
  const Place from{{7.05, 46.9}};
  const Place to{{8.1, 46.1}};
  const auto profile = tin->profile(from, to, progress);
  ASSERT_TRUE(profile);
  // Chords of 5 m err by less than a part in 10^9.
  constexpr int kChords = 20000;
  double length = 0;
  std::size_t row = 0;
  Place last = to_utm(from, 9);
  for (int i = 1; i <= kChords; ++i) {
    const double t = static_cast<double>(i) / kChords;
    const Place at = from * (1 - t) + to * t;
    const Place mapped = to_utm(at, 9);
    const double step = std::hypot(mapped[0] - last[0], mapped[1] - last[1]);
    // Rows within the step.
    while (row < profile->points.size() && profile->points[row].at[0] <= at[0]) {
      const Place here = to_utm(profile->points[row].at, 9);
      const double share = std::hypot(here[0] - last[0], here[1] - last[1]);
      ASSERT_NEAR(profile->points[row].distance, length + share, 1e-3);
      ++row;
    }
    length += step;
    last = mapped;
  }
  EXPECT_GE(row + 1, profile->points.size());
  EXPECT_NEAR(profile->length, length, 1e-3);
  EXPECT_GT(profile->points.size(), 20U);
  EXPECT_GT(std::abs(profile->length - read->distance(from, to)), 1) << "not the ellipsoid's";
}

TEST(mapped_lines, are_put_elsewhere_and_say_how_they_bend) {
  const FunctionMap bent(bend);
  std::vector<Place> line;
  for (int i = 0; i < 50; ++i) line.push_back({{7 + 0.02 * i, 46.2 + 0.01 * i}});
  std::vector<Place> single{line[3]};
  std::vector<Place> none;
  const std::vector<Place> before = line;
  const std::vector<std::span<Place>> all{line, single, none};
  Progress progress;
  const auto most = map_lines(all, bent, "other", progress);
  ASSERT_TRUE(most);
  double wanted = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    EXPECT_EQ(line[i], bend(before[i]));
    if (i == 0) continue;
    const Place middle = bend((before[i - 1] + before[i]) * 0.5);
    wanted = std::max(wanted, length(middle - (line[i - 1] + line[i]) * 0.5));
  }
  EXPECT_EQ(single[0], bend(before[3]));
  EXPECT_NEAR(*most, wanted, 1e-15);
  const FunctionMap torn([](const Place& p) { return Place{{p[0] < 7.51 ? p[0] : p[0] - 20, 3}}; });
  line = before;
  const auto over = map_lines(all, torn, "other", progress);
  ASSERT_FALSE(over);
  EXPECT_NE(over.error().message.find("seam"), std::string::npos) << over.error().message;
}

}  // namespace
}  // namespace lode
