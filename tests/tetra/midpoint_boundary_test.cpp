// How far the boundary, and faces between regions, move as edges collapse to their midpoints.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "lode/models/tetra_mt/midpoint/edge_patch.h"
#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/refine/engine.h"
#include "lode/refine/focus.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/midpoint_fixtures.h"
#include "tests/tetra/region_checks.h"
#include "tests/tetra/sheet_checks.h"

namespace lode::tetra_mt::midpoint {
namespace {

using oracles::Random;
using test::farthest_from;
using test::sheets_of;
using test::Triangle;

/// The base of a build, with its vertices by label.
struct BentBase {
  Hierarchy hierarchy;
  TetraMesh vertices;
  test::Tetrahedra cells;
  std::vector<std::uint32_t> regions;
  double volume_change = 0;
};

BentBase bent(const TetraMesh& mesh, double tolerance) {
  Progress progress;
  const auto collapses =
      collapse_edges(mesh, {.boundary_tolerance = tolerance, .threads = {2}}, progress);
  EXPECT_TRUE(collapses) << (collapses ? "" : collapses.error().message);
  auto hierarchy = make_hierarchy(mesh, *collapses, {2});
  EXPECT_TRUE(hierarchy);
  BentBase base{std::move(*hierarchy), {}, {}, {}, collapses->volume_change};
  base.vertices.fields.resize(1);
  for (std::uint32_t label = 0; label < base.hierarchy.n_labels(); ++label) {
    const Code code = base.hierarchy.code_of(label);
    base.vertices.positions.push_back(base.hierarchy.position(label, code));
    base.vertices.fields[0].values.push_back(base.hierarchy.value(label, code));
  }
  const Forest forest(base.hierarchy);
  const MidpointCut cut(forest);
  for (const MidpointCut::Cell& cell : cut.slots()) {
    if (!cut.is_inside(cell)) continue;
    base.cells.push_back(cell.corners);
    base.regions.push_back(cell.region);
  }
  return base;
}

void expect_near_reference(const TetraMesh& mesh, const BentBase& base, double tolerance) {
  EXPECT_LE(base.hierarchy.boundary_deviation, tolerance * 1.000001);
  const auto before = sheets_of(mesh, mesh.tetrahedra, mesh.regions);
  const auto after = sheets_of(base.vertices, base.cells, base.regions);
  // Where it stays flat, codes round vertices: by half a step along each axis, 2^-30 of what is 2.
  const double bound = base.hierarchy.boundary_deviation + 0x1p-28;
  EXPECT_LE(farthest_from(before, after), bound);
  EXPECT_LE(farthest_from(after, before), bound);
  const double volume = test::volume_of(mesh, mesh.tetrahedra);
  EXPECT_NEAR(test::expect_conforming(base.vertices, base.cells) - volume, base.volume_change,
              1e-9 * volume);
}

TEST(midpoint_boundary, moves_by_no_more_than_asked_for_both_ways) {
  TetraMesh mesh = test::ball(oracles::trials(9, 7));
  std::ranges::fill(mesh.fields[0].values, 1);
  std::size_t last = mesh.tetrahedra.size();
  for (const double tolerance : {0.0, 0.03, 0.08, 0.2}) {
    const BentBase base = bent(mesh, tolerance);
    expect_near_reference(mesh, base, std::max(tolerance, 4e-6));
    EXPECT_LT(base.cells.size(), last * 19 / 20);
    last = base.cells.size();
    RecordProperty("cells", static_cast<int>(last));
    const Forest forest(base.hierarchy);
    MidpointCut cut(forest);
    Engine<MidpointCut> engine(cut);
    engine.set_query(uniform_demand(0));
    engine.finish();
    EXPECT_EQ(test::normalised(cut.cells()),
              test::normalised(test::labelled(mesh, base.hierarchy).tetrahedra));
  }
}

/// Vertices that come lie beside the reference's: not all that moves is half-edge collapses.
TEST(midpoint_boundary, has_new_vertices_off_the_references) {
  const TetraMesh mesh = test::ball(oracles::trials(9, 7));
  const BentBase base = bent(mesh, 0.1);
  std::vector<bool> is_used(base.vertices.positions.size(), false);
  for (const auto& t : base.cells)
    for (const std::uint32_t v : t) is_used[v] = true;
  int n_beside = 0;
  for (std::uint32_t v = base.hierarchy.n_vertices; v < is_used.size(); ++v) {
    const double size = length(base.vertices.positions[v]);
    n_beside += is_used[v] && size > 0.8 && size < 0.999 ? 1 : 0;
  }
  EXPECT_GT(n_beside, 5);
}

TEST(midpoint_boundary, and_faces_between_regions_move_together_and_regions_stay_what_they_are) {
  TetraMesh mesh = test::ball(oracles::trials(9, 7));
  mesh.region_ids = {0, 1, 2};
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    mesh.regions.push_back(length(centre) < 0.6 ? 0 : centre[0] < 0 ? 1 : 2);
  }
  std::size_t last = mesh.tetrahedra.size();
  for (const double tolerance : {0.0, 0.02, 0.1}) {
    const BentBase base = bent(mesh, tolerance);
    expect_near_reference(mesh, base, std::max(tolerance, 4e-6));
    constexpr double kAnything = 1e30;
    test::expect_same_regions(test::describe_regions(mesh, mesh.tetrahedra, mesh.regions),
                              test::describe_regions(base.vertices, base.cells, base.regions),
                              kAnything);
    EXPECT_LT(base.cells.size(), last);
    last = base.cells.size();
  }
}

/// Both sides of a cell without volume lie in one plane, which says nothing of its outline.
TEST(midpoint_boundary, stays_where_cells_without_volume_stick_out) {
  TetraMesh mesh = oracles::noise_mesh(5, oracles::Cut::in_six, 4);
  std::vector<std::array<std::uint32_t, 3>> on_edge;
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t k = 0; k < 4; ++k) {
      const auto face = others(t, k);
      const auto is_on_top = [&](std::uint32_t v) { return mesh.positions[v][2] == 1; };
      const auto n_front =
          std::ranges::count_if(face, [&](std::uint32_t v) { return mesh.positions[v][1] == 0; });
      if (std::ranges::all_of(face, is_on_top) && n_front == 2) on_edge.push_back(face);
    }
  ASSERT_EQ(on_edge.size(), 4U);
  for (const auto& [a, b, c] : on_edge) {
    const Vec3d centre = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1.0 / 3);
    mesh.tetrahedra.push_back({a, b, c, static_cast<std::uint32_t>(mesh.positions.size())});
    mesh.positions.push_back({{centre[0], -0.3, 1}});
    mesh.fields[0].values.push_back(mesh.fields[0].values[a]);
  }
  for (const double tolerance : {0.0, 0.01}) {
    const BentBase base = bent(mesh, tolerance);
    const auto before = sheets_of(mesh, mesh.tetrahedra, {});
    const auto after = sheets_of(base.vertices, base.cells, {});
    EXPECT_LE(farthest_from(before, after), tolerance + 1e-5);
    EXPECT_LE(farthest_from(after, before), tolerance + 1e-5);
  }
}

