// How far the boundary, and faces between regions, move as edges collapse.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/patch_deviation.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/region_checks.h"
#include "tests/tetra/sheet_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::Random;

using test::ball;
using test::farthest_from;
using test::sheets_of;
using test::Triangle;

HalfEdgeCollapses moved(const TetraMesh& mesh, double boundary_tolerance,
                        std::uint64_t base_cells = 0) {
  Progress progress;
  auto result = collapse_half_edges(mesh,
                                    {.base_cells = base_cells,
                                     .rules = {.boundary_tolerance = boundary_tolerance},
                                     .threads = {2}},
                                    progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : HalfEdgeCollapses{};
}

void expect_within(const TetraMesh& mesh, const HalfEdgeCollapses& result, double tolerance) {
  EXPECT_LE(result.boundary_deviation, tolerance * 1.000001);
  const auto before = sheets_of(mesh, mesh.tetrahedra, mesh.regions);
  const auto after = sheets_of(mesh, result.base, result.base_regions);
  const double bound = result.boundary_deviation + 1e-12;
  EXPECT_LE(farthest_from(before, after), bound);
  EXPECT_LE(farthest_from(after, before), bound);
  const double volume = test::volume_of(mesh, mesh.tetrahedra);
  EXPECT_NEAR(test::expect_conforming(mesh, result.base) - volume, result.volume_change,
              1e-12 * volume);
}

void set_narrow(TetraMesh& mesh) {
  for (Vec3d& p : mesh.positions)
    for (double& c : p.v) c = static_cast<double>(static_cast<float>(c));
  mesh.has_narrow_positions = true;
}

void turn_round(TetraMesh& mesh, double offset) {
  for (Vec3d& p : mesh.positions) {
    const Vec3d a{{std::cos(0.7) * p[0] - std::sin(0.7) * p[1],
                   std::sin(0.7) * p[0] + std::cos(0.7) * p[1], p[2]}};
    p = {{a[0] + offset, std::cos(0.4) * a[1] - std::sin(0.4) * a[2] + offset,
          std::sin(0.4) * a[1] + std::cos(0.4) * a[2] + offset}};
  }
  set_narrow(mesh);
}

TEST(boundary, of_narrow_positions_in_planes_goes_whichever_way_they_lie) {
  const TetraMesh straight = oracles::noise_mesh(21, Cut::in_five, 5);
  const std::size_t n = straight.tetrahedra.size() / 10;
  const auto n_faces = [&](const TetraMesh& mesh, double size) {
    const HalfEdgeCollapses result = moved(mesh, 0, n);
    EXPECT_LT(result.base.size(), n + n / 50);
    // Each coordinate is off by half a unit in the last place, at most.
    EXPECT_LE(result.boundary_deviation, 64 * 0x1p-24 * std::sqrt(3.0) * size);
    const double volume = test::volume_of(mesh, mesh.tetrahedra);
    EXPECT_NEAR(test::expect_conforming(mesh, result.base), volume, 1e-6 * size * volume);
    return static_cast<double>(sheets_of(mesh, result.base, {}).size());
  };
  const double n_straight = n_faces(straight, 1);
  for (const double offset : {0.0, 10.0}) {
    TetraMesh turned = straight;
    turn_round(turned, offset);
    EXPECT_NEAR(n_faces(turned, 2 + offset), n_straight, 0.06 * n_straight);
  }
}

TEST(boundary, moves_by_no_more_than_asked_for_both_ways) {
  TetraMesh mesh = ball(oracles::trials(9, 7));
  std::ranges::fill(mesh.fields[0].values, 1);
  std::size_t last = mesh.tetrahedra.size();
  for (const double tolerance : {0.0, 0.03, 0.08, 0.2}) {
    const HalfEdgeCollapses result = moved(mesh, tolerance);
    expect_within(mesh, result, std::max(tolerance, 4e-6));
    EXPECT_LT(result.base.size(), last * 9 / 10);
    last = result.base.size();
  }
  EXPECT_LT(last, 80U);
}

TEST(boundary, and_faces_between_regions_move_together_and_regions_stay_what_they_are) {
  TetraMesh mesh = ball(9);
  mesh.region_ids = {0, 1, 2};
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(length(centre) < 0.6 ? 0 : centre[0] < 0 ? 1 : 2);
  }
  std::size_t last = mesh.tetrahedra.size();
  for (const double tolerance :
       oracles::trials<std::vector<double>>({0.0, 0.02, 0.1}, {0.0, 0.1})) {
    const HalfEdgeCollapses result = moved(mesh, tolerance);
    expect_within(mesh, result, std::max(tolerance, 4e-6));
    constexpr double kAnything = 1e30;
    test::expect_same_regions(test::describe_regions(mesh, mesh.tetrahedra, mesh.regions),
                              test::describe_regions(mesh, result.base, result.base_regions),
                              kAnything);
    EXPECT_LT(result.base.size(), last * 9 / 10);
    last = result.base.size();
  }
}

/// A sheet of cells bent into waves that are higher than it is thick.
TetraMesh waves(int n) {
  TetraMesh mesh = oracles::noise_mesh(n, Cut::in_six, 2);
  std::erase_if(mesh.tetrahedra, [&](const auto& t) {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return mesh.positions[v][2] > 1.5 / n; });
  });
  for (Vec3d& p : mesh.positions)
    p[2] = 0.1 * p[2] + 0.05 * std::sin(9 * p[0]) * std::cos(7 * p[1]);
  return mesh;
}

