// Edges collapse into one of their ends: what is left is held against the reference by brute force.

#include "lode/models/tetra_mt/half_edge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "lode/models/tetra_mt/hierarchy.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/tetra/collapse_checks.h"
#include "tests/tetra/mesh_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::noise_mesh;
using oracles::Random;
using test::expect_errors_true;
using test::expect_simpler;
using test::pairs;
using test::vertices_of;

HalfEdgeCollapses collapsed(const TetraMesh& mesh, std::uint64_t base_cells, int threads = 2) {
  return test::collapsed(mesh, base_cells, {}, {threads});
}

TEST(half_edge, leaves_a_conforming_mesh_with_errors_that_are_true) {
  for (const Cut cut : {Cut::in_five, Cut::in_six}) {
    const TetraMesh mesh = noise_mesh(13, cut, 3);
    for (const double share : {0.5, 0.15, 0.0}) {
      const auto n = static_cast<double>(mesh.tetrahedra.size());
      const HalfEdgeCollapses result = collapsed(mesh, static_cast<std::uint64_t>(share * n));
      EXPECT_LT(static_cast<double>(result.base.size()), std::max(1.01 * share, 0.1) * n);
      expect_simpler(mesh, result);
      expect_errors_true(mesh, result);
    }
  }
}

TEST(half_edge, goes_in_blocks_and_is_the_same_for_any_number_of_threads) {
  const TetraMesh mesh = noise_mesh(30, Cut::in_five, 5);  // five blocks
  const HalfEdgeCollapses one = collapsed(mesh, 10'000, 1);
  const HalfEdgeCollapses three = collapsed(mesh, 10'000, 3);
  EXPECT_EQ(one.base, three.base);
  EXPECT_EQ(pairs(one), pairs(three));
  EXPECT_EQ(one.errors, three.errors);
  const auto first = make_hierarchy(mesh, one, {1});
  const auto second = make_hierarchy(mesh, three, {3});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->base, second->base);
  EXPECT_EQ(first->base_makers, second->base_makers);
  EXPECT_EQ(first->targets, second->targets);
  EXPECT_EQ(first->children, second->children);
  EXPECT_EQ(first->makers, second->makers);
  EXPECT_EQ(first->facts, second->facts);
  EXPECT_EQ(first->boxes, second->boxes);
  EXPECT_LT(one.base.size(), 10'100U);
  EXPECT_GT(one.base.size(), 9'000U);
  expect_simpler(mesh, one);
}

TEST(half_edge, keeps_the_extrema_of_several_fields) {
  TetraMesh mesh = noise_mesh(12, Cut::in_six, 7);
  for (const std::uint64_t seed : {8U, 9U})
    mesh.fields.push_back(noise_mesh(12, Cut::in_six, seed).fields[0]);
  const HalfEdgeCollapses result = collapsed(mesh, 1000);
  expect_simpler(mesh, result);
  expect_errors_true(mesh, result);
}

TEST(half_edge, takes_fields_without_range_and_meshes_without_fields) {
  TetraMesh mesh = noise_mesh(9, Cut::in_five, 1);
  std::ranges::fill(mesh.fields[0].values, 3.5);
  HalfEdgeCollapses result = collapsed(mesh, 0);
  EXPECT_LT(result.base.size(), 20U);  // a box
  expect_simpler(mesh, result);
  mesh.fields.clear();
  result = collapsed(mesh, 0);
  EXPECT_LT(result.base.size(), 20U);
  expect_simpler(mesh, result);
}

/// The cells of a grid that `keeps` says yes to.
template <typename Keeps>
TetraMesh part_of_grid(int n, const Keeps& keeps) {
  TetraMesh mesh = noise_mesh(n, Cut::in_six, 11);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    return !keeps(centre * (n - 1));
  });
  return mesh;
}

TEST(half_edge, keeps_cavities_handles_and_corners) {
  const TetraMesh cavity = part_of_grid(10, [](const Vec3d& p) {
    return p[0] < 3 || p[0] > 6 || p[1] < 3 || p[1] > 6 || p[2] < 3 || p[2] > 6;
  });
  expect_simpler(cavity, collapsed(cavity, 0));
  const TetraMesh handle =
      part_of_grid(10, [](const Vec3d& p) { return p[0] < 3 || p[0] > 6 || p[1] < 4 || p[1] > 5; });
  const HalfEdgeCollapses result = collapsed(handle, 0);
  EXPECT_LT(result.base.size(), handle.tetrahedra.size() / 4);
  expect_simpler(handle, result);
}

TEST(half_edge, leaves_vertices_and_edges_that_are_no_manifold) {
  // Two cubes of cells with an edge in common, two with a corner.
  const TetraMesh edge = part_of_grid(9, [](const Vec3d& p) { return (p[0] < 4) == (p[1] < 4); });
  const HalfEdgeCollapses at_edge = collapsed(edge, 0);
  expect_simpler(edge, at_edge);
  const std::set<std::uint32_t> left = vertices_of(at_edge.base);
  for (std::uint32_t z = 0; z < 9; ++z) EXPECT_TRUE(left.contains((z * 9 + 4) * 9 + 4));
  const TetraMesh corner = part_of_grid(9, [](const Vec3d& p) {
    return (p[0] < 4 && p[1] < 4 && p[2] < 4) || (p[0] > 4 && p[1] > 4 && p[2] > 4);
  });
  const HalfEdgeCollapses at_corner = collapsed(corner, 0);
  expect_simpler(corner, at_corner);
  EXPECT_TRUE(vertices_of(at_corner.base).contains((4 * 9 + 4) * 9 + 4));
}

TEST(half_edge, takes_the_smallest_meshes) {
  TetraMesh mesh = noise_mesh(2, Cut::in_six, 1);
  expect_simpler(mesh, collapsed(mesh, 0));
  mesh.tetrahedra.resize(2);
  HalfEdgeCollapses result = collapsed(mesh, 0);
  EXPECT_EQ(result.base.size(), 2U);
  mesh.tetrahedra.resize(1);
  result = collapsed(mesh, 0);
  EXPECT_EQ(result.base, mesh.tetrahedra);
  mesh.tetrahedra.clear();
  EXPECT_TRUE(collapsed(mesh, 0).base.empty());
  EXPECT_TRUE(collapsed(TetraMesh(), 0).base.empty());
}

TEST(half_edge, takes_a_single_layer_far_longer_than_thick) {
  TetraMesh mesh = part_of_grid(24, [](const Vec3d& p) { return p[2] < 1; });
  for (Vec3d& p : mesh.positions) p[2] *= 1e-4;
  const HalfEdgeCollapses result = collapsed(mesh, 0);
  EXPECT_LT(result.base.size(), mesh.tetrahedra.size() / 2);
  const double volume = test::volume_of(mesh, mesh.tetrahedra);
  EXPECT_NEAR(test::expect_conforming(mesh, result.base), volume, 1e-5 * volume);
}

TEST(half_edge, leaves_tetrahedra_wound_the_other_way_and_pairs_of_them) {
  TetraMesh mesh = noise_mesh(7, Cut::in_six, 4);
  for (const std::size_t t : {40U, 200U, 777U})
    std::swap(mesh.tetrahedra[t][0], mesh.tetrahedra[t][1]);
  const HalfEdgeCollapses wound = collapsed(mesh, 0);
  EXPECT_TRUE(make_hierarchy(mesh, wound, {2}));
  TetraMesh pair = noise_mesh(2, Cut::in_six, 1);
  pair.tetrahedra.resize(1);
  pair.tetrahedra.push_back(pair.tetrahedra[0]);
  std::swap(pair.tetrahedra[1][0], pair.tetrahedra[1][1]);
  const HalfEdgeCollapses both = collapsed(pair, 0);
  EXPECT_EQ(both.base.size(), 2U);
  EXPECT_TRUE(make_hierarchy(pair, both, {2}));
}

TEST(half_edge, takes_components_one_by_one) {
  const TetraMesh mesh = part_of_grid(
      12, [](const Vec3d& p) { return static_cast<int>(p[0]) % 2 == 0 && (p[1] < 5 || p[1] > 6); });
  expect_simpler(mesh, collapsed(mesh, 0));
}

std::uint64_t n_refused(const HalfEdgeCollapses& result, const std::set<Refusal>& by) {
  std::uint64_t n = 0;
  for (const Refusal refusal : by) n += result.refusals[refusal];
  return n;
}

TEST(half_edge, says_why_vertices_stay) {
  const std::set<Refusal> all{Refusal::non_manifold, Refusal::extremum, Refusal::boundary,
                              Refusal::regions,      Refusal::shape,    Refusal::topology,
                              Refusal::crowded,      Refusal::rounding, Refusal::limit};
  const auto counted = [&](const TetraMesh& mesh, std::uint64_t base_cells) {
    HalfEdgeCollapses result = collapsed(mesh, base_cells);
    EXPECT_EQ(n_refused(result, all), vertices_of(result.base).size());
    return result;
  };
  // A box: corners of the boundary, and nothing else.
  TetraMesh box = noise_mesh(7, Cut::in_five, 1);
  std::ranges::fill(box.fields[0].values, 1);
  EXPECT_EQ(counted(box, 0).refusals[Refusal::boundary], 8U);
  // Vertices that no collapse has come to yet.
  const HalfEdgeCollapses early = counted(noise_mesh(13, Cut::in_five, 3), 8000);
  EXPECT_GT(n_refused(early, {Refusal::limit}), vertices_of(early.base).size() / 2);
  // One value above all others, inside.
  TetraMesh peak = noise_mesh(7, Cut::in_six, 1);
  std::ranges::fill(peak.fields[0].values, 0);
  peak.fields[0].values[(3 * 7 + 3) * 7 + 3] = 1;
  EXPECT_EQ(counted(peak, 0).refusals[Refusal::extremum], 1U);
  // Two blocks with an edge in common: its vertices, but for its ends in corners.
  const TetraMesh edge = part_of_grid(9, [](const Vec3d& p) { return (p[0] < 4) == (p[1] < 4); });
  EXPECT_EQ(counted(edge, 0).refusals[Refusal::non_manifold], 9U);
  // Two regions that touch at a vertex.
  for (const auto& t : box.tetrahedra) {
    bool is_first = true;
    bool is_last = true;
    for (const std::uint32_t v : t)
      for (const double c : box.positions[v].v) {
        is_first = is_first && c < 0.51;
        is_last = is_last && c > 0.49;
      }
    box.regions.push_back(is_first || is_last ? 1 : 0);
  }
  box.region_ids = {3, 4};
  EXPECT_GE(counted(box, 0).refusals[Refusal::regions], 1U);
}

TEST(half_edge, refuses_what_is_no_mesh) {
  Progress progress;
  const auto message = [&](const TetraMesh& mesh) {
    const auto result = collapse_half_edges(mesh, {}, progress);
    return result ? std::string("taken") : result.error().message;
  };
  TetraMesh mesh = noise_mesh(3, Cut::in_five, 1);
  TetraMesh bad = mesh;
  bad.tetrahedra[2][1] = 27;
  EXPECT_EQ(message(bad), "tetrahedron 2: expected corners below 27, got 27");
  bad = mesh;
  bad.fields[0].values[5] = std::nan("");
  EXPECT_EQ(message(bad), "field noise: expected finite values, got nan at vertex 5");
  TetraMesh far = mesh;
  for (Vec3d& p : far.positions) p = p * 1e300;
  EXPECT_TRUE(message(far).starts_with("vertex ")) << message(far);
  EXPECT_NE(message(far).find("expected a position up to 2e+100"), std::string::npos);
  TetraMesh small = mesh;
  for (Vec3d& p : small.positions) p = p * 1e-300;
  EXPECT_EQ(message(small), "expected a mesh that is 1e-101 across or more, got one of 1e-300");
  bad = mesh;
  bad.fields[0].values[5] = 1.7e308;
  bad.fields[0].values[6] = -1.7e308;
  EXPECT_EQ(message(bad),
            "field noise: expected a range that doubles hold, got -1.7e+308 to 1.7e+308");
  bad = mesh;
  bad.fields[0].values.pop_back();
  EXPECT_EQ(message(bad), "field noise: expected 27 values, got 26");
  bad = mesh;
  bad.tetrahedra.push_back(bad.tetrahedra[0]);
  bad.tetrahedra.push_back(bad.tetrahedra[0]);
  EXPECT_NE(message(bad).find("expected faces of one or two tetrahedra"), std::string::npos);
}

TEST(half_edge, stops_when_cancelled) {
  Progress progress;
  progress.cancel();
  const auto result =
      collapse_half_edges(noise_mesh(8, Cut::in_five, 1), {.base_cells = 10}, progress);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, cancelled_error().message);
}

}  // namespace
}  // namespace lode::tetra_mt
