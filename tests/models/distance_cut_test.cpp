// Surfaces within a distance of full resolution, measured by an oracle that knows nothing of how
// they came.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "lode/api/dataset.h"
#include "lode/mappers/surface_checks.h"
#include "lode/mappers/surface_distance.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/leaf_facets.h"
#include "tests/mappers/distance_oracle.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using oracles::volume_of;

RegularGrid grid_with(const Index3& dims) {
  RegularGrid grid;
  grid.dims = dims;
  return grid;
}

/// Neither its axes nor its steps are the world's.
RegularGrid turned_grid(const Index3& dims) {
  RegularGrid grid = grid_with(dims);
  grid.spacing = {{0.7, 1.9, 3.1}};
  grid.origin = {{-40, 12, 300}};
  grid.direction.rows = {Vec3d{{0.6, 0, -0.8}}, Vec3d{{0, 1, 0}}, Vec3d{{0.8, 0, 0.6}}};
  return grid;
}

Dataset dataset_of(const Volume& volume) {
  Progress progress;
  return Dataset::build(*make_memory_source(volume), {.threads = {2}}, progress).value();
}

struct Extracted {
  Surface surface;
  ExtractReport report;
};

Extracted extracted(const Dataset& dataset, ExtractOptions options, int threads = 2) {
  Progress progress;
  options.threads = {threads};
  options.normals = Normals::off;
  Extracted result;
  auto report = dataset.extract(options, result.surface, progress);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (report) result.report = *report;
  return result;
}

/// The larger of both one-sided distances, found at points on all triangles.
double measured(const Surface& a, const Surface& b) {
  constexpr int kCuts = 3;
  if (a.triangles.empty() || b.triangles.empty())
    return a.triangles.empty() && b.triangles.empty() ? 0 : std::numeric_limits<double>::infinity();
  return std::max(test::one_sided_distance(a, b, kCuts), test::one_sided_distance(b, a, kCuts));
}

/// Extracts within each distance; gives the numbers of triangles, that of full resolution last.
std::vector<std::size_t> expect_near(const Volume& volume, double isovalue,
                                     const std::vector<double>& distances,
                                     std::optional<double> max_error = {}) {
  const Dataset dataset = dataset_of(volume);
  const Surface full = extracted(dataset, {.isovalues = {isovalue}, .max_error = 0.0}).surface;
  std::vector<std::size_t> counts;
  for (const double distance : distances) {
    const auto [surface, report] = extracted(
        dataset, {.isovalues = {isovalue}, .max_error = max_error, .max_distance = distance});
    EXPECT_LE(report.distance->proven_distance, distance);
    EXPECT_EQ(report.distance->lost_triangles, 0U);
    EXPECT_EQ(report.distance->full_triangles, full.triangles.size());
    if (max_error) EXPECT_LE(report.achieved_error, *max_error);
    EXPECT_LE(measured(surface, full), report.distance->proven_distance + 1e-5) << distance;
    counts.push_back(surface.triangles.size());
  }
  counts.push_back(full.triangles.size());
  return counts;
}

template <typename T>
Volume noise(const RegularGrid& grid, std::uint64_t seed, std::uint64_t n_values) {
  oracles::Random random(seed);
  return volume_of<T>(grid, [&](const Index3&) { return random.below(n_values); });
}

double wave(const Index3& p) {
  return std::sin(0.4 * p[0]) + std::cos(0.3 * p[1] + 0.2 * p[2]) * std::sin(0.25 * p[2]);
}

TEST(distance_cut, noise_of_odd_sizes_stays_near) {
  expect_near(noise<std::uint8_t>(grid_with({{9, 7, 11}}), 1, 256), 90.5, {0.3, 1, 2.5});
  expect_near(noise<float>(grid_with({{6, 17, 5}}), 2, 1000), 700.25, {0.7, 4});
}

TEST(distance_cut, noise_with_the_isovalue_at_samples_stays_near) {
  expect_near(noise<std::uint8_t>(grid_with({{8, 7, 9}}), 3, 4), 2, {0.5, 1, 3});
}

TEST(distance_cut, distances_are_the_world_s) {
  const auto counts =
      expect_near(volume_of<float>(turned_grid({{22, 17, 12}}), wave), 0.3, {0.2, 1, 3});
  EXPECT_LT(counts[2], counts[3] / 2);
  expect_near(noise<std::int16_t>(turned_grid({{7, 8, 9}}), 4, 100), 60.5, {1, 4});
}