TEST(midpoint_boundary, refuses_tolerances_that_are_none) {
  Progress progress;
  const TetraMesh mesh = test::ball(3);
  for (const double tolerance : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto result = collapse_edges(mesh, {.boundary_tolerance = tolerance}, progress);
    ASSERT_FALSE(result);
    EXPECT_TRUE(result.error().message.starts_with("boundary tolerance: expected a distance"));
  }
}

/// Random discs round two ends of an edge, some of them bent over.
TEST(midpoint_boundary, deviations_of_patches_are_those_of_points_all_over_them_or_more) {
  Random random(5);
  int n_known = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const double bend = trial % 4 == 0 ? 1.5 : 0.3;
    const auto point = [&](double x, double y) {
      return Vec3d{{x + random.uniform(-0.2, 0.2), y + random.uniform(-0.2, 0.2),
                    random.uniform(-bend, bend)}};
    };
    EdgePatch patch{.first = point(0, 0), .second = point(1, 0), .middle = {}};
    patch.middle = (patch.first + patch.second) * 0.5;
    const Vec3d top = point(0.5, 1);
    const Vec3d bottom = point(0.5, -1);
    patch.first_ring = {top, point(-0.6, 0.7), point(-1, 0), point(-0.6, -0.7), bottom};
    patch.second_ring = {bottom, point(1.6, -0.7), point(2, 0), point(1.6, 0.7), top};
    // From above the first ring turns left, so that of the second end does, too.
    const double found = edge_patch_deviation(patch, std::numeric_limits<double>::infinity());
    if (!std::isfinite(found)) continue;
    ++n_known;
    std::vector<Triangle> before{{patch.first, patch.second, top},
                                 {patch.first, bottom, patch.second}};
    std::vector<Triangle> after;
    for (std::size_t i = 0; i + 1 < patch.first_ring.size(); ++i) {
      before.push_back({patch.first, patch.first_ring[i], patch.first_ring[i + 1]});
      before.push_back({patch.second, patch.second_ring[i], patch.second_ring[i + 1]});
      after.push_back({patch.middle, patch.first_ring[i], patch.first_ring[i + 1]});
      after.push_back({patch.middle, patch.second_ring[i], patch.second_ring[i + 1]});
    }
    EXPECT_LE(std::max(farthest_from(before, after), farthest_from(after, before)), found + 1e-12);
    EXPECT_LE(found, 4 * bend);
    EXPECT_FALSE(std::isfinite(edge_patch_deviation(patch, 0.99 * found)));
  }
  EXPECT_GT(n_known, 200);
  EXPECT_LT(n_known, 400);
}

}  // namespace
}  // namespace lode::tetra_mt::midpoint
