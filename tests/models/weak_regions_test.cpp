// Pieces that do not persist are left out: those of regions that can be turned over.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "lode/mappers/surface_match.h"
#include "lode/models/diamond/persistent_regions.h"
#include "lode/models/diamond/region_graph.h"
#include "tests/models/kept_surfaces.h"
#include "tests/models/turned_regions.h"
#include "tests/oracles/trials.h"

namespace lode {
namespace {

using namespace test;

struct Kept {
  Surface surface;
  ExtractReport report;
};

Kept kept_of(const Dataset& dataset, const ExtractOptions& options) {
  Progress progress;
  Kept kept;
  const auto report = dataset.extract(options, kept.surface, progress);
  EXPECT_TRUE(report) << report.error().message;
  if (report) kept.report = *report;
  return kept;
}

ExtractOptions full_resolution(double isovalue, double persistence) {
  return {.isovalues = {isovalue}, .max_error = 0, .keep_topology = persistence};
}

void expect_verified(const Dataset& dataset, const Surface& surface,
                     const ExtractOptions& options) {
  Progress progress;
  const auto report = dataset.verify_surface(surface, options, progress);
  ASSERT_TRUE(report) << report.error().message;
  for (const auto& check : report->checks)
    EXPECT_TRUE(check.passed || check.skipped) << check.name << ": " << check.detail;
}

/// Edges that are crossed do not end in what is turned over, so no vertex moves.
TEST(weak_regions, at_full_resolution_the_rest_stays_where_it_is) {
  std::uint64_t n_weak_corners = 0;
  for (std::uint64_t seed = 1; seed <= oracles::trials(24U, 8U); ++seed)
    for (const Border border : {Border::open, Border::closed}) {
      SCOPED_TRACE(seed);
      Volume volume = smoothed_noise({{21, 34, 19}}, seed, static_cast<int>(seed % 2));
      if (seed % 2 != 0) oracles::typed_samples<float>(volume)[0] = seed % 4 == 1 ? 0.2F : 0.0F;
      const double persistence = 0.3;
      const Volume turned = without_weak_regions(volume, volume, 0.1, persistence);
      ExtractOptions options = full_resolution(0.1, persistence);
      options.border = border;
      const Kept kept = kept_of(built_in_memory(volume), options);
      options.keep_topology.reset();
      const Kept expected = kept_of(built_in_memory(turned), options);
      EXPECT_TRUE(match_surfaces(expected.surface, kept.surface, 1e-4).is_same());
      EXPECT_EQ(kept.report.cap_cells, expected.report.cap_cells);
      const auto is_inside = [](const Volume& v) { return v.as<float>()[0] >= 0.1F; };
      n_weak_corners += is_inside(volume) != is_inside(turned) ? 1 : 0;
      EXPECT_GT(kept.report.topology->weak_regions, 0U);
      if (seed > 2) continue;
      options.keep_topology = persistence;
      expect_verified(built_in_memory(volume), kept.surface, options);
    }
  EXPECT_GT(n_weak_corners, 0U);
}

TEST(weak_regions, are_left_out_of_cubes) {
  for (std::uint64_t seed = 1; seed <= oracles::trials(12U, 4U); ++seed) {
    const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, seed, 1));
    for (const double max_error : {0.0, 0.3}) {
      ExtractOptions options = full_resolution(0.1, 0.4);
      const Surface expected = kept_of(dataset, options).surface;
      options.max_error = max_error;
      options.style = SurfaceStyle::cubes;
      EXPECT_EQ(pieces_of(kept_of(dataset, options).surface), pieces_of(expected));
    }
  }
}

using Face = std::array<int, 4>;  ///< Its axis, and its lowest corner.

/// Faces of cells with a vertex inside, which is on their diagonal.
std::set<Face> faces_with_a_vertex(const Surface& surface, const RegularGrid& grid) {
  std::set<Face> faces;
  for (const Vec3f& p : surface.positions) {
    Face face{-1};
    int n_whole = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double at = (static_cast<double>(p[i]) + surface.origin[i]) / grid.spacing[i];
      const bool is_whole = std::abs(at - std::round(at)) < 1e-5;
      face[i + 1] = static_cast<int>(is_whole ? std::round(at) : std::floor(at));
      if (is_whole) face[0] = static_cast<int>(i);
      n_whole += is_whole ? 1 : 0;
    }
    if (n_whole == 1) faces.insert(face);
  }
  return faces;
}

