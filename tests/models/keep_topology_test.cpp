// Coarse surfaces that keep the topology of full resolution, piece by piece.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <vector>

#include "lode/api/dataset.h"
#include "lode/api/dataset_impl.h"
#include "lode/mappers/surface_checks.h"
#include "lode/mappers/surface_topology.h"
#include "lode/models/diamond/build.h"
#include "lode/models/diamond/critical_nodes.h"
#include "lode/models/diamond/cut_check.h"
#include "tests/models/kept_surfaces.h"
#include "tests/oracles/analytic_fields.h"
#include "tests/oracles/random.h"
#include "tests/oracles/synthetic_volumes.h"
#include "tests/oracles/trials.h"
#include "tests/oracles/typed_samples.h"

namespace lode {
namespace {

using namespace test;

/// How many of the tolerances change the topology where nothing keeps it.
int expect_kept(const Volume& volume, double isovalue, const std::vector<double>& tolerances) {
  const Dataset dataset = built_in_memory(volume);
  const ComponentTypes expected = pieces_of(surface_of(dataset, isovalue, 0.0, kNotKept));
  int n_changed = 0;
  for (const double tolerance : tolerances) {
    SCOPED_TRACE(tolerance);
    EXPECT_EQ(pieces_of(surface_of(dataset, isovalue, tolerance, 0.0)), expected);
    n_changed += pieces_of(surface_of(dataset, isovalue, tolerance, kNotKept)) != expected ? 1 : 0;
  }
  return n_changed;
}

TEST(keep_topology, surfaces_of_several_isovalues_do_not_meet) {
  std::uint64_t n_apart = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Dataset dataset = built_in_memory(smoothed_noise({{22, 19, 17}}, seed, 1));
    const std::vector<double> isovalues{0.15, 0.4};
    Progress progress;
    Surface all;
    ASSERT_TRUE(dataset.extract({.isovalues = isovalues,
                                 .max_error = kAny,
                                 .keep_topology = 0.0,
                                 .normals = Normals::off,
                                 .threads = {2}},
                                all, progress));
    EXPECT_EQ(check_self_intersections(all, {2}, progress)->n_intersections, 0U);
    ComponentTypes expected;
    Surface apart;
    for (const double isovalue : isovalues) {
      const ComponentTypes full = pieces_of(surface_of(dataset, isovalue, 0.0, kNotKept));
      expected.insert(expected.end(), full.begin(), full.end());
      const Surface one = surface_of(dataset, isovalue, kAny, 0.0);
      const auto n = static_cast<std::uint32_t>(apart.positions.size());
      apart.origin = one.origin;
      apart.positions.insert(apart.positions.end(), one.positions.begin(), one.positions.end());
      for (const auto& t : one.triangles) apart.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    }
    std::ranges::sort(expected);
    EXPECT_EQ(pieces_of(all), expected);
    n_apart += check_self_intersections(apart, {2}, progress)->n_intersections;
  }
  EXPECT_GT(n_apart, 0U) << "what is tested happens by itself";
}

TEST(keep_topology, of_noise_at_any_tolerance) {
  int n_changed = 0;
  int n = 0;
  for (const Index3& dims : oracles::trials<std::vector<Index3>>(
           {{{33, 33, 33}},
            {{30, 25, 19}},
            {{17, 41, 9}},
            {{2, 20, 33}},
            {{49, 33, 65}},
            {{34, 34, 34}}},
           {{{30, 25, 19}}, {{17, 41, 9}}, {{2, 20, 33}}, {{34, 34, 17}}}))
    for (const int n_rounds : {0, 1, 2})
      for (std::uint64_t seed = 1; seed <= oracles::trials(2U, 1U); ++seed) {
        SCOPED_TRACE(::testing::Message() << dims[0] << " " << n_rounds << " " << seed);
        n_changed += expect_kept(smoothed_noise(dims, seed, n_rounds), 0.2, {0.3, 1, kAny});
        n += 3;
      }
  EXPECT_GT(n_changed, n / 2) << "or there is nothing to keep";
}

TEST(keep_topology, of_hundreds_of_small_volumes_of_any_shape) {
  oracles::Random random(12345);
  const auto below = [&](double n) { return static_cast<std::int32_t>(random.uniform(0, n)); };
  int n_changed = 0;
  const auto n_volumes = oracles::trials<std::uint64_t>(300, 50);
  for (std::uint64_t i = 0; i < n_volumes && !HasFailure(); ++i) {
    Index3 dims;
    for (std::int32_t& n : dims.v) n = 2 + below(i % 3 == 0 ? 35 : 16);
    SCOPED_TRACE(::testing::Message() << i << ": " << dims[0] << " " << dims[1] << " " << dims[2]);
    const Volume volume = smoothed_noise(dims, i, below(3));
    n_changed += expect_kept(volume, random.uniform(-0.3, 0.3), {0.2, kAny});
  }
  EXPECT_GT(3 * n_changed, 2 * static_cast<int>(n_volumes));
}

TEST(keep_topology, where_many_samples_are_at_the_isovalue) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(3U, 1U); ++seed) {
    const Volume volume = oracles::integer_noise(
        {{29, 33, 21}}, {.type = ScalarType::int16, .seed = seed, .low = -2, .high = 2});
    for (const double isovalue : {-1.0, 0.0, 0.5, 1.0})
      EXPECT_GT(expect_kept(volume, isovalue, {1, kAny}), 0);
  }
}

