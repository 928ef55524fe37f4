// Collapses in meshes whose boundary has patches: each stays what it is and where it is, in the
// build, in every cut, and with either placement.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "lode/models/tetra_mt/closed_mesh.h"
#include "lode/models/tetra_mt/half_edge.h"
#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/interfaces.h"
#include "lode/models/tetra_mt/midpoint/edge_collapses.h"
#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"
#include "lode/models/tetra_mt/tetra_cut.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"
#include "tests/tetra/mesh_checks.h"
#include "tests/tetra/region_checks.h"

namespace lode::tetra_mt {
namespace {

using oracles::Cut;
using oracles::Random;
using test::PatchMarks;
using test::Regions;

/// Of areas: coordinates are float32, and what is straight but for their rounding goes.
constexpr double kRounding = 1e-6;

/// Of a face of the unit cube's boundary, by its centre: one more than a patch's place, or 0.
using PatchOf = std::function<std::uint32_t(const Vec3d& centre)>;

struct PatchCase {
  std::string name;
  PatchOf patch_of;
  std::size_t most_cells;  ///< At the end, of a field that is constant.
};

bool is_on_floor(const Vec3d& p) { return p[2] == 0; }

std::uint32_t side_of(const Vec3d& p) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    if (p[i] == 0) return 2 * i + 1;
    if (p[i] == 1) return 2 * i + 2;
  }
  return 0;
}

double from_middle(const Vec3d& p) {
  return std::sqrt((p[0] - 0.5) * (p[0] - 0.5) + (p[1] - 0.5) * (p[1] - 0.5));
}

bool is_in_square(const Vec3d& p, double half) {
  return std::max(std::abs(p[0] - 0.5), std::abs(p[1] - 0.5)) < half;
}

std::vector<PatchCase> patch_cases() {
  const auto flag = [](bool is) { return is ? 1U : 0U; };
  return {
      {"all of one", [](const Vec3d&) { return 1U; }, 12},
      {"six sides", side_of, 30},
      {"inlet", [=](const Vec3d& p) { return flag(is_on_floor(p) && from_middle(p) < 0.31); }, 250},
      {"square", [=](const Vec3d& p) { return flag(is_on_floor(p) && is_in_square(p, 0.3)); }, 80},
      {"ring",
       [=](const Vec3d& p) {
         return flag(is_on_floor(p) && is_in_square(p, 0.4) && !is_in_square(p, 0.2));
       },
       150},
      {"round a corner", [=](const Vec3d& p) { return flag(p[0] < 0.4 && p[1] < 0.6); }, 120},
      {"touching at a vertex",
       [=](const Vec3d& p) { return flag(is_on_floor(p) && (p[0] < 0.5) == (p[1] < 0.5)); }, 80},
      {"three that meet in a vertex",
       [=](const Vec3d& p) {
         return is_on_floor(p) ? (p[0] < 0.5 ? 1U : p[1] < 0.5 ? 2U : 3U) : 0U;
       },
       80},
      {"strips",
       [=](const Vec3d& p) { return is_on_floor(p) ? static_cast<std::uint32_t>(p[0] * 5) : 0U; },
       150},
      {"one cell",
       [=](const Vec3d& p) {
         return flag(is_on_floor(p) && p[0] > 0.3 && p[0] < 0.4 && p[1] > 0.5 && p[1] < 0.6);
       },
       100},
  };
}

/// The faces that one tetrahedron alone has.
std::vector<std::array<std::uint32_t, 3>> boundary_of(const TetraMesh& mesh) {
  std::vector<Tetrahedron> closed = mesh.tetrahedra;
  const auto n = static_cast<std::uint32_t>(mesh.positions.size());
  EXPECT_TRUE(close_boundary(n, closed, {1}));
  std::vector<std::array<std::uint32_t, 3>> faces;
  for (std::size_t i = mesh.tetrahedra.size(); i < closed.size(); ++i) {
    const auto at = std::ranges::find(closed[i], n) - closed[i].begin();
    faces.push_back(others(closed[i], static_cast<std::size_t>(at)));
  }
  return faces;
}

