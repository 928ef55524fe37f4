#include "lode/io/tetrahedra.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/io/tetra_checks.h"
#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::io {
namespace {

using test::add_cell;
using test::expect_no_tetrahedra;
using test::tetrahedra_of;

/// The unit tetrahedron and a point below it.
CellMesh corner_mesh() {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, 0, -3}}};
  add_cell(mesh, CellType::tetrahedron, {0, 1, 2, 3});
  return mesh;
}

/// Two tetrahedra of volumes 1/6 and 1/2 that share a face.
CellMesh pair_mesh() {
  CellMesh mesh = corner_mesh();
  add_cell(mesh, CellType::tetrahedron, {0, 2, 1, 4});
  return mesh;
}

TEST(tetrahedra, leave_out_what_has_no_volume_and_unused_points) {
  CellMesh mesh = corner_mesh();
  mesh.points.insert(mesh.points.begin(), Vec3d{{9, 9, 9}});
  for (std::uint32_t& corner : mesh.corners) ++corner;
  add_cell(mesh, CellType::triangle, {0, 1, 2});
  add_cell(mesh, CellType::line, {0, 5});
  add_cell(mesh, CellType::vertex, {5});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_cells, 1U);
  EXPECT_EQ(outcome.report.n_lower_cells, 3U);
  EXPECT_EQ(outcome.report.n_unused_points, 2U);
  EXPECT_EQ(outcome.report.n_boundary_faces, 4U);
  EXPECT_EQ(outcome.mesh.tetrahedra, (std::vector<std::array<std::uint32_t, 4>>{{0, 1, 2, 3}}));
  EXPECT_EQ(outcome.mesh.positions[3], (Vec3d{{0, 0, 1}}));
  EXPECT_TRUE(outcome.mesh.has_narrow_positions);
}

TEST(tetrahedra, refuse_other_cells_by_type_and_number) {
  CellMesh mesh = corner_mesh();
  mesh.points.resize(20);
  const std::vector<std::uint32_t> twenty = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,
                                             10, 11, 12, 13, 14, 15, 16, 17, 18, 19};
  for (int i = 0; i < 2; ++i) add_cell(mesh, CellType::lagrange_tetrahedron, twenty);
  add_cell(mesh, static_cast<CellType>(15), {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  expect_no_tetrahedra(
      mesh, {"1 of type 15 (pentagonal prism), 2 of type 71 (Lagrange tetrahedron): 2 of "
             "them have a linear cell's corners, which --linearise corners takes"});
  expect_no_tetrahedra(mesh, {"got 1 of type 15 (pentagonal prism)"},
                       {.quadratic = QuadraticCells::corners});
  CellMesh flat = test::empty_cells();
  flat.points.resize(3);
  add_cell(flat, CellType::triangle, {0, 1, 2});
  expect_no_tetrahedra(flat, {"got none among 1"});
}

TEST(tetrahedra, refuse_more_than_two_at_a_face_and_count_them) {
  CellMesh mesh = pair_mesh();
  mesh.points.push_back({{1, 1, 1}});
  mesh.points.push_back({{2, 1, 1}});
  const auto n = static_cast<std::uint32_t>(mesh.points.size());
  add_cell(mesh, CellType::tetrahedron, {0, 1, 2, n - 2});
  add_cell(mesh, CellType::tetrahedron, {1, 2, n - 2, n - 1});
  add_cell(mesh, CellType::tetrahedron, {1, 2, n - 2, 3});
  expect_no_tetrahedra(mesh, {"expected one or two cells at a face, got more at 2; first: 3 at "});
}

TEST(tetrahedra, refuse_cells_that_are_there_twice) {
  CellMesh mesh = corner_mesh();
  const std::vector<std::uint32_t> corners(mesh.corners.begin(), mesh.corners.begin() + 4);
  add_cell(mesh, CellType::tetrahedron, {corners[2], corners[1], corners[0], corners[3]});
  expect_no_tetrahedra(mesh, {"expected each cell once, got 1 tetrahedra with the points of "
                              "another; first: of cells 0 and 1"});
  // Beside another cell, and both twice.
  CellMesh pair = pair_mesh();
  add_cell(pair, CellType::tetrahedron, {0, 1, 2, 3});
  expect_no_tetrahedra(pair, {"got 1 tetrahedra with", "of cells 0 and 2"});
  add_cell(pair, CellType::tetrahedron, {0, 2, 1, 4});
  expect_no_tetrahedra(pair, {"got 2 tetrahedra with"});
}

TEST(tetrahedra, drop_cells_that_repeat_a_corner) {
  CellMesh mesh = pair_mesh();
  add_cell(mesh, CellType::tetrahedron, {0, 1, 1, 2});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_repeating, 1U);
  EXPECT_EQ(outcome.mesh.tetrahedra.size(), 2U);
  CellMesh all = test::empty_cells();
  all.points.resize(3);
  add_cell(all, CellType::tetrahedron, {0, 1, 1, 2});
  expect_no_tetrahedra(all, {"got 1 that repeat"});
}

