#include "lode/io/quadratic_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/io/mixed_mesh.h"
#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::add_cell;
using test::expect_no_tetrahedra;
using test::MixedMesh;
using test::quadratic_of;
using test::tetrahedra_of;

CellMesh quadratic_mesh() {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}},   {{1, 0, 0}},  {{0, 1, 0}}, {{0, 0, 2}},  {{.5, 0, 0}},
                 {{.5, .5, 0}}, {{0, .5, 0}}, {{0, 0, 1}}, {{.5, 0, 1}}, {{0, .5, 1}}};
  add_cell(mesh, CellType::quadratic_tetrahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  return mesh;
}

TEST(quadratic_tetrahedron, becomes_eight_round_its_shortest_diagonal) {
  const TetrahedraOutcome outcome = tetrahedra_of(quadratic_mesh());
  ASSERT_EQ(outcome.mesh.tetrahedra.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_NEAR(test::volume_of(outcome.mesh, i), 2.0 / 6 / 8, 1e-15);
  EXPECT_EQ(outcome.report.n_boundary_faces, 16U);
  // All three diagonals are as long here; 4 and 9 are those of the smallest point.
  for (std::size_t i = 4; i < 8; ++i) {
    EXPECT_EQ(outcome.mesh.tetrahedra[i][0], 4U);
    EXPECT_EQ(outcome.mesh.tetrahedra[i][1], 9U);
  }
  CellMesh bent = quadratic_mesh();
  bent.points[8] = {{.4, .05, 1}};
  EXPECT_EQ(tetrahedra_of(bent).mesh.tetrahedra[4][1], 8U);
}

TEST(quadratic_tetrahedron, becomes_that_of_its_corners_when_asked) {
  const TetrahedraOutcome outcome =
      tetrahedra_of(quadratic_mesh(), {.quadratic = QuadraticCells::corners});
  EXPECT_EQ(outcome.mesh.tetrahedra.size(), 1U);
  EXPECT_EQ(outcome.report.n_unused_points, 6U);
}

/// A linear cell, and what its quadratic forms are split into.
struct Shape {
  const char* name = "";
  CellType type{};
  std::vector<Vec3d> corners;
  double volume = 1;
  std::array<std::size_t, 2> n_tetrahedra{};  ///< Without and with nodes in faces' middles.
};

std::vector<Shape> shapes() {
  const Vec3d o{{0, 0, 0}};
  const Vec3d x{{1, 0, 0}};
  const Vec3d y{{0, 1, 0}};
  const Vec3d z{{0, 0, 1}};
  return {{"hexahedron",
           CellType::hexahedron,
           {o, x, x + y, y, z, x + z, x + y + z, y + z},
           1,
           {36, 48}},
          {"wedge", CellType::wedge, {o, x, y, z, x + z, y + z}, 0.5, {26, 32}},
          {"pyramid", CellType::pyramid, {o, x, x + y, y, (x + y) * 0.5 + z}, 1.0 / 3, {22, 24}}};
}

CellMesh linear_cell(const Shape& shape) {
  CellMesh mesh = test::empty_cells();
  mesh.points = shape.corners;
  std::vector<std::uint32_t> all;
  for (std::uint32_t i = 0; i < shape.corners.size(); ++i) all.push_back(i);
  add_cell(mesh, shape.type, all);
  return mesh;
}

/// With nodes exactly in the middle, and a field of them.
CellMesh straight_cell(const Shape& shape, bool is_full, double (*field)(const Vec3d&)) {
  const CellMesh linear = linear_cell(shape);
  CellMesh mesh = quadratic_of(linear, is_full, 0);
  mesh.point_fields[0].values.clear();
  for (const Vec3d& p : mesh.points) mesh.point_fields[0].values.push_back(field(p));
  return mesh;
}

/// Quadratic, and rising along all axes in the cells, so that its values in the middle of one are
/// within those at the nodes.
double rising(const Vec3d& p) {
  return 2 * p[0] * p[0] + p[0] * p[1] + 3 * p[1] * p[1] + p[1] * p[2] + p[2] * p[2] + p[0] + 1;
}

TEST(quadratic_cells, are_filled_by_tetrahedra_between_all_of_their_nodes) {
  for (const Shape& shape : shapes())
    for (const bool is_full : {false, true}) {
      SCOPED_TRACE(testing::Message() << shape.name << is_full);
      const CellMesh mesh = straight_cell(shape, is_full, rising);
      const TetrahedraOutcome outcome = tetrahedra_of(mesh);
      EXPECT_EQ(outcome.mesh.tetrahedra.size(), shape.n_tetrahedra[is_full ? 1 : 0]);
      for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
        EXPECT_GT(test::volume_of(outcome.mesh, i), 1e-3);
      EXPECT_NEAR(test::total_volume(outcome.mesh), shape.volume, 1e-14);
      EXPECT_EQ(outcome.report.n_unused_points, 0U);
      for (const auto& [face, count] : test::count_faces(outcome.mesh)) ASSERT_LE(count, 2);
      // In the middle, too, quadratic fields are what they are.
      for (std::size_t i = 0; i < outcome.mesh.positions.size(); ++i)
        EXPECT_NEAR(outcome.mesh.fields[0].values[i], rising(outcome.mesh.positions[i]), 1e-14);
    }
}

TEST(quadratic_cells, have_no_higher_peak_in_their_middle_than_at_their_nodes) {
  for (const Shape& shape : shapes()) {
    CellMesh mesh = straight_cell(shape, false, rising);
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      mesh.point_fields[0].values[i] = i < shape.corners.size() ? 0 : 1;
    const TetraMesh result = tetrahedra_of(mesh).mesh;
    ASSERT_EQ(result.positions.size(), mesh.points.size() + 1);
    EXPECT_EQ(result.fields[0].values.back(), 1) << shape.name;
  }
}

TEST(quadratic_cells, without_a_value_at_a_node_have_none_in_their_middle) {
  CellMesh mesh = straight_cell(shapes()[0], false, rising);
  mesh.point_fields[0].values[3] = std::numeric_limits<double>::quiet_NaN();
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  ASSERT_EQ(outcome.report.nonfinite.size(), 1U);
  EXPECT_EQ(outcome.report.nonfinite[0].n_values, 1U);  // of the file's
  EXPECT_EQ(outcome.report.nonfinite[0].first, 3U);
}

TEST(quadratic_cells, bent_beyond_their_middle_are_split_round_another_point_or_refused) {
  CellMesh mesh = straight_cell(shapes()[0], false, rising);
  // The middle of an upright edge comes past where the middle of the cell goes with it.
  mesh.points[18] = {{0.3, 0.3, 0.5}};
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  EXPECT_LT(outcome.mesh.positions.back()[0], 0.3);
  for (std::size_t i = 0; i < outcome.mesh.tetrahedra.size(); ++i)
    EXPECT_GT(test::volume_of(outcome.mesh, i), 0);
  mesh.points[18] = {{-0.2, -0.2, 0.5}};
  expect_no_tetrahedra(mesh, {"got 1 in which none does, the first of them cell 0"});
}

TEST(quadratic_cells, with_a_side_of_no_length_meet_those_of_the_triangle_that_is_left) {
  // A hexahedron whose edge 2 3 has become a point, and that of 6 7, is a wedge; another wedge is
  // beside the face that was a quadrilateral.
  const auto wedge_shape = shapes()[1];
  CellMesh mesh = straight_cell(wedge_shape, false, rising);
  const std::vector<std::uint32_t> w(mesh.corners.begin(), mesh.corners.end());
  CellMesh collapsed = test::empty_cells();
  collapsed.points = mesh.points;
  add_cell(collapsed, CellType::quadratic_hexahedron,
           {w[0], w[1], w[2], w[2],  w[3], w[4],  w[5],  w[5],  w[6],  w[7],
            w[2], w[8], w[9], w[10], w[5], w[11], w[12], w[13], w[14], w[14]});
  const auto first = static_cast<std::uint32_t>(collapsed.points.size());
  for (const std::size_t i : {3, 4, 5, 9, 10, 11, 12, 13, 14})
    collapsed.points.push_back(mesh.points[w[i]] + Vec3d{{0, 0, 1}});
  std::vector<std::uint32_t> above = {w[3],      w[4],      w[5],      first,     first + 1,
                                      first + 2, w[9],      w[10],     w[11],     first + 3,
                                      first + 4, first + 5, first + 6, first + 7, first + 8};
  add_cell(collapsed, CellType::quadratic_wedge, above);
  const TetrahedraOutcome outcome = tetrahedra_of(collapsed);
  EXPECT_NEAR(test::total_volume(outcome.mesh), 1, 1e-14);
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_EQ(outcome.report.n_inverted, 0U);
  // Two triangular ends of 4, and three quadrilaterals of 6 on each of both.
  EXPECT_EQ(outcome.report.n_boundary_faces, 44U);
}

TEST(quadratic_cells, of_lagrange_types_are_what_they_are_without) {
  const auto lagrange = [](std::uint8_t type) {
    switch (static_cast<CellType>(type)) {
      case CellType::triquadratic_hexahedron: return CellType::lagrange_hexahedron;
      case CellType::biquadratic_wedge: return CellType::lagrange_wedge;
      case CellType::hexahedron: return CellType::lagrange_hexahedron;
      case CellType::wedge: return CellType::lagrange_wedge;
      default: return CellType::lagrange_pyramid;
    }
  };
  for (const Shape& shape : shapes())
    for (const bool is_linear : {false, true}) {
      CellMesh mesh = is_linear ? linear_cell(shape) : straight_cell(shape, true, rising);
      const TetraMesh expected = tetrahedra_of(mesh).mesh;
      mesh.types[0] = static_cast<std::uint8_t>(lagrange(mesh.types[0]));
      EXPECT_EQ(tetrahedra_of(mesh).mesh.tetrahedra, expected.tetrahedra) << shape.name;
    }
  CellMesh tetrahedron = quadratic_mesh();
  const TetraMesh expected = tetrahedra_of(tetrahedron).mesh;
  tetrahedron.types[0] = static_cast<std::uint8_t>(CellType::lagrange_tetrahedron);
  EXPECT_EQ(tetrahedra_of(tetrahedron).mesh.tetrahedra, expected.tetrahedra);
}

TEST(quadratic_cells, whose_nodes_are_in_the_order_of_another_program_are_put_right_and_counted) {
  const auto expect_put_right = [](const Shape& shape, bool is_full, std::size_t first,
                                   std::size_t second, std::size_t n) {
    CellMesh mesh = straight_cell(shape, is_full, rising);
    mesh.points[first] = mesh.points[first] + Vec3d{{0.05, 0.04, 0.03}};
    const TetrahedraOutcome expected = tetrahedra_of(mesh);
    EXPECT_EQ(expected.report.n_reordered, 0U);
    for (std::size_t i = 0; i < n; ++i)
      std::swap(mesh.corners[first + i], mesh.corners[second + i]);
    const TetrahedraOutcome outcome = tetrahedra_of(mesh);
    EXPECT_EQ(outcome.report.n_reordered, 1U);
    EXPECT_EQ(outcome.mesh.tetrahedra, expected.mesh.tetrahedra);
  };
  for (const bool is_full : {false, true}) {
    expect_put_right(shapes()[0], is_full, 12, 16, 4);  // as Exodus II has them
    expect_put_right(shapes()[0], is_full, 18, 19, 1);  // as VTK before 9.1 has Lagrange cells
    expect_put_right(shapes()[1], is_full, 9, 12, 3);
  }
}

TEST(quadratic_cells, of_too_few_nodes_are_refused) {
  for (const int type : {71, 72, 73, 74, 78}) {
    CellMesh mesh = test::empty_cells();
    mesh.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    add_cell(mesh, static_cast<CellType>(type), {0, 1, 2});
    expect_no_tetrahedra(mesh, {"got 1 of type"});
    expect_no_tetrahedra(mesh, {"got 1 of type"}, {.quadratic = QuadraticCells::corners});
  }
}

struct QuadraticCase {
  std::uint64_t seed = 0;
  bool is_full = false;
  bool is_mirrored = false;
  bool has_turned_wedges = false;
};

class quadratic_mixtures : public testing::TestWithParam<std::uint64_t> {};

/// Hexahedra, wedges and pyramids with bent edges and faces.
CellMesh mixture(const QuadraticCase& of) {
  const MixedMesh linear({.seed = of.seed,
                          .n = 3,
                          .has_turned_wedges = of.has_turned_wedges,
                          .is_mirrored = of.is_mirrored,
                          .has_polyhedra = false});
  return quadratic_of(linear.mesh(), of.is_full, 3);
}

TEST_P(quadratic_mixtures, become_conforming_tetrahedra) {
  for (const bool is_full : {false, true})
    for (const bool is_mirrored : {false, true})
      for (const bool has_turned_wedges : {false, true}) {
        const CellMesh mesh = mixture({GetParam(), is_full, is_mirrored, has_turned_wedges});
        const TetrahedraOutcome outcome = tetrahedra_of(mesh);
        test::expect_conforming(outcome.mesh, 3);
        EXPECT_EQ(outcome.report.n_inverted, 0U);
        EXPECT_EQ(outcome.report.n_zero_volume, 0U);
        EXPECT_EQ(outcome.report.n_components, 1U);
        EXPECT_EQ(outcome.report.n_unused_points, 0U);
        for (std::size_t i = 0; i < outcome.mesh.positions.size(); ++i) {
          const Vec3d& p = outcome.mesh.positions[i];
          ASSERT_NEAR(outcome.mesh.fields[0].values[i], 3 * p[0] - 2 * p[1] + p[2] + 1, 1e-13);
        }
      }
}

TEST_P(quadratic_mixtures, are_the_linear_ones_when_linearised) {
  const MixedMesh linear({.seed = GetParam(), .n = 3, .has_polyhedra = false});
  const TetraMesh expected = tetrahedra_of(linear.mesh()).mesh;
  for (const bool is_full : {false, true}) {
    const TetrahedraOutcome outcome = tetrahedra_of(quadratic_of(linear.mesh(), is_full, 3),
                                                    {.quadratic = QuadraticCells::corners});
    EXPECT_EQ(outcome.mesh.tetrahedra, expected.tetrahedra);
    EXPECT_EQ(outcome.mesh.positions, expected.positions);
  }
}

INSTANTIATE_TEST_SUITE_P(seeds, quadratic_mixtures,
                         testing::Range(std::uint64_t{1}, std::uint64_t{7}));

const std::array<Vec3d, 4> kFarCorners = {{{{9, 9, 9}}, {{10, 9, 9}}, {{9, 10, 9}}, {{9, 9, 10}}}};

/// A pyramid and a tetrahedron on one of its sides.
CellMesh pyramid_and_tetrahedron() {
  CellMesh mesh = linear_cell(shapes()[2]);
  mesh.points.push_back({{2, 0.5, 1}});
  add_cell(mesh, CellType::tetrahedron, {1, 2, 4, 5});
  return mesh;
}

TEST(quadratic_neighbours, of_pyramids_may_be_tetrahedra) {
  const CellMesh linear = pyramid_and_tetrahedron();
  const TetrahedraOutcome outcome = tetrahedra_of(quadratic_of(linear, false, 0));
  EXPECT_EQ(outcome.report.n_components, 1U);
  // Four triangles and a quadrilateral of 6, and three of the tetrahedron.
  EXPECT_EQ(outcome.report.n_boundary_faces, 3U * 4 + 6 + 3 * 4);
}

TEST(quadratic_neighbours, that_have_no_nodes_are_refused_unless_linearised) {
  const CellMesh linear = pyramid_and_tetrahedron();
  CellMesh mesh = quadratic_of(linear, false, 0);
  // The tetrahedron is its corners.
  mesh.types[1] = static_cast<std::uint8_t>(CellType::tetrahedron);
  mesh.begins[2] = mesh.begins[1] + 4;
  mesh.corners.resize(static_cast<std::size_t>(mesh.begins[2]));
  expect_no_tetrahedra(mesh,
                       {"got 3 edges", "the first between points 1 and 2", "--linearise corners"});
  EXPECT_EQ(tetrahedra_of(mesh, {.quadratic = QuadraticCells::corners}).report.n_components, 1U);
}

TEST(quadratic_neighbours, that_have_nodes_of_their_own_are_refused_unless_welded) {
  CellMesh mesh = quadratic_of(pyramid_and_tetrahedron(), false, 0);
  // The tetrahedron's node between points 1 and 2 is another at the same place.
  const std::size_t at = static_cast<std::size_t>(mesh.begins[1]) + 4;
  mesh.points.push_back(mesh.points[mesh.corners[at]]);
  mesh.point_fields[0].values.push_back(mesh.point_fields[0].values[mesh.corners[at]]);
  mesh.corners[at] = static_cast<std::uint32_t>(mesh.points.size() - 1);
  expect_no_tetrahedra(mesh, {"got 1 faces with two at one place", "points 1, 2, 4", "--weld 0"});
  CellMesh parted = mesh;
  parted.points.back()[0] += 0.01;
  EXPECT_EQ(tetrahedra_of(parted).report.n_parted_faces, 1U);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh, {.weld_distance = 0});
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_EQ(outcome.report.n_welded_points, 1U);
}