void add_patches(const PatchOf& patch_of, TetraMesh& mesh) {
  mesh.patches.clear();
  mesh.patch_faces.clear();
  std::uint32_t n = 0;
  for (const auto& face : boundary_of(mesh)) {
    const auto& p = mesh.positions;
    const Vec3d centre = (1.0 / 3) * (p[face[0]] + p[face[1]] + p[face[2]]);
    const std::uint32_t mark = patch_of(centre);
    if (mark > 0) mesh.patch_faces.push_back({face, mark - 1});
    n = std::max(n, mark);
  }
  for (std::uint32_t i = 0; i < n; ++i)
    mesh.patches.push_back({static_cast<std::int64_t>(10 * i), "patch " + std::to_string(i)});
}

TetraMesh patched_mesh(int n_cells, Cut cut, const PatchOf& patch_of) {
  TetraMesh mesh = oracles::noise_mesh(n_cells + 1, cut, 5);
  add_patches(patch_of, mesh);
  return mesh;
}

PatchMarks marks_of(const TetraMesh& mesh) {
  PatchMarks marks;
  for (const PatchFace& face : mesh.patch_faces) {
    std::vector<std::uint32_t> corners(face.corners.begin(), face.corners.end());
    std::ranges::sort(corners);
    marks[corners] = face.patch + 1;
  }
  return marks;
}

void add_mark(const TetraMesh& mesh, const Tetrahedron& outer, std::uint32_t mark,
              PatchMarks& marks) {
  std::vector<std::uint32_t> corners;
  for (const std::uint32_t v : outer)
    if (v != mesh.positions.size()) corners.push_back(v);
  std::ranges::sort(corners);
  marks[corners] = mark;
}

/// Of the reference, with a region each.
Regions regions_of(const TetraMesh& mesh) {
  std::vector<std::uint32_t> regions = mesh.regions;
  regions.resize(mesh.tetrahedra.size(), 0);
  return test::describe_regions(mesh, mesh.tetrahedra, regions, marks_of(mesh));
}

HalfEdgeCollapses collapsed_to(const TetraMesh& mesh, std::uint64_t base_cells = 0,
                               int threads = 2) {
  Progress progress;
  auto result = collapse_half_edges(
      mesh, {.base_cells = base_cells, .rules = {}, .threads = {threads}}, progress);
  EXPECT_TRUE(result) << (result ? "" : result.error().message);
  return result ? std::move(*result) : HalfEdgeCollapses{};
}

void expect_patches_kept(const TetraMesh& mesh, const HalfEdgeCollapses& result, double share) {
  test::expect_conforming(mesh, result.base);
  PatchMarks marks;
  for (const OuterTetrahedron& outer : result.outer_base)
    add_mark(mesh, outer.corners, outer.patch, marks);
  std::vector<std::uint32_t> regions = result.base_regions;
  regions.resize(result.base.size(), 0);
  test::expect_same_regions(regions_of(mesh),
                            test::describe_regions(mesh, result.base, regions, marks), share);
}

/// Vertices of the hierarchy as the mesh numbers them, and the one outside.
Tetrahedron renumbered(const Hierarchy& hierarchy, Tetrahedron t) {
  for (std::uint32_t& v : t) v = v == hierarchy.outside() ? v : hierarchy.mesh_vertices[v];
  return t;
}

std::uint32_t region_of(const TetraCut& cut, std::uint32_t slot) { return cut.region(slot); }
std::uint32_t region_of(const midpoint::MidpointCut& cut, std::uint32_t slot) {
  return cut.slots()[slot].region;
}