TEST(tetrahedra, are_turned_by_the_majority_of_their_component) {
  CellMesh mesh = pair_mesh();
  // A second component of one cell that is wound the other way, and a flat cell.
  for (const Vec3d& p : {Vec3d{{5, 0, 0}}, Vec3d{{6, 0, 0}}, Vec3d{{5, 1, 0}}, Vec3d{{5, 0, 1}}})
    mesh.points.push_back(p);
  add_cell(mesh, CellType::tetrahedron, {5, 7, 6, 8});
  mesh.points.push_back({{2, 2, 0}});
  add_cell(mesh, CellType::tetrahedron, {5, 6, 7, 9});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_components, 2U);
  EXPECT_EQ(outcome.report.n_left_handed, 2U);
  EXPECT_EQ(outcome.report.n_zero_volume, 1U);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_GT(test::volume_of(outcome.mesh, 2), 0);
}

TEST(tetrahedra, keep_and_count_cells_that_stay_inverted) {
  CellMesh mesh = pair_mesh();
  mesh.points.push_back({{1, 1, 1}});
  mesh.points.push_back({{0.2, 0.2, 0.2}});
  // Wound as its neighbour wants it, but with its apex on the neighbour's side.
  add_cell(mesh, CellType::tetrahedron, {1, 2, 3, 6});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_inverted, 1U);
  EXPECT_EQ(outcome.report.n_left_handed, 0U);
  EXPECT_LT(test::volume_of(outcome.mesh, 2), 0);
}

TEST(tetrahedra, are_wound_alike_whatever_order_corners_are_in) {
  CellMesh mesh = pair_mesh();
  mesh.points.push_back({{1, 1, 1}});
  add_cell(mesh, CellType::tetrahedron, {1, 2, 5, 3});  // Right would be 1 2 3 5.
  const TetrahedraOutcome one = tetrahedra_of(mesh);
  EXPECT_EQ(one.report.n_inverted, 0U);
  EXPECT_EQ(one.report.n_left_handed, 1U);
  // A grid of which about half is wound the other way, at random.
  CellMesh grid = test::empty_cells();
  const TetraMesh regular = oracles::noise_mesh(5, oracles::Cut::in_six, 1);
  grid.points = regular.positions;
  oracles::Random random(4);
  std::uint64_t n_turned = 0;
  for (auto t : regular.tetrahedra) {
    const bool is_turned = random.below(5) < 2;
    if (is_turned) std::swap(t[1], t[3]);
    n_turned += is_turned ? 1 : 0;
    add_cell(grid, CellType::tetrahedron, {t[0], t[1], t[2], t[3]});
  }
  const TetrahedraOutcome all = tetrahedra_of(grid);
  EXPECT_EQ(all.report.n_inverted, 0U);
  EXPECT_EQ(all.report.n_left_handed, n_turned);
  EXPECT_NEAR(test::total_volume(all.mesh), 1, 1e-12);
  // As its mirror image all of them are turned, but for those that were.
  for (Vec3d& p : grid.points) p[0] = -p[0];
  const TetrahedraOutcome mirrored = tetrahedra_of(grid);
  EXPECT_EQ(mirrored.report.n_inverted, 0U);
  EXPECT_EQ(mirrored.report.n_left_handed, regular.tetrahedra.size() - n_turned);
}

TEST(tetrahedra, refuse_a_face_of_three_cells) {
  CellMesh mesh = pair_mesh();
  mesh.points.push_back({{1, 1, 1}});
  add_cell(mesh, CellType::tetrahedron, {0, 1, 2, 5});
  expect_no_tetrahedra(mesh, {"got more at 1; first: 3 at points 0, 1 and 2, among them cell 0"});
}

TEST(tetrahedra, of_open_polyhedra_are_refused) {
  CellMesh mesh = corner_mesh();
  test::add_polyhedron(mesh, {{0, 2, 1}, {0, 1, 4}, {0, 4, 2}, {0, 1, 2}});
  expect_no_tetrahedra(mesh, {"closed polyhedra", "cell 1"});
}

/// Two tetrahedra with a face at one place but not in common; a vertex is 0.1 away.
CellMesh torn_mesh() {
  CellMesh mesh = corner_mesh();
  mesh.points.insert(mesh.points.end(), {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1.1, 0}}});
  add_cell(mesh, CellType::tetrahedron, {5, 7, 6, 4});
  mesh.point_fields = {{"f", ScalarType::float32, 1, {0, 1, 2, 3, 4, 0, 1.25, 2}},
                       {"g", ScalarType::int32, 1, {0, 0, 0, 0, 0, 7, 0, 0}}};
  return mesh;
}