/// Else what is left of a cube could be near a piece of the tetrahedra that is left out.
TEST(weak_regions, leave_no_cubes_beside_them_within_a_distance) {
  const Volume volume = smoothed_noise({{34, 30, 37}}, 3, 1);
  const Volume turned = without_weak_regions(volume, volume, 0.1, 0.4);
  ExtractOptions options = full_resolution(0.1, 0.4);
  options.style = SurfaceStyle::cubes;
  options.style_distance = 1e6;
  const Surface kept = kept_of(built_in_memory(volume), options).surface;
  const auto found = faces_with_a_vertex(kept, volume.info.grid);
  const Index3& dims = volume.info.grid.dims;
  const auto is_inside = [&](const Volume& v, const Index3& p) {
    return v.as<float>()[static_cast<std::size_t>(p[0] + dims[0] * (p[1] + dims[1] * p[2]))] >=
           0.1F;
  };
  const auto is_weak = [&](const Index3& p) {
    return is_inside(volume, p) != is_inside(turned, p);
  };
  std::size_t n_faces = 0;
  for (std::int32_t i = 0; i < (dims[0] - 1) * (dims[1] - 1) * (dims[2] - 1); ++i) {
    const Index3 cell{
        {i % (dims[0] - 1), i / (dims[0] - 1) % (dims[1] - 1), i / (dims[0] - 1) / (dims[1] - 1)}};
    bool has_weak = false;
    for (std::int32_t k = 0; k < 8; ++k)
      has_weak = has_weak || is_weak(cell + Index3{{k % 2, k / 2 % 2, k / 4}});
    if (!has_weak) continue;
    for (std::int32_t side = 0; side < 6; ++side) {
      const auto axis = static_cast<std::size_t>(side / 2);
      Index3 lowest = cell;
      lowest[axis] += side % 2;
      Index3 even = lowest;
      Index3 odd = lowest;
      for (std::size_t k = 0; k < 3; ++k)
        if (k != axis) (lowest[k] % 2 == 0 ? odd : even)[k] += 1;
      if (is_weak(even) || is_weak(odd) || is_inside(volume, even) == is_inside(volume, odd))
        continue;
      EXPECT_TRUE(found.contains({static_cast<int>(axis), lowest[0], lowest[1], lowest[2]}));
      ++n_faces;
    }
  }
  EXPECT_GT(n_faces, 50U);
}

TEST(weak_regions, are_each_isovalues_own) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, 5, 1));
  ExtractOptions options = full_resolution(0.3, 0.25);
  Surface expected = kept_of(dataset, options).surface;
  options.isovalues = {-0.2};
  const Surface other = kept_of(dataset, options).surface;
  const auto n = static_cast<std::uint32_t>(expected.positions.size());
  expected.positions.insert(expected.positions.end(), other.positions.begin(),
                            other.positions.end());
  for (auto triangle : other.triangles) {
    for (std::uint32_t& v : triangle) v += n;
    expected.triangles.push_back(triangle);
  }
  options.isovalues = {0.3, -0.2};
  const Kept both = kept_of(dataset, options);
  EXPECT_TRUE(match_surfaces(expected, both.surface, 1e-4).is_same());
}

TEST(weak_regions, may_be_all_that_there_is) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, 5, 0));
  for (const double max_error : {0.0, 0.2, kAny}) {
    ExtractOptions options = full_resolution(0.1, 5);
    options.max_error = max_error;
    const Kept kept = kept_of(dataset, options);
    EXPECT_TRUE(kept.surface.is_empty());
    EXPECT_EQ(kept.report.unmet, std::vector<double>{0.1});
  }
}

/// As their pieces are, where there are no holes.
TEST(weak_regions, are_counted) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 70, 37}}, 5, 1));
  for (const double max_error : {0.0, 0.2, kAny}) {
    ExtractOptions options = full_resolution(0.1, 0.2);
    options.max_error = max_error;
    const Kept kept = kept_of(dataset, options);
    options.leaves_out_weak = false;
    const Kept all = kept_of(dataset, options);
    EXPECT_FALSE(all.report.topology->leaves_out_weak);
    EXPECT_EQ(all.report.topology->weak_regions, 0U);
    const std::size_t n_kept = check_topology(kept.surface, {}).components.size();
    const std::size_t n_all = check_topology(all.surface, {}).components.size();
    EXPECT_EQ(n_all - n_kept, kept.report.topology->weak_regions);
    EXPECT_GT(n_all, n_kept);
  }
}

TEST(weak_regions, are_missed_by_verification_where_they_stay) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, 5, 1));
  for (const double max_error : {0.0, 0.2}) {
    ExtractOptions options = full_resolution(0.1, 0.2);
    options.max_error = max_error;
    const Kept kept = kept_of(dataset, options);
    options.leaves_out_weak = false;
    const Kept all = kept_of(dataset, options);
    options.leaves_out_weak = true;
    Progress progress;
    EXPECT_TRUE(dataset.verify_surface(kept.surface, options, progress)->passed());
    EXPECT_FALSE(dataset.verify_surface(all.surface, options, progress)->passed());
  }
}