TEST(quadratic_neighbours, may_all_lack_a_node_but_not_some_of_them) {
  CellMesh mesh = quadratic_of(pyramid_and_tetrahedron(), false, 0);
  // A corner in place of the node between points 1 and 2, as some programs have it.
  mesh.corners[static_cast<std::size_t>(mesh.begins[1]) + 4] = 1;
  expect_no_tetrahedra(mesh, {"got 1 edges", "between points 1 and 2"});
  mesh.corners[6] = 1;
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_GT(outcome.report.n_repeating, 0U);
  EXPECT_NEAR(test::total_volume(outcome.mesh), 1.0 / 3 + 1.0 / 4, 1e-14);
}

TEST(quadratic_neighbours, of_which_one_has_a_node_in_the_face_are_refused) {
  CellMesh linear = linear_cell(shapes()[0]);
  linear.points.push_back({{0.5, 0.5, 2}});
  add_cell(linear, CellType::pyramid, {4, 5, 6, 7, 8});
  CellMesh mesh = quadratic_of(linear, true, 0);
  EXPECT_EQ(tetrahedra_of(mesh).report.n_components, 1U);
  mesh.types[1] = static_cast<std::uint8_t>(CellType::quadratic_pyramid);
  mesh.corners.pop_back();
  --mesh.begins[2];
  expect_no_tetrahedra(mesh, {"got 1 faces", "points 4, 5, 6, 7", "--linearise corners"});
}