TEST(boundary, leaves_errors_of_samples_outside_within_the_range) {
  const TetraMesh mesh = waves(9);
  for (const double tolerance : {0.1, 0.3}) {
    const HalfEdgeCollapses result = moved(mesh, tolerance);
    EXPECT_LT(result.base.size(), mesh.tetrahedra.size() / 4);
    for (const float error : result.errors) EXPECT_LE(std::abs(error), 1);
  }
}

TEST(boundary, refuses_tolerances_that_are_none) {
  Progress progress;
  const TetraMesh mesh = oracles::noise_mesh(3, Cut::in_five, 1);
  for (const double tolerance : {-1.0, std::nan("")})
    EXPECT_FALSE(collapse_half_edges(mesh, {.rules = {.boundary_tolerance = tolerance}}, progress));
}

/// Heights over a polygon that is no more than star-shaped round the origin.
Patch random_patch(Random& random, bool is_closed) {
  Patch patch{.ring = {}, .n = 3 + static_cast<int>(random.below(6)), .is_closed = is_closed};
  const double whole = is_closed ? 6.283185307179586 : random.uniform(2, 4.5);
  for (int i = 0; i < patch.n; ++i) {
    const double angle = whole * (i + random.uniform(0, 0.6)) / patch.n;
    const double radius = random.uniform(0.5, 1.5);
    patch.ring[static_cast<std::size_t>(i)] = {
        {radius * std::cos(angle), radius * std::sin(angle), random.uniform(-0.2, 0.2)}};
  }
  return patch;
}

/// Corners of a lattice's cells: triangles are in its planes and diagonal ones, and often seen
/// edge-on along the mean normal.
Patch lattice_patch(Random& random, bool is_closed) {
  Patch patch{.ring = {}, .n = 3 + static_cast<int>(random.below(5)), .is_closed = is_closed};
  const Vec3d spacing{{std::ldexp(1.0, static_cast<int>(random.below(3))), 1, 0.25}};
  for (int i = 0; i < patch.n; ++i) {
    Vec3d& at = patch.ring[static_cast<std::size_t>(i)];
    do {
      for (std::size_t k = 0; k < 3; ++k)
        at[k] = spacing[k] * (static_cast<double>(random.below(3)) - 1);
    } while (length(at) == 0);
  }
  return patch;
}

/// The farthest of points all over the triangles before and after from the others.
double farthest_point(const Patch& patch) {
  std::vector<Triangle> before;
  std::vector<Triangle> after;
  const auto& ring = patch.ring;
  const auto n = static_cast<std::size_t>(patch.n);
  for (std::size_t i = 0; i + 1 < n; ++i) before.push_back({Vec3d(), ring[i], ring[i + 1]});
  if (patch.is_closed) before.push_back({Vec3d(), ring[n - 1], ring[0]});
  for (std::size_t i = 1; i + 1 < n; ++i) after.push_back({ring[0], ring[i], ring[i + 1]});
  return std::max(farthest_from(before, after), farthest_from(after, before));
}

constexpr double kFar = std::numeric_limits<double>::infinity();

double deviation_of(const Patch& patch, double limit) {
  return patch.is_closed ? sheet_deviation(patch, limit) : patch_deviation(patch, limit);
}

TEST(boundary, deviations_of_patches_are_those_of_points_all_over_them_or_more) {
  Random random(4);
  int n_known = 0;
  double looseness = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const Patch patch = random_patch(random, trial % 2 == 0);
    const double bound = deviation_of(patch, kFar);
    if (!(bound < kFar)) continue;
    const double found = farthest_point(patch);
    EXPECT_GE(bound, found * (1 - 1e-12));
    EXPECT_EQ(sheet_deviation(patch, bound / 2), kFar);
    looseness += bound / found;
    ++n_known;
  }
  EXPECT_GT(n_known, 500);
  EXPECT_LT(looseness / n_known, 2);
}

TEST(boundary, deviations_of_patches_in_planes_of_a_lattice_are_so_too) {
  Random random(9);
  int n_known = 0;
  for (int trial = 0; trial < 400000; ++trial) {
    const Patch patch = lattice_patch(random, trial % 2 == 0);
    const double bound = deviation_of(patch, kFar);
    if (!(bound < kFar)) continue;
    EXPECT_GE(bound, farthest_point(patch) - 1e-12);
    ++n_known;
  }
  EXPECT_GT(n_known, 500);
}

/// Found in a ball of voxels of 1:1:2. A new triangle stands on end along the mean normal: rounding
/// alone says that it turns left.
TEST(boundary, of_a_triangle_seen_edge_on_is_not_taken_for_flat) {
  const std::vector<Vec3d> ring{{{0, 0, -1}}, {{0.5, 0, -1}}, {{0.5, 0, 1}},
                                {{0, 0, 1}},  {{-0.5, 0, 0}}, {{0, 1, 0}}};
  for (std::size_t first = 0; first < ring.size(); ++first) {
    Patch patch{.ring = {}, .n = static_cast<int>(ring.size()), .is_closed = true};
    for (std::size_t i = 0; i < ring.size(); ++i) patch.ring[i] = ring[(first + i) % ring.size()];
    EXPECT_GE(sheet_deviation(patch, kFar), farthest_point(patch) - 1e-12) << first;
  }
}

}  // namespace
}  // namespace lode::tetra_mt