TEST(welded_points, are_those_at_one_place_with_one_value) {
  EXPECT_EQ(tetrahedra_of(torn_mesh()).report.n_coincident_points, 2U);
  EXPECT_EQ(tetrahedra_of(torn_mesh()).report.n_welded_points, 0U);
  const auto welded = [](double distance, double values, const char* field) {
    return tetrahedra_of(torn_mesh(),
                         {.fields = {field}, .weld_distance = distance, .weld_values = values})
        .report;
  };
  EXPECT_EQ(welded(0, 0, "f").n_welded_points, 1U);
  EXPECT_EQ(welded(0, 0, "f").n_weld_refusals, 1U);
  EXPECT_EQ(welded(0, 0, "f").n_coincident_points, 1U);
  EXPECT_EQ(welded(0, 0.25, "f").n_welded_points, 2U);
  EXPECT_EQ(welded(0, 0.25, "f").n_components, 2U);
  EXPECT_EQ(welded(0.11, 0.25, "f").n_welded_points, 3U);
  EXPECT_EQ(welded(0.11, 0.25, "f").n_components, 1U);
  EXPECT_EQ(welded(0.09, 0.25, "f").n_welded_points, 2U);
  EXPECT_EQ(welded(0, 0, "g").n_weld_refusals, 2U);
  EXPECT_EQ(welded(0, 0, "g").n_unused_points, 0U);
}

TEST(welded_points, agree_in_fields_that_are_not_chosen) {
  CellMesh mesh = torn_mesh();
  mesh.point_fields[1].type = ScalarType::float64;
  const auto welded = [&](double values) {
    return tetrahedra_of(mesh, {.fields = {"f"}, .weld_distance = 0, .weld_values = values}).report;
  };
  EXPECT_EQ(welded(0).n_welded_points, 0U);
  EXPECT_EQ(welded(0).n_weld_refusals, 2U);
  EXPECT_EQ(welded(0.25).n_welded_points, 1U);
  EXPECT_EQ(welded(7).n_welded_points, 2U);
}

TEST(welded_points, take_the_smallest_id_that_agrees) {
  // Points 0, 1 and 2 in a row, each close to the next: 1 joins 0, and 2 then has none to join.
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}}, {{0.6, 0, 0}}, {{1.2, 0, 0}}, {{9, 0, 0}}, {{0, 9, 0}}, {{0, 0, 9}}};
  add_cell(mesh, CellType::tetrahedron, {0, 3, 4, 5});
  add_cell(mesh, CellType::tetrahedron, {1, 4, 3, 5});
  add_cell(mesh, CellType::tetrahedron, {2, 3, 4, 5});
  expect_no_tetrahedra(mesh,
                       {"got 1 tetrahedra with the points of another; first: of cells 0 and 1"},
                       {.weld_distance = 1});
  mesh.points[5] = {{0, 0, 9}};
  mesh.points.push_back({{0, 0, -9}});
  mesh.corners[7] = 6;
  mesh.corners[11] = 6;
  expect_no_tetrahedra(mesh, {}, {.weld_distance = -1});
  expect_no_tetrahedra(mesh, {}, {.weld_distance = std::nan("")});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh, {.weld_distance = 1});
  EXPECT_EQ(outcome.report.n_welded_points, 1U);
  EXPECT_EQ(outcome.mesh.positions[1], (Vec3d{{1.2, 0, 0}}));
}

TEST(hexahedra, that_collapse_when_welded_stay_conforming) {
  // A ring of hexahedra round an axis, whose inner sides are points of that axis.
  CellMesh mesh = test::empty_cells();
  constexpr int kSides = 7;
  for (int i = 0; i < kSides; ++i)
    for (int z = 0; z < 3; ++z)
      for (const double r : {0.0, 1.0, 2.0})
        mesh.points.push_back({{r * std::cos(0.9 * i), r * std::sin(0.9 * i), 1.0 * z}});
  for (std::uint32_t i = 0; i < kSides - 1; ++i)
    for (std::uint32_t z = 0; z < 2; ++z)
      for (std::uint32_t r = 0; r < 2; ++r) {
        const std::uint32_t a = i * 9 + z * 3 + r;
        add_cell(mesh, CellType::hexahedron,
                 {a, a + 1, a + 10, a + 9, a + 3, a + 4, a + 13, a + 12});
      }
  const double volume = test::total_volume(tetrahedra_of(mesh).mesh);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh, {.weld_distance = 0});
  EXPECT_EQ(outcome.report.n_welded_points, 3U * (kSides - 1));
  EXPECT_EQ(outcome.report.n_zero_volume, 0U);
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_GT(outcome.report.n_repeating, 0U);
  EXPECT_NEAR(test::total_volume(outcome.mesh), volume, 1e-13);
  for (const auto& [face, count] : test::count_faces(outcome.mesh)) ASSERT_LE(count, 2);
}

}  // namespace
}  // namespace lode::io