TEST(distance_cut, larger_distances_leave_fewer_triangles) {
  const auto counts =
      expect_near(volume_of<float>(grid_with({{19, 18, 17}}), wave), 0.2, {0.1, 0.3, 1, 4});
  for (std::size_t i = 1; i < counts.size() - 1; ++i) EXPECT_LT(counts[i], counts[i - 1]);
  EXPECT_LT(counts[2], counts.back() / 3);
}

TEST(distance_cut, holes_stay_near) {
  oracles::Random random(5);
  expect_near(volume_of<float>(
                  grid_with({{13, 12, 14}}),
                  [&](const Index3& p) { return random.below(60) == 0 ? std::nan("") : wave(p); }),
              0.2, {0.3, 1, 5});
}

/// What a coarse cut loses: nothing near it crosses the isovalue.
TEST(distance_cut, a_single_bright_voxel_is_not_lost) {
  for (const Index3& bright : {Index3{{13, 21, 10}}, Index3{{0, 0, 0}}, Index3{{32, 5, 16}}}) {
    const Volume volume = volume_of<std::uint8_t>(
        grid_with({{33, 34, 20}}), [&](const Index3& p) { return p == bright ? 200 : 20; });
    const auto counts = expect_near(volume, 100, {0.1, 1, 5, 100});
    for (const std::size_t n : counts) EXPECT_GT(n, 0U);
  }
}

std::uint64_t n_crossings(const Surface& surface) {
  Progress progress;
  return check_self_intersections(surface, {2}, progress)->n_intersections;
}

/// The triangles at an isovalue, with all vertices.
Surface part_at(const Surface& surface, double isovalue) {
  Surface part = surface;
  std::erase_if(part.triangles, [&](const auto& t) { return surface.isovalues[t[0]] != isovalue; });
  return part;
}

/// One behind the other, as if they had been extracted together.
Surface together(const Surface& a, const Surface& b) {
  Surface both = a;
  EXPECT_EQ(a.origin.v, b.origin.v);
  const auto n = static_cast<std::uint32_t>(a.positions.size());
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) both.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
  return both;
}

/// Level sets do not meet, and neither do coarse ones in one cut, which each on its own would.
TEST(distance_cut, surfaces_of_several_isovalues_do_not_meet) {
  std::uint64_t n_apart = 0;
  for (std::uint64_t seed = 1; seed <= oracles::trials(3U, 1U); ++seed) {
    oracles::Random random(seed);
    const Volume volume = volume_of<float>(turned_grid({{21, 18, 15}}), [&](const Index3& p) {
      return wave(p) + 0.3 * random.uniform(-1, 1);
    });
    const Dataset dataset = dataset_of(volume);
    const std::vector<double> isovalues{0.2, 0.45};
    for (const double distance : {1.0, 2.5}) {
      ExtractOptions options{.isovalues = isovalues, .max_distance = distance};
      const Extracted all = extracted(dataset, options);
      EXPECT_EQ(n_crossings(all.surface), 0U);
      // However isovalues are named.
      const Extracted turned =
          extracted(dataset, {.isovalues = {isovalues[1], isovalues[0]}, .max_distance = distance});
      for (const double isovalue : isovalues)
        EXPECT_EQ(part_at(turned.surface, isovalue).triangles.size(),
                  part_at(all.surface, isovalue).triangles.size());
      std::vector<Surface> alone;
      std::uint64_t n_full = 0;
      for (const double isovalue : isovalues) {
        const Surface full =
            extracted(dataset, {.isovalues = {isovalue}, .max_error = 0.0}).surface;
        n_full += full.triangles.size();
        EXPECT_LE(measured(part_at(all.surface, isovalue), full), distance + 1e-5);
        options.isovalues = {isovalue};
        alone.push_back(extracted(dataset, options).surface);
      }
      EXPECT_EQ(all.report.distance->full_triangles, n_full);
      n_apart += n_crossings(together(alone[0], alone[1]));
    }
  }
  EXPECT_GT(n_apart, 0U) << "what is tested happens by itself";
}

TEST(distance_cut, a_distance_beyond_the_volume_still_has_a_surface_for_each_isovalue) {
  const auto counts = expect_near(noise<std::uint8_t>(grid_with({{9, 9, 9}}), 6, 256), 128.5, {50});
  EXPECT_GT(counts[0], 0U);
  EXPECT_LT(counts[0], counts[1] / 4);
}