/// Two lips of a crack that share the ends of an edge, each with a middle of its own.
TEST(quadratic_neighbours, at_an_edge_alone_may_have_nodes_of_their_own) {
  CellMesh linear = test::empty_cells();
  linear.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, -1, 0}}, {{0, 0, -1}}};
  add_cell(linear, CellType::tetrahedron, {0, 1, 2, 3});
  add_cell(linear, CellType::tetrahedron, {0, 1, 4, 5});
  CellMesh mesh = quadratic_of(linear, false, 0);
  mesh.points.push_back({{0.5, -0.1, 0}});
  mesh.point_fields[0].values.push_back(0);
  mesh.corners[static_cast<std::size_t>(mesh.begins[1]) + 4] =
      static_cast<std::uint32_t>(mesh.points.size() - 1);
  EXPECT_EQ(tetrahedra_of(mesh).report.n_parted_faces, 0U);
}

/// Of a thin shell along a cylinder the diagonal along its axis lies on it, however long it is.
TEST(quadratic_cells, have_the_diagonal_that_follows_a_curved_face) {
  for (const double aspect : {0.7, 1.5, 3.0}) {
    const double angle = 15 * std::acos(-1.0) / 180;
    CellMesh mesh = test::empty_cells();
    mesh.point_fields = {{"f", ScalarType::float64, 1, {}}};
    const auto at = [&](double r, double turn, double z) {
      mesh.points.push_back(
          {{r * std::cos(turn * angle), r * std::sin(turn * angle), z * aspect * angle}});
      mesh.point_fields[0].values.push_back(turn);
    };
    const Shape shape = shapes()[0];
    const CellMesh straight = quadratic_of(linear_cell(shape), false, 0);
    for (const Vec3d& p : straight.points) at(1 + 0.005 * p[0], p[1], p[2]);
    add_cell(mesh, CellType::quadratic_hexahedron,
             {straight.corners.begin(), straight.corners.end()});
    const TetrahedraOutcome outcome = tetrahedra_of(mesh);
    EXPECT_EQ(outcome.report.n_inverted, 0U);
    const double exact = angle * aspect * angle / 2 * (1.005 * 1.005 - 1);
    EXPECT_NEAR(test::total_volume(outcome.mesh), exact, 0.01 * exact) << aspect;
  }
}