TEST(keep_topology, of_smooth_fields_with_few_triangles) {
  const Dataset dataset = built_in_memory(oracles::sample(oracles::Field::gaussians40, 65));
  const Surface full = surface_of(dataset, 1.0, 0.0, kNotKept);
  const Surface kept = surface_of(dataset, 1.0, kAny, 0.0);
  EXPECT_EQ(pieces_of(kept), pieces_of(full));
  EXPECT_NE(pieces_of(surface_of(dataset, 1.0, kAny, kNotKept)), pieces_of(full));
  EXPECT_LT(kept.triangles.size(), full.triangles.size() / 10);
}

TEST(keep_topology, of_a_single_sample_and_of_a_tunnel_one_sample_wide) {
  RegularGrid grid;
  grid.dims = {{65, 65, 65}};
  const Volume volume = oracles::volume_of<float>(grid, [](const Index3& p) {
    if (p == Index3{{13, 37, 50}}) return 1.0;
    const bool is_in_box =
        p[0] > 20 && p[0] < 44 && p[1] > 8 && p[1] < 30 && p[2] > 20 && p[2] < 41;
    const bool is_in_tunnel = p[1] == 19 && p[2] == 30;
    return is_in_box && !is_in_tunnel ? 1.0 : 0.0;
  });
  const Dataset dataset = built_in_memory(volume);
  const ComponentTypes expected{{0, 0}, {2, 0}};  // a torus and a sphere
  EXPECT_EQ(pieces_of(surface_of(dataset, 0.5, 0.0, kNotKept)), expected);
  EXPECT_EQ(pieces_of(surface_of(dataset, 0.5, kAny, 0.0)), expected);
  EXPECT_EQ(pieces_of(surface_of(dataset, 0.5, {}, 0.0, 30.0)), expected) << "within a distance";
}

/// Solids of values from the isovalue up, none of which meets the border: surfaces turned outward.
std::size_t count_solids(const Surface& surface) {
  const std::size_t n = surface.positions.size();
  std::vector<std::uint32_t> parent(n);
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& t : surface.triangles)
    for (std::size_t i = 1; i < 3; ++i) parent[root(t[i])] = root(t[0]);
  std::vector<double> volume(n);
  for (const auto& t : surface.triangles) {
    std::array<Vec3d, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = surface.world_position(t[i]);
    volume[root(t[0])] += dot(p[0], cross(p[1], p[2]));
  }
  // Triangles are counter-clockwise seen from lower values.
  return static_cast<std::size_t>(
      std::count_if(volume.begin(), volume.end(), [](double v) { return v > 0; }));
}

