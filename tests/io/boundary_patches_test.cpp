// Which faces of the boundary the faces in a file make patches of.
#include "lode/io/boundary_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::add_cell;
using test::expect_no_tetrahedra;
using test::tetrahedra_of;

/// 2 x 1 x 1 hexahedra, points by x, then y, then z; PatchId by cell, 0 of those two.
CellMesh hexahedra() {
  CellMesh mesh = test::empty_cells();
  for (int i = 0; i < 12; ++i)
    mesh.points.push_back({{1.0 * (i % 3), 1.0 * (i / 3 % 2), 1.0 * (i / 6)}});
  add_cell(mesh, CellType::hexahedron, {0, 1, 4, 3, 6, 7, 10, 9});
  add_cell(mesh, CellType::hexahedron, {1, 2, 5, 4, 7, 8, 11, 10});
  mesh.cell_fields = {{"patchid", ScalarType::int32, 1, {0, 0}}};
  return mesh;
}

void add_face(CellMesh& mesh, CellType type, const std::vector<std::uint32_t>& corners,
              double patch) {
  add_cell(mesh, type, corners);
  mesh.cell_fields[0].values.push_back(patch);
}

/// By id: how large, and where on an axis.
std::map<std::int64_t, double> areas_of(const TetraMesh& mesh) {
  std::map<std::int64_t, double> areas;
  for (const PatchFace& face : mesh.patch_faces) {
    const auto& p = mesh.positions;
    const auto& [a, b, c] = face.corners;
    areas[mesh.patches[face.patch].id] += length(cross(p[b] - p[a], p[c] - p[a])) / 2;
  }
  return areas;
}

TEST(boundary_patches, are_of_the_triangles_that_faces_of_cells_become) {
  CellMesh mesh = hexahedra();
  add_face(mesh, CellType::quad, {0, 3, 9, 6}, -4);  // all at x = 0
  add_face(mesh, CellType::quad, {2, 8, 11, 5}, 9);  // all at x = 2
  add_face(mesh, CellType::quad, {1, 4, 10, 7}, 5);  // between both
  add_face(mesh, CellType::quad, {0, 1, 7, 6}, 0);   // of none
  add_face(mesh, CellType::line, {0, 1}, 9);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.patches, (std::vector<BoundaryPatch>{{-4, ""}, {9, ""}}));
  EXPECT_EQ(areas_of(outcome.mesh), (std::map<std::int64_t, double>{{-4, 1}, {9, 1}}));
  for (const PatchFace& face : outcome.mesh.patch_faces)
    for (const std::uint32_t v : face.corners)
      EXPECT_EQ(outcome.mesh.positions[v][0], face.patch == 0 ? 0 : 2);
  EXPECT_EQ(outcome.report.n_patches, 2U);
  EXPECT_EQ(outcome.report.n_patch_cells, 2U);
  EXPECT_EQ(outcome.report.n_inner_faces, 1U);
  EXPECT_EQ(outcome.report.n_lower_cells, 2U);
}

TEST(boundary_patches, may_be_larger_than_faces_and_the_first_one_counts) {
  CellMesh mesh = hexahedra();
  // A polygon of six corners over two faces, and a part of it again.
  add_face(mesh, static_cast<CellType>(7), {0, 1, 2, 8, 7, 6}, 3);
  add_face(mesh, CellType::quad, {0, 1, 7, 6}, 4);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(areas_of(outcome.mesh), (std::map<std::int64_t, double>{{3, 2}}));
  EXPECT_EQ(outcome.report.n_patch_cells, 1U);
  EXPECT_EQ(outcome.report.n_inner_faces, 1U);
}