TEST(distance_cut, a_tiny_distance_gives_full_resolution) {
  const Volume volume = noise<float>(turned_grid({{9, 8, 7}}), 7, 500);
  for (const double distance : {1e-3, 1e-9, 1e-30}) {
    const auto counts = expect_near(volume, 250.5, {distance});
    EXPECT_EQ(counts[0], counts[1]) << distance;
  }
}

TEST(distance_cut, both_tolerances_hold) {
  const Volume volume = volume_of<float>(grid_with({{20, 17, 15}}), wave);
  const auto loose = expect_near(volume, 0.2, {1});
  const auto both = expect_near(volume, 0.2, {1}, 0.01);
  const auto error_alone = extracted(dataset_of(volume), {.isovalues = {0.2}, .max_error = 0.01});
  EXPECT_GT(both[0], loose[0]);
  EXPECT_GE(both[0], error_alone.surface.triangles.size());
}

TEST(distance_cut, full_resolution_is_counted_as_such) {
  const Dataset dataset = dataset_of(volume_of<float>(grid_with({{12, 10, 9}}), wave));
  const auto [surface, report] =
      extracted(dataset, {.isovalues = {0.2, 0.4}, .max_error = 0.0, .max_distance = 1.0});
  EXPECT_EQ(report.distance->full_triangles, surface.triangles.size());
  EXPECT_EQ(report.distance->proven_distance, 0);
}

/// Else this file's other tests would say nothing.
TEST(distance_cut, a_tolerance_in_field_units_alone_breaks_the_distance) {
  const Dataset dataset = dataset_of(noise<std::uint8_t>(grid_with({{9, 11, 10}}), 8, 256));
  const Surface full = extracted(dataset, {.isovalues = {128.5}, .max_error = 0.0}).surface;
  const Surface coarse = extracted(dataset, {.isovalues = {128.5}, .max_error = 200.0}).surface;
  EXPECT_GT(measured(coarse, full), 1);
}

TEST(distance_cut, gives_the_same_for_any_number_of_threads) {
  const Dataset dataset = dataset_of(noise<std::uint8_t>(
      grid_with(oracles::trials<Index3>({{21, 19, 22}}, {{17, 13, 18}})), 9, 256));
  const ExtractOptions options{.isovalues = {100.5}, .max_distance = 1.2};
  const Extracted one = extracted(dataset, options, 1);
  for (const int threads : oracles::trials<std::vector<int>>({2, 5}, {5})) {
    const Extracted other = extracted(dataset, options, threads);
    EXPECT_EQ(other.surface.positions, one.surface.positions);
    EXPECT_EQ(other.surface.triangles, one.surface.triangles);
    EXPECT_EQ(other.report.distance->proven_distance, one.report.distance->proven_distance);
    EXPECT_EQ(other.report.distance->rounds, one.report.distance->rounds);
  }
}

TEST(distance_cut, gives_whole_surfaces_that_verify_measures) {
  Progress progress;
  const Dataset dataset = dataset_of(volume_of<float>(turned_grid({{30, 25, 20}}), wave));
  const ExtractOptions options{.isovalues = {0.2}, .max_distance = 1.5, .threads = {2}};
  Extracted found = extracted(dataset, options);
  const auto report = dataset.verify_surface(found.surface, options, progress);
  ASSERT_TRUE(report) << report.error().message;
  for (const auto& check : report->checks) EXPECT_TRUE(check.passed) << check.name << check.detail;
  ASSERT_NE(report->checks.back().name.find("distance from that at full resolution"),
            std::string::npos);
  for (Vec3f& p : found.surface.positions) p[1] += 4;
  EXPECT_FALSE(dataset.verify_surface(found.surface, options, progress)->checks.back().passed);
}

TEST(distance_cut, refuses_what_it_cannot_keep) {
  const Dataset dataset = dataset_of(noise<std::uint8_t>(grid_with({{5, 5, 5}}), 10, 256));
  const auto expect_refused = [&](ExtractOptions options, const std::string& why) {
    Progress progress;
    Surface surface;
    options.isovalues = {128};
    const auto report = dataset.extract(options, surface, progress);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find(why), std::string::npos) << report.error().message;
  };
  expect_refused({.max_distance = 0.0}, "expected a finite max_distance > 0, got 0");
  expect_refused({.max_distance = std::nan("")}, "got nan");
  expect_refused({.max_distance = 1.0, .border = Border::closed}, "expected an open border");
  expect_refused({.max_distance = 1.0, .min_component = 5}, "got min_component 5");
  expect_refused({.max_distance = 1.0, .clip = Box3d{{{0, 0, 0}}, {{1, 1, 1}}}}, "clip box");
}