/// Pieces of {F >= low} that reach high, joined more readily than any mesh on the samples does.
std::size_t count_persistent(const Volume& volume, double low, double high) {
  const Index3& dims = volume.info.grid.dims;
  const auto values = volume.as<float>();
  const auto at = [&](const Index3& p) {
    return (static_cast<std::size_t>(p[2]) * static_cast<std::size_t>(dims[1]) +
            static_cast<std::size_t>(p[1])) *
               static_cast<std::size_t>(dims[0]) +
           static_cast<std::size_t>(p[0]);
  };
  std::vector<bool> is_seen(values.size());
  std::size_t n = 0;
  std::vector<Index3> waiting;
  for (std::int32_t z = 0; z < dims[2]; ++z)
    for (std::int32_t y = 0; y < dims[1]; ++y)
      for (std::int32_t x = 0; x < dims[0]; ++x) {
        const Index3 first{{x, y, z}};
        if (is_seen[at(first)] || static_cast<double>(values[at(first)]) < high) continue;
        ++n;
        is_seen[at(first)] = true;
        waiting.push_back(first);
        while (!waiting.empty()) {
          const Index3 p = waiting.back();
          waiting.pop_back();
          for (std::int32_t i = 0; i < 27; ++i) {
            const Index3 q = p + Index3{{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}};
            bool is_sample = true;
            for (std::size_t axis = 0; axis < 3; ++axis)
              is_sample = is_sample && q[axis] >= 0 && q[axis] < dims[axis];
            if (!is_sample || is_seen[at(q)] || static_cast<double>(values[at(q)]) < low) continue;
            is_seen[at(q)] = true;
            waiting.push_back(q);
          }
        }
      }
  return n;
}

TEST(keep_topology, of_what_persists) {
  for (const Index3& dims :
       oracles::trials<std::vector<Index3>>({{{49, 33, 65}}, {{38, 45, 31}}}, {{{38, 30, 17}}}))
    for (const int n_rounds : {0, 1, 2})
      for (const double sign : {1.0, -1.0}) {
        SCOPED_TRACE(::testing::Message() << dims[0] << " " << n_rounds << " " << sign);
        Volume volume = smoothed_noise(dims, 4, n_rounds);
        auto* const values = reinterpret_cast<float*>(volume.samples.data());
        for (std::size_t i = 0; i < volume.as<float>().size(); ++i) {
          const auto p = static_cast<std::int32_t>(i);
          const Index3 q{{p % dims[0], p / dims[0] % dims[1], p / dims[0] / dims[1]}};
          bool is_at_border = false;
          for (std::size_t axis = 0; axis < 3; ++axis)
            is_at_border = is_at_border || q[axis] == 0 || q[axis] == dims[axis] - 1;
          values[i] = is_at_border ? -9.0F : static_cast<float>(sign) * values[i];
        }
        const Dataset dataset = built_in_memory(volume);
        std::size_t n_before = std::numeric_limits<std::size_t>::max();
        for (const double persistence : {0.0, 0.1, 0.3, 0.6, 1.2}) {
          SCOPED_TRACE(persistence);
          const Surface kept = surface_of(dataset, 0.2, kAny, persistence);
          EXPECT_GE(count_solids(kept),
                    count_persistent(volume, 0.2 - persistence, 0.2 + persistence));
          EXPECT_LE(kept.triangles.size(), n_before);
          n_before = kept.triangles.size();
        }
      }
}

TEST(keep_topology, between_holes) {
  for (const std::uint64_t seed : {1U, 2U}) {
    Volume volume = smoothed_noise({{33, 40, 35}}, seed, 2);
    oracles::Random random(seed);
    auto* const values = reinterpret_cast<float*>(volume.samples.data());
    for (int i = 0; i < 30; ++i)
      values[static_cast<std::size_t>(random.uniform(0, 33.0 * 40 * 35))] =
          std::numeric_limits<float>::quiet_NaN();
    // Pinched vertices come twice; the pieces are the same.
    const Dataset dataset = built_in_memory(volume);
    const auto full = check_topology(surface_of(dataset, 0.2, 0.0, kNotKept), {});
    const auto kept = check_topology(surface_of(dataset, 0.2, kAny, 0.0), {});
    ASSERT_EQ(kept.components.size(), full.components.size());
    EXPECT_EQ(kept.euler_number, full.euler_number);
  }
}

const VerifyReport::Check* check_of(const VerifyReport& report, std::string_view begin) {
  const auto found = std::ranges::find_if(
      report.checks, [&](const auto& check) { return check.name.starts_with(begin); });
  return found == report.checks.end() ? nullptr : &*found;
}