ExtractOptions within_distance(double persistence, double distance) {
  ExtractOptions options = full_resolution(0.1, persistence);
  options.simplify = Simplify::edges;
  options.simplify_distance = distance;
  return options;
}

/// Near the surface of the field that is left, from which it is simplified; within two steps of the
/// grid by way of cubes.
TEST(weak_regions, are_left_out_of_what_is_simplified_within_a_distance) {
  const auto dims = oracles::trials<Index3>({{24, 37, 21}}, {{18, 25, 17}});
  for (std::uint64_t seed = 1; seed <= oracles::trials(12U, 2U); ++seed)
    for (const double distance : {0.4, 4.5}) {
      SCOPED_TRACE(seed);
      const double persistence = 0.3;
      const Volume volume = smoothed_noise(dims, seed, static_cast<int>(seed % 2));
      const Volume turned = without_weak_regions(volume, volume, 0.1, persistence);
      ExtractOptions options = within_distance(persistence, distance);
      const Kept kept = kept_of(built_in_memory(volume), options);
      EXPECT_GT(kept.report.topology->weak_regions, 0U);
      ASSERT_TRUE(kept.report.simplified);
      EXPECT_EQ(kept.report.simplified->start_distance > 0, distance > 4);
      EXPECT_GT(kept.report.simplified->collapses, 100U);
      expect_verified(built_in_memory(volume), kept.surface, options);
      options.keep_topology.reset();
      expect_verified(built_in_memory(turned), kept.surface, options);
    }
}

TEST(weak_regions, are_left_out_of_simplified_cubes) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, 5, 1));
  ExtractOptions options = within_distance(0.3, 0.8);
  options.style = SurfaceStyle::cubes;
  options.style_distance = 0.2;
  const Kept kept = kept_of(dataset, options);
  EXPECT_GT(kept.report.topology->weak_regions, 0U);
  expect_verified(dataset, kept.surface, options);
  const Surface expected = kept_of(dataset, full_resolution(0.1, 0.3)).surface;
  EXPECT_EQ(pieces_of(kept.surface), pieces_of(expected));
}

/// What is farther than the error keeps its side, so of regions within a larger persistence only
/// those go that are within the error, too.
TEST(weak_regions, are_left_out_of_what_is_simplified_within_an_error) {
  const Dataset dataset = built_in_memory(smoothed_noise({{34, 30, 37}}, 5, 1));
  for (const double persistence : {0.1, 0.6}) {
    SCOPED_TRACE(persistence);
    const double error = 0.2;
    ExtractOptions options = full_resolution(0.1, std::min(persistence, error));
    options.max_error = error / 2;
    const Kept before = kept_of(dataset, options);
    options.leaves_out_weak = false;
    const Kept all = kept_of(dataset, options);
    options = full_resolution(0.1, persistence);
    options.max_error = error;
    options.simplify = Simplify::edges;
    const Kept kept = kept_of(dataset, options);
    EXPECT_EQ(pieces_of(kept.surface), pieces_of(before.surface));
    EXPECT_GT(pieces_of(all.surface).size(), pieces_of(before.surface).size());
    EXPECT_EQ(kept.report.topology->persistence, std::min(persistence, error));
    EXPECT_EQ(kept.report.topology->weak_regions, before.report.topology->weak_regions);
    expect_verified(dataset, kept.surface, options);
  }
}

/// A distance beside an error is to all there is, but of cubes to these.
TEST(weak_regions, stay_where_tetrahedra_are_simplified_within_both) {
  const auto dims = oracles::trials<Index3>({{34, 30, 37}}, {{24, 22, 25}});
  const Dataset dataset = built_in_memory(smoothed_noise(dims, 5, 2));
  ExtractOptions options = within_distance(0.6, 1.5);
  options.max_error = 0.1;
  for (const SurfaceStyle style : {SurfaceStyle::tetra, SurfaceStyle::cubes}) {
    options.style = style;
    const Kept kept = kept_of(dataset, options);
    EXPECT_EQ(kept.report.topology->leaves_out_weak, style == SurfaceStyle::cubes);
    expect_verified(dataset, kept.surface, options);
  }
}

TEST(weak_regions, of_another_persistence_are_not_those_that_verification_leaves_out) {
  const auto dims = oracles::trials<Index3>({{34, 30, 37}}, {{19, 22, 20}});
  const Dataset dataset = built_in_memory(smoothed_noise(dims, 5, 1));
  for (const double max_error : {0.0, 0.4}) {
    ExtractOptions options = within_distance(0.2, 1.5);
    options.max_error = max_error;
    if (max_error > 0) options.simplify_distance.reset();
    const Kept kept = kept_of(dataset, options);
    Progress progress;
    EXPECT_TRUE(dataset.verify_surface(kept.surface, options, progress)->passed());
    for (const std::optional<double> other : {std::optional<double>(0.05), {0.35}, {0.0}, {}}) {
      options.keep_topology = other;
      EXPECT_FALSE(dataset.verify_surface(kept.surface, options, progress)->passed());
    }
  }
}