/// The mesh of a cut.
template <typename Cut, typename Renumber>
Regions regions_of_cut(const TetraMesh& mesh, const Cut& cut, const Renumber& renumber) {
  PatchMarks marks;
  test::Tetrahedra inside;
  std::vector<std::uint32_t> regions;
  for (std::uint32_t slot = 0; slot < cut.slots().size(); ++slot) {
    const auto& cell = cut.slots()[slot];
    if (cell.corners[0] == kNone) continue;
    const std::uint32_t region = region_of(cut, slot);
    const Tetrahedron t = renumber(cell.corners);
    if (cut.is_inside(cell)) {
      inside.push_back(t);
      regions.push_back(region);
    } else {
      add_mark(mesh, t, region, marks);
    }
  }
  return test::describe_regions(mesh, inside, regions, marks);
}

TEST(patches, stay_what_and_where_they_are) {
  for (const Cut cut :
       oracles::trials<std::vector<Cut>>({Cut::in_five, Cut::in_six}, {Cut::in_six}))
    for (const PatchCase& patch_case : patch_cases()) {
      SCOPED_TRACE(patch_case.name);
      TetraMesh mesh = patched_mesh(10, cut, patch_case.patch_of);
      expect_patches_kept(mesh, collapsed_to(mesh, mesh.tetrahedra.size() / 4), kRounding);
      std::ranges::fill(mesh.fields[0].values, 1);
      const HalfEdgeCollapses result = collapsed_to(mesh);
      expect_patches_kept(mesh, result, kRounding);
      EXPECT_LT(result.base.size(), patch_case.most_cells);
    }
}

TEST(patches, stay_with_regions_beside_them) {
  for (const PatchCase& patch_case : patch_cases()) {
    SCOPED_TRACE(patch_case.name);
    TetraMesh mesh = patched_mesh(8, Cut::in_six, patch_case.patch_of);
    for (const auto& t : mesh.tetrahedra) {
      double x = 0;
      for (const std::uint32_t v : t) x += mesh.positions[v][0] / 4;
      mesh.regions.push_back(x < 0.5 ? 0 : 1);
    }
    mesh.region_ids = {3, 4};
    expect_patches_kept(mesh, collapsed_to(mesh), kRounding);
  }
}

TEST(patches, of_any_shape_stay) {
  Random random(1);
  for (const double share : {0.02, 0.1, 0.5}) {
    const TetraMesh mesh = patched_mesh(6, Cut::in_five, [&](const Vec3d&) {
      return random.uniform() < share ? 1 + static_cast<std::uint32_t>(random.below(3)) : 0U;
    });
    expect_patches_kept(mesh, collapsed_to(mesh), kRounding);
  }
}

TEST(patches, are_there_in_every_cut) {
  for (const PatchCase& patch_case : patch_cases()) {
    SCOPED_TRACE(patch_case.name);
    const TetraMesh mesh = patched_mesh(7, Cut::in_six, patch_case.patch_of);
    const Regions expected = regions_of(mesh);
    const auto hierarchy = make_hierarchy(mesh, collapsed_to(mesh), {2});
    ASSERT_TRUE(hierarchy) << hierarchy.error().message;
    const PackedHierarchy packed = PackedHierarchy::pack(*hierarchy, mesh.tetrahedra.size(), {2});
    EXPECT_EQ(packed.head().patches, mesh.patches);
    TetraCut cut(packed);
    const auto expect_kept = [&] {
      const Regions found = regions_of_cut(
          mesh, cut, [&](const Tetrahedron& t) { return renumbered(*hierarchy, t); });
      test::expect_same_regions(expected, found, kRounding);
    };
    const std::uint32_t n = hierarchy->n_nodes();
    for (std::uint32_t i = 0; i < n; ++i) {
      cut.apply(NodeId{hierarchy->order[i]});
      if (i % (n / 4) == 0 || i + 1 == n) expect_kept();
    }
    for (std::uint32_t i = n; i > 0; --i) cut.undo(NodeId{hierarchy->order[i - 1]});
    expect_kept();
  }
}