TEST(simplified_surface, is_verified_of_volumes_and_triangles_alone) {
  Progress progress;
  const Dataset flat = dataset_of(noise<std::uint8_t>(grid_with({{9, 8, 1}}), 3, 256));
  ExtractOptions options{.isovalues = {100}, .max_error = 0};
  Surface contour;
  ASSERT_TRUE(flat.extract(options, contour, progress));
  options.simplify = Simplify::edges;
  options.simplify_distance = 0.5;
  const auto refused = flat.verify_surface(contour, options, progress);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("expected a volume"), std::string::npos);
  const Dataset volume = dataset_of(volume_of<float>(grid_with({{9, 8, 7}}), wave));
  options.isovalues = {0.2};
  const auto failed = volume.verify_surface(contour, options, progress);
  ASSERT_TRUE(failed) << failed.error().message;
  EXPECT_FALSE(failed->passed());
  options.simplify_distance = -1;
  EXPECT_FALSE(volume.verify_surface(contour, options, progress));
}

TEST(distance_cut, stops_when_cancelled) {
  const Dataset dataset = dataset_of(noise<std::uint8_t>(grid_with({{33, 33, 33}}), 11, 256));
  Progress* running = nullptr;
  Progress progress([&](std::string_view phase, double, std::uint64_t) {
    if (phase == "proving the distance") running->cancel();
  });
  running = &progress;
  Surface surface;
  const auto report = dataset.extract({.isovalues = {128.5}, .max_distance = 1}, surface, progress);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, cancelled_error().message);
}

std::multiset<std::array<float, 9>> triangles_of(const Surface& surface) {
  std::multiset<std::array<float, 9>> all;
  for (const auto& t : surface.triangles) {
    std::array<Vec3f, 3> corners{surface.positions[t[0]], surface.positions[t[1]],
                                 surface.positions[t[2]]};
    std::sort(corners.begin(), corners.end(), [](auto& a, auto& b) { return a.v < b.v; });
    std::array<float, 9> flat{};
    for (std::size_t i = 0; i < 9; ++i) flat[i] = corners[i / 3][i % 3];
    all.insert(flat);
  }
  return all;
}

/// What distances are proven of is what is written.
TEST(distance_cut, facets_are_the_surface_to_the_bit) {
  const Volume volume = noise<std::uint8_t>(turned_grid({{35, 18, 13}}), 12, 256);
  Progress progress;
  const auto model =
      diamond::build<3>(*make_memory_source(volume), {.threads = {2}}, progress).value();
  for (const double tolerance : {0.0, 60.0}) {
    const diamond::IsosurfaceQuery query{.isovalue = 100.5, .tolerance = tolerance};
    Surface surface;
    ASSERT_TRUE(diamond::extract_isosurface<3>(model, query, surface, progress));
    const auto facets = tolerance == 0 ? diamond::full_facets(model, query, progress)
                                       : diamond::cut_facets(model, query, nullptr, progress);
    Surface from_facets;
    for (const Facet& facet : facets) {
      const auto first = static_cast<std::uint32_t>(from_facets.positions.size());
      from_facets.positions.insert(from_facets.positions.end(), facet.corner.begin(),
                                   facet.corner.end());
      from_facets.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_EQ(triangles_of(from_facets), triangles_of(surface));
  }
}

TEST(surface_distance, bounds_hold_what_is_measured) {
  const Dataset dataset = dataset_of(noise<std::uint8_t>(grid_with({{9, 8, 9}}), 13, 256));
  const Surface full = extracted(dataset, {.isovalues = {128.5}, .max_error = 0.0}).surface;
  const Surface coarse = extracted(dataset, {.isovalues = {128.5}, .max_error = 150.0}).surface;
  Progress progress;
  const auto found = measure_distance(coarse, full, {.accuracy = 0.02, .threads = {2}}, progress);
  ASSERT_TRUE(found);
  const double there = test::one_sided_distance(coarse, full, 6);
  const double back = test::one_sided_distance(full, coarse, 6);
  EXPECT_LE(there, found->from_first.upper);
  EXPECT_LE(back, found->from_second.upper);
  EXPECT_LE(found->from_first.upper, found->from_first.lower + 0.0201);
  EXPECT_LE(found->from_second.upper, found->from_second.lower + 0.0201);
  EXPECT_GE(there, found->from_first.lower - 0.2);
  EXPECT_GE(back, found->from_second.lower - 0.2);
}

}  // namespace
}  // namespace lode