/// On either side of holes that part the volume, in bricks that have no surface.
TEST(weak_regions, are_apart_where_holes_part_them) {
  for (const Index3& holes :
       {Index3{{64, 65, 0}}, Index3{{60, 63, 0}}, Index3{{40, 90, 0}}, Index3{{96, 128, 0}}}) {
    SCOPED_TRACE(holes[0]);
    RegularGrid grid;
    grid.dims = {{161, 33, 35}};
    const Volume volume = oracles::volume_of<float>(grid, [&](const Index3& p) {
      if (p[0] >= holes[0] && p[0] < holes[1]) return std::numeric_limits<double>::quiet_NaN();
      if (p == Index3{{5, 5, 5}} || p == Index3{{150, 9, 8}}) return -3.0;
      return p == Index3{{155, 20, 20}} ? 3.0 : 0.2;
    });
    const Volume turned = without_weak_regions(volume, volume, 0.0, 0.5);
    ExtractOptions options = full_resolution(0.0, 0.5);
    const Kept kept = kept_of(built_in_memory(volume), options);
    EXPECT_EQ(kept.report.topology->weak_regions, 1U);
    options.keep_topology.reset();
    const Kept expected = kept_of(built_in_memory(turned), options);
    EXPECT_TRUE(match_surfaces(expected.surface, kept.surface, 1e-4).is_same());
    EXPECT_FALSE(kept.surface.is_empty());
  }
}

TEST(persistent_regions, are_those_of_brute_force) {
  std::uint64_t n_found = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Volume volume = smoothed_noise({{24, 17, 30}}, seed, static_cast<int>(seed % 3));
    if (seed % 2 == 0)
      for (std::size_t i = 0; i < volume.as<float>().size(); i += 97)
        oracles::typed_samples<float>(volume)[i] = std::numeric_limits<float>::quiet_NaN();
    const double c = 0.1;
    const double persistence = seed < 4 ? 0.01 : 0.2;
    const auto samples = volume.as<float>();
    const std::vector<double> values(samples.begin(), samples.end());
    std::vector<bool> above;
    std::vector<bool> below;
    for (const double value : values) {
      above.push_back(value >= c + persistence);
      below.push_back(value < c - persistence);
    }
    Progress progress;
    const auto found = diamond::count_persistent_regions(diamond::VolumeSamples(volume), c,
                                                         persistence, {2}, progress);
    ASSERT_TRUE(found);
    const Index3& dims = volume.info.grid.dims;
    EXPECT_EQ(found->inside, Regions(dims, values, c - persistence, above).n_fixed());
    EXPECT_EQ(found->outside, Regions(dims, values, c + persistence, below).n_fixed());
    n_found += found->inside + found->outside;
  }
  EXPECT_GT(n_found, 50U);
}

/// A row of regions of sizes 3 1 2 5, of which the last is fixed, and one beside it of the same
/// size as another.
TEST(weak_regions, of_a_graph_are_turned_whatever_the_order) {
  struct Piece {
    int region;
    std::uint64_t n;
    std::uint64_t first;
    bool is_fixed;
  };
  // Regions 0 - 1 - 2 - 3 - 4, in pieces.
  const std::vector<Piece> pieces{{0, 3, 90, false}, {1, 1, 7, false}, {2, 1, 40, false},
                                  {2, 1, 30, false}, {3, 5, 0, true},  {3, 0, ~0ULL, false},
                                  {4, 2, 20, false}};
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(1);
  for (int trial = 0; trial < 50; ++trial) {
    std::shuffle(order.begin(), order.end(), random);
    diamond::RegionGraph graph;
    std::vector<diamond::RegionGraph::Id> id(pieces.size());
    for (const std::size_t i : order)
      id[i] = graph.add(pieces[i].is_fixed, pieces[i].n, pieces[i].first);
    graph.join(id[3], id[2]);
    graph.join(id[4], id[5]);
    graph.touch(id[0], id[1]);
    graph.touch(id[1], id[3]);
    graph.touch(id[5], id[2]);
    graph.touch(id[6], id[4]);
    const auto turned = graph.turn(Progress{});
    // Region 1, with 0 and 2 then of 6 samples; region 4, which is one with 3; then 0, 1, 2.
    EXPECT_EQ(turned.n_fewer, 4U);
    const std::vector<bool> expected{true, false, true, true, false, false, true};
    for (std::size_t i = 0; i < pieces.size(); ++i)
      EXPECT_EQ(turned.is_turned[id[i]], expected[i]) << i;
  }
}

}  // namespace
}  // namespace lode