/// With vertices wherever codes say: they have other numbers and places than the mesh's.
TEST(patches, are_there_in_cuts_of_midpoints) {
  for (const PatchCase& patch_case : patch_cases()) {
    SCOPED_TRACE(patch_case.name);
    const TetraMesh mesh = patched_mesh(8, Cut::in_six, patch_case.patch_of);
    Progress progress;
    const auto collapses =
        midpoint::collapse_edges(mesh, {.base_cells = 0, .threads = {2}}, progress);
    ASSERT_TRUE(collapses) << collapses.error().message;
    const auto hierarchy = midpoint::make_hierarchy(mesh, *collapses, {2});
    ASSERT_TRUE(hierarchy) << hierarchy.error().message;
    EXPECT_EQ(hierarchy->patches, mesh.patches);
    const midpoint::Forest forest(*hierarchy);
    midpoint::MidpointCut cut(forest);
    const auto expect_kept = [&] {
      TetraMesh there;
      there.positions.resize(hierarchy->n_labels());
      for (const auto& cell : cut.slots())
        for (const std::uint32_t v : cell.corners)
          if (cell.corners[0] != kNone && v != hierarchy->outside())
            there.positions[v] = cut.position(v);
      const Regions found = regions_of_cut(there, cut, [](const Tetrahedron& t) { return t; });
      test::expect_same_regions(regions_of(mesh), found, 1e-4);
    };
    expect_kept();
    const std::uint32_t n = hierarchy->n_nodes();
    for (std::uint32_t node = n; node > 0; --node) {
      cut.apply(NodeId{node - 1});
      if (node == n / 2 || node == 1) expect_kept();
    }
  }
}

/// Vertices where faces of several marks meet.
std::size_t n_on_outlines(const HalfEdgeCollapses& result, std::uint32_t outside) {
  std::map<std::uint32_t, std::set<std::uint32_t>> beside;
  for (const OuterTetrahedron& outer : result.outer_base)
    for (const std::uint32_t v : outer.corners)
      if (v != outside) beside[v].insert(outer.patch);
  return static_cast<std::size_t>(
      std::ranges::count_if(beside, [](const auto& of) { return of.second.size() > 1; }));
}

TEST(patches, have_outlines_that_move_by_what_is_allowed) {
  TetraMesh mesh = patched_mesh(20, Cut::in_six, [](const Vec3d& p) {
    return is_on_floor(p) && from_middle(p) < 0.3 ? 1U : 0U;
  });
  const auto outside = static_cast<std::uint32_t>(mesh.positions.size());
  std::ranges::fill(mesh.fields[0].values, 1);
  const HalfEdgeCollapses exact = collapsed_to(mesh);
  EXPECT_LE(exact.boundary_deviation, kRounding);
  Progress progress;
  constexpr double kTolerance = 0.06;
  const auto moved = collapse_half_edges(
      mesh, {.base_cells = 0, .rules = {.boundary_tolerance = kTolerance}, .threads = {2}},
      progress);
  ASSERT_TRUE(moved);
  EXPECT_LE(moved->boundary_deviation, kTolerance);
  EXPECT_GT(moved->boundary_deviation, kRounding);
  EXPECT_LT(n_on_outlines(*moved, outside), n_on_outlines(exact, outside));
  // What it was, topologically, and of about that area.
  expect_patches_kept(mesh, *moved, 0.5);
}

TEST(patches, are_the_same_for_any_number_of_threads) {
  const TetraMesh mesh = patched_mesh(20, Cut::in_five, side_of);
  const HalfEdgeCollapses one = collapsed_to(mesh, 10'000, 1);
  const HalfEdgeCollapses three = collapsed_to(mesh, 10'000, 3);
  EXPECT_EQ(one.base, three.base);
  EXPECT_LT(one.base.size(), 10'100U);
}

TEST(patches, of_faces_are_those_that_the_mesh_has) {
  TetraMesh mesh = patched_mesh(2, Cut::in_five, side_of);
  mesh.patch_faces[3].patch = 6;
  Progress progress;
  const auto result = collapse_half_edges(mesh, {}, progress);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().message, "face 3: expected a patch below 6, got 6");
}

}  // namespace
}  // namespace lode::tetra_mt