/// Also that no fewer regions are left than persist.
TEST(keep_topology, with_a_persistence_is_verified) {
  const Dataset dataset = built_in_memory(smoothed_noise({{33, 30, 35}}, 5, 2));
  for (const bool is_simplified : {false, true}) {
    ExtractOptions options{.isovalues = {0.2}, .max_error = 0.6, .keep_topology = 0.1};
    if (is_simplified) options.simplify = Simplify::edges;
    Progress progress;
    Surface surface;
    ASSERT_TRUE(dataset.extract(options, surface, progress));
    const auto report = dataset.verify_surface(surface, options, progress);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->passed());
    const auto* const regions = check_of(*report, "at least as many regions as persist by 0.1");
    ASSERT_NE(regions, nullptr);
    EXPECT_FALSE(regions->skipped);
    const auto none = dataset.verify_surface({}, options, progress);
    ASSERT_TRUE(none);
    const auto* const lost = check_of(*none, "at least as many regions as persist by 0.1");
    EXPECT_EQ(lost->count, regions->count);
    EXPECT_GT(lost->count, 2U);
    EXPECT_FALSE(lost->passed);
    EXPECT_TRUE(lost->detail.ends_with("persist, the surface parts 1")) << lost->detail;
    if (is_simplified) continue;
    // Without the persistence it is another cut, and so it is without a triangle.
    ExtractOptions others = options;
    others.keep_topology = 0;
    const auto other = dataset.verify_surface(surface, others, progress);
    ASSERT_TRUE(other);
    EXPECT_FALSE(other->passed());
    surface.triangles.pop_back();
    const auto torn = dataset.verify_surface(surface, options, progress);
    ASSERT_TRUE(torn);
    const auto* const complete = check_of(*torn, "complete");
    ASSERT_NE(complete, nullptr);
    EXPECT_FALSE(complete->passed);
  }
}

/// Not the coarser one that the tolerance alone leaves.
TEST(keep_topology, verification_checks_the_cut_that_was_extracted) {
  const Dataset dataset = built_in_memory(smoothed_noise({{33, 30, 35}}, 5, 2));
  const ExtractOptions options{.isovalues = {0.2}, .max_error = 1, .keep_topology = 0};
  Progress progress;
  Surface surface;
  const auto extracted = dataset.extract(options, surface, progress);
  const auto report = dataset.verify_surface(surface, options, progress);
  ASSERT_TRUE(extracted && report);
  EXPECT_TRUE(report->passed());
  const auto& model = std::get<diamond::Model<3>>(**dataset.impl().model(progress));
  const auto nodes = diamond::find_critical_nodes(model, {0.2, 0, {2}}, progress);
  diamond::IsosurfaceQuery query{.isovalue = 0.2, .tolerance = 1};
  const auto coarse = diamond::check_cut<3>(model, query, progress);
  query.wanted = &nodes->nodes;
  const auto kept = diamond::check_cut<3>(model, query, progress);
  EXPECT_NE(kept->n_active_samples, coarse->n_active_samples);
  EXPECT_EQ(kept->achieved_error, extracted->achieved_error);
  const auto is_of_leaves = [](const auto& check) { return check.name.starts_with("F' within"); };
  const auto check = std::ranges::find_if(report->checks, is_of_leaves);
  ASSERT_NE(check, report->checks.end());
  EXPECT_EQ(check->count, kept->n_active_samples);
}

TEST(keep_topology, whatever_the_threads) {
  const Dataset dataset = built_in_memory(smoothed_noise({{70, 40, 65}}, 5, 1));
  for (const double persistence : {0.0, 0.2}) {
    const Surface expected = surface_of(dataset, 0.2, kAny, persistence, {}, 1);
    for (const int threads : {2, 3, 7}) {
      const Surface surface = surface_of(dataset, 0.2, kAny, persistence, {}, threads);
      EXPECT_TRUE(surface.positions == expected.positions);
      EXPECT_TRUE(surface.triangles == expected.triangles);
    }
  }
}

TEST(keep_topology, is_refused_with_what_drops_or_cuts_pieces) {
  const Dataset dataset = built_in_memory(smoothed_noise({{9, 9, 9}}, 5, 1));
  const auto expect_refused = [&](const ExtractOptions& options, const char* why) {
    Progress progress;
    Surface surface;
    const auto refused = dataset.extract(options, surface, progress);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(why), std::string::npos) << refused.error().message;
  };
  expect_refused({.isovalues = {0.2}, .keep_topology = 0, .min_component = 5}, "min_component");
  expect_refused({.isovalues = {0.2}, .keep_topology = 0, .clip = Box3d{{{0, 0, 0}}, {{2, 2, 2}}}},
                 "clip box");
}

}  // namespace
}  // namespace lode