TEST(boundary_patches, follow_points_that_are_welded_and_left_out) {
  CellMesh mesh = hexahedra();
  // The face comes with points of its own, and one that nobody has is before all.
  mesh.points.insert(mesh.points.begin(), Vec3d{{7, 7, 7}});
  for (std::uint32_t& corner : mesh.corners) ++corner;
  for (const std::uint32_t from : {3U, 9U, 12U, 6U}) mesh.points.push_back(mesh.points[from]);
  add_face(mesh, CellType::quad, {13, 14, 15, 16}, 6);
  EXPECT_EQ(tetrahedra_of(mesh).mesh.patch_faces.size(), 0U);
  add_cell(mesh, CellType::tetrahedron, {13, 14, 15, 16});  // so that these are used
  mesh.points[16] = {{3, 0.5, 0.5}};
  mesh.cell_fields[0].values.push_back(0);
  mesh.cell_fields[0].values[2] = 0;
  add_face(mesh, CellType::triangle, {13, 15, 16}, 8);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh, {.weld_distance = 0});
  EXPECT_EQ(areas_of(outcome.mesh).size(), 1U);
  EXPECT_EQ(outcome.mesh.patches[0].id, 8);
}

TEST(boundary_patches, are_numbered_by_the_regions_field_where_there_is_no_other) {
  CellMesh mesh = hexahedra();
  mesh.cell_fields[0].name = "RegionId";
  mesh.cell_fields[0].values = {1, 2};
  mesh.patch_names = {{7, "inlet"}, {8, "of no face"}};
  add_face(mesh, CellType::quad, {0, 3, 9, 6}, 7);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(outcome.mesh.patches, (std::vector<BoundaryPatch>{{7, "inlet"}}));
}

TEST(boundary_patches, have_numbers_that_doubles_tell_apart_and_names_in_one_line) {
  CellMesh mesh = hexahedra();
  add_face(mesh, CellType::quad, {0, 3, 9, 6}, 0x1p53);
  expect_no_tetrahedra(mesh, {"numbers of patches below 2^53", "patchid"});
  mesh.cell_fields[0].values.back() = 0x1p53 - 1;
  mesh.patch_names = {{(std::int64_t{1} << 53) - 1, "in\nlet\x1b[31m"}, {1, "of no face"}};
  EXPECT_EQ(tetrahedra_of(mesh).mesh.patches[0].name, "in let [31m");
}

TEST(boundary_patches, of_very_many_faces_at_a_point_are_found_in_no_time) {
  // A double pyramid over a ring of points: all faces have one of its ends.
  constexpr std::uint32_t kFaces = 30'000;
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 1}}, {{0, 0, -1}}};
  mesh.cell_fields = {{"PatchId", ScalarType::int32, 1, {}}};
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    const double angle = 6.283185307179586 * i / kFaces;
    mesh.points.push_back({{std::cos(angle), std::sin(angle), 0}});
    add_face(mesh, CellType::tetrahedron, {0, 1, 2 + i, 2 + (i + 1) % kFaces}, 0);
  }
  for (std::uint32_t i = 0; i < kFaces; ++i)
    add_face(mesh, CellType::triangle, {0, 2 + i, 2 + (i + 1) % kFaces}, 1 + i % 3);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.patch_faces.size(), kFaces);
  EXPECT_EQ(outcome.report.n_inner_faces, 0U);
}

TEST(boundary_patches, of_quadratic_tetrahedra_are_of_their_parts) {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}},   {{1, 0, 0}},  {{0, 1, 0}},  {{0, 0, 1}},   {{.5, 0, 0}},
                 {{.5, .5, 0}}, {{0, .5, 0}}, {{0, 0, .5}}, {{.5, 0, .5}}, {{0, .5, .5}}};
  add_cell(mesh, CellType::quadratic_tetrahedron, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  mesh.cell_fields = {{"medit:ref", ScalarType::int32, 1, {1}}};
  add_face(mesh, static_cast<CellType>(22), {0, 1, 2, 4, 5, 6}, 5);
  const TetrahedraOutcome split = tetrahedra_of(mesh);
  EXPECT_EQ(split.mesh.patch_faces.size(), 4U);
  EXPECT_EQ(areas_of(split.mesh), (std::map<std::int64_t, double>{{5, 0.5}}));
  const TetrahedraOutcome corners = tetrahedra_of(mesh, {.quadratic = QuadraticCells::corners});
  EXPECT_EQ(corners.mesh.patch_faces.size(), 1U);
  EXPECT_EQ(areas_of(corners.mesh), (std::map<std::int64_t, double>{{5, 0.5}}));
}

}  // namespace
}  // namespace lode::io