TEST(quadratic_neighbours, whose_face_meets_two_triangles_are_refused) {
  CellMesh linear = linear_cell(shapes()[0]);
  linear.points.push_back({{0.5, 0.5, 2}});
  add_cell(linear, CellType::tetrahedron, {4, 5, 6, 8});
  add_cell(linear, CellType::tetrahedron, {4, 6, 7, 8});
  expect_no_tetrahedra(quadratic_of(linear, false, 0),
                       {"of which two corners are another cell's edge", "points 4 and 6"});
}

TEST(quadratic_neighbours, of_polyhedra_may_be_elsewhere_alone) {
  CellMesh mesh = test::empty_cells();
  mesh.points = quadratic_mesh().points;
  mesh.points.push_back({{1, 1, 3}});
  const auto first = static_cast<std::uint32_t>(mesh.points.size());
  for (const Vec3d& p : kFarCorners) mesh.points.push_back(p);
  add_cell(mesh, CellType::quadratic_tetrahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  test::add_polyhedron(mesh, {{first, first + 1, first + 2},
                              {first, first + 1, first + 3},
                              {first + 1, first + 2, first + 3},
                              {first + 2, first, first + 3}});
  EXPECT_EQ(tetrahedra_of(mesh).report.n_components, 2U);
  test::add_polyhedron(mesh, {{1, 2, 3}, {1, 2, 10}, {2, 3, 10}, {3, 1, 10}});
  expect_no_tetrahedra(mesh,
                       {"share no edge with polyhedra", "got 1 that do", "--linearise corners"});
}

TEST(quadratic_cells, that_lose_peaks_when_linearised_say_so) {
  CellMesh mesh = straight_cell(shapes()[0], false, rising);
  for (double& value : mesh.point_fields[0].values) value = 1;
  mesh.point_fields[0].values[12] = 100;
  const auto report = tetrahedra_of(mesh, {.quadratic = QuadraticCells::corners}).report;
  ASSERT_EQ(report.linearised.size(), 1U);
  EXPECT_EQ(report.linearised[0].name, "f");
  EXPECT_EQ(report.linearised[0].node_max, 100);
  EXPECT_EQ(report.linearised[0].corner_max, 1);
  mesh.point_fields[0].values[12] = 1;
  EXPECT_TRUE(
      tetrahedra_of(mesh, {.quadratic = QuadraticCells::corners}).report.linearised.empty());
}

}  // namespace
}  // namespace lode::io
