#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "lode/io/tetra_orientation.h"
#include "tests/io/tetra_checks.h"
#include "tests/oracles/random.h"

namespace lode::io {
namespace {

using test::expect_no_tetrahedra;
using test::tetrahedra_of;

/// Two tetrahedra of volumes 1/6 and 1/2 that share a face, with fields of both kinds.
CellMesh field_mesh() {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{0, 0, -3}}};
  test::add_cell(mesh, CellType::tetrahedron, {0, 1, 2, 3});
  test::add_cell(mesh, CellType::tetrahedron, {0, 2, 1, 4});
  mesh.point_fields = {{"t", ScalarType::int16, 1, {1, 2, 3, 4, 5}},
                       {"v", ScalarType::float32, 3, {3, 4, 0, 0, 0, 1, 1, 2, 2, 0, 6, 8, 1, 0, 0}},
                       {"a:1", ScalarType::float32, 1, {9, 8, 7, 6, 5}}};
  mesh.cell_fields = {{"p", ScalarType::float32, 1, {8, -4}},
                      {"MATERIALID", ScalarType::int32, 1, {7, -2}},
                      {"zones", ScalarType::float64, 1, {1, 1}}};
  return mesh;
}

std::vector<std::string> names_of(const TetraMesh& mesh) {
  std::vector<std::string> names;
  for (const MeshField& field : mesh.fields) names.push_back(field.name);
  return names;
}

TEST(tetra_fields, are_all_of_the_points_vectors_as_magnitudes) {
  const TetraMesh mesh = tetrahedra_of(field_mesh()).mesh;
  EXPECT_EQ(names_of(mesh), (std::vector<std::string>{"t", "v", "a:1"}));
  EXPECT_EQ(mesh.fields[0].type, ScalarType::int16);
  EXPECT_EQ(mesh.fields[0].values, (std::vector<double>{1, 2, 3, 4, 5}));
  EXPECT_EQ(mesh.fields[1].n_components, 1);
  EXPECT_EQ(mesh.fields[1].values, (std::vector<double>{5, 1, 3, 10, 1}));
}

TEST(tetra_fields, are_chosen_by_name_and_component) {
  const TetraMesh mesh = tetrahedra_of(field_mesh(), {.fields = {"v:2", "a:1", "v", "p"}}).mesh;
  EXPECT_EQ(names_of(mesh), (std::vector<std::string>{"v:2", "a:1", "v", "p"}));
  EXPECT_EQ(mesh.fields[0].values, (std::vector<double>{0, 1, 2, 8, 0}));
  EXPECT_EQ(mesh.fields[0].type, ScalarType::float32);
  EXPECT_EQ(mesh.fields[1].values, (std::vector<double>{9, 8, 7, 6, 5}));
  EXPECT_EQ(mesh.fields[2].values, (std::vector<double>{5, 1, 3, 10, 1}));
  EXPECT_EQ(tetrahedra_of(field_mesh(), {.fields = {"t:0"}}).mesh.fields[0].values,
            (std::vector<double>{1, 2, 3, 4, 5}));
}

TEST(tetra_fields, that_are_missing_or_twice_are_refused) {
  expect_no_tetrahedra(field_mesh(), {"t, v, a:1, p", "'w'"}, {.fields = {"w"}});
  expect_no_tetrahedra(field_mesh(), {"0 to 2", "'v'", "got 3"}, {.fields = {"v:3"}});
  expect_no_tetrahedra(field_mesh(), {"got -1"}, {.fields = {"v:-1"}});
  expect_no_tetrahedra(field_mesh(), {"'v:x'"}, {.fields = {"v:x"}});
  expect_no_tetrahedra(field_mesh(), {"'t' twice"}, {.fields = {"t", "t"}});
}

TEST(tetra_fields, of_cells_are_means_weighted_by_volume) {
  const TetrahedraOutcome outcome = tetrahedra_of(field_mesh(), {.fields = {"p"}});
  // (8 · 1/6 − 4 · 1/2) / (1/6 + 1/2) at the points that both cells have.
  const std::vector<double> expected = {-1, -1, -1, 8, -4};
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_NEAR(outcome.mesh.fields[0].values[i], expected[i], 1e-14);
  ASSERT_EQ(outcome.report.averaged.size(), 1U);
  EXPECT_EQ(outcome.report.averaged[0].name, "p");
  EXPECT_EQ(outcome.report.averaged[0].cell_max, 8);
  EXPECT_EQ(outcome.report.averaged[0].point_max, 8);
}

TEST(tetra_fields, of_cells_have_the_peaks_of_those_in_the_mesh) {
  CellMesh mesh = field_mesh();
  test::add_cell(mesh, CellType::triangle, {0, 1, 2});
  test::add_cell(mesh, CellType::tetrahedron, {0, 1, 1, 2});
  for (MeshField& field : mesh.cell_fields) field.values.insert(field.values.end(), {900, 800});
  const TetraReport report = tetrahedra_of(mesh, {.fields = {"p"}}).report;
  EXPECT_EQ(report.averaged.at(0).cell_min, -4);
  EXPECT_EQ(report.averaged.at(0).cell_max, 8);
  EXPECT_EQ(report.averaged.at(0).point_min, -4);
  EXPECT_EQ(report.averaged.at(0).point_max, 8);
  EXPECT_EQ(report.averaged.at(0).n_nonfinite_cells, 0U);
}

TEST(tetra_fields, of_cells_that_are_not_finite_are_told_by_cell) {
  CellMesh mesh = field_mesh();
  for (MeshField& field : mesh.cell_fields)
    if (field.name == "p") field.values[1] = std::numeric_limits<double>::infinity();
  const TetraReport report = tetrahedra_of(mesh, {.fields = {"p"}}).report;
  EXPECT_EQ(report.averaged.at(0).n_nonfinite_cells, 1U);
  EXPECT_EQ(report.averaged.at(0).first_nonfinite, 1U);
  EXPECT_EQ(report.averaged.at(0).cell_min, 8);
  EXPECT_EQ(report.averaged.at(0).cell_max, 8);
  EXPECT_EQ(report.nonfinite.at(0).n_values, 4U);
}

TEST(tetra_fields, of_cells_without_volume_are_means_all_the_same) {
  CellMesh mesh = field_mesh();
  for (Vec3d& point : mesh.points) point[2] = 0;
  const TetraMesh flat = tetrahedra_of(mesh, {.fields = {"p"}}).mesh;
  EXPECT_EQ(flat.fields[0].values, (std::vector<double>{2, 2, 2, 8, -4}));
}

TEST(tetra_fields, are_those_of_cells_but_regions_where_points_have_none) {
  CellMesh mesh = field_mesh();
  mesh.point_fields.clear();
  EXPECT_EQ(names_of(tetrahedra_of(mesh).mesh), (std::vector<std::string>{"p", "zones"}));
  mesh.cell_fields.clear();
  EXPECT_TRUE(tetrahedra_of(mesh).mesh.fields.empty());
}

TEST(tetra_fields, that_are_not_finite_are_counted) {
  CellMesh mesh = field_mesh();
  mesh.point_fields[0].values[1] = std::numeric_limits<double>::infinity();
  mesh.point_fields[2].values[4] = std::nan("");
  const auto found = tetrahedra_of(mesh).report.nonfinite;
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, mesh.point_fields[0].name);
  EXPECT_EQ(found[0].n_values, 1U);
  EXPECT_EQ(found[0].first, 1U);
  EXPECT_EQ(found[1].name, mesh.point_fields[2].name);
  EXPECT_EQ(found[1].first, 4U);
}

TEST(tetra_regions, are_recognised_by_name_and_numbered_from_the_smallest) {
  const TetraMesh mesh = tetrahedra_of(field_mesh()).mesh;
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{-2, 7}));
  EXPECT_EQ(mesh.regions, (std::vector<std::uint32_t>{1, 0}));
}

TEST(tetra_regions, may_have_floating_types_and_usual_spellings) {
  for (const char* const name :
       {"MaterialIds", "MaterialID", "Material", "material_id", "Material #", "material ids",
        "region-id", "BLOCK_IDS", "medit:ref"}) {
    CellMesh mesh = field_mesh();
    mesh.cell_fields[1] = {name, ScalarType::float32, 1, {7, -2}};
    const TetrahedraOutcome outcome = tetrahedra_of(mesh);
    EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{-2, 7})) << name;
    EXPECT_TRUE(outcome.report.regions_not_taken.empty());
  }
}

TEST(tetra_regions, have_the_names_of_region_ids_and_of_no_other_field) {
  CellMesh mesh = field_mesh();
  mesh.cell_fields[1] = {"RegionId", ScalarType::int32, 1, {7, -2}};
  mesh.region_names = {{7, "rotor"}, {3, "of no cell"}};
  EXPECT_EQ(tetrahedra_of(mesh).mesh.region_names, (std::vector<std::string>{"", "rotor"}));
  // Of materials these may be other numbers.
  mesh.cell_fields.push_back({"Material", ScalarType::int32, 1, {3, 7}});
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{3, 7}));
  EXPECT_TRUE(outcome.mesh.region_names.empty());
  EXPECT_EQ(outcome.report.regions_not_taken,
            (std::vector<std::string>{"RegionId (Material is taken)"}));
}

TEST(tetra_regions, that_are_not_taken_are_named_with_the_reason) {
  CellMesh mesh = field_mesh();
  mesh.cell_fields[0] = {"Material_Ids", ScalarType::float64, 1, {0.5, 1}};
  mesh.cell_fields.push_back({"BlockId", ScalarType::int32, 2, {1, 2, 3, 4}});
  mesh.cell_fields.push_back({"zone_id", ScalarType::int32, 1, {1, 2}});
  mesh.cell_fields.push_back({"Materials of blocks", ScalarType::int32, 1, {1, 2}});
  mesh.point_fields[0].name = "RegionId";
  const TetrahedraOutcome outcome = tetrahedra_of(mesh);
  EXPECT_EQ(outcome.mesh.region_ids, (std::vector<std::int64_t>{-2, 7}));
  EXPECT_EQ(outcome.report.regions_not_taken,
            (std::vector<std::string>{"Material_Ids (0.5, which is no whole number)",
                                      "BlockId (2 components)", "zone_id (MATERIALID is taken)",
                                      "RegionId (of points)"}));
}

TEST(tetra_regions, are_named_by_option) {
  const TetraMesh mesh = tetrahedra_of(field_mesh(), {.region_field = "zones"}).mesh;
  EXPECT_EQ(mesh.region_ids, (std::vector<std::int64_t>{1}));
  EXPECT_TRUE(mesh.regions.empty());
  expect_no_tetrahedra(field_mesh(), {"'rooms'"}, {.region_field = "rooms"});
  CellMesh broken = field_mesh();
  broken.cell_fields[2].values[1] = 0.5;
  expect_no_tetrahedra(broken, {"whole numbers", "got 0.5"}, {.region_field = "zones"});
}

TEST(tetra_orientation, is_exact_where_double_is_not) {
  oracles::Random random(7);
  const auto coordinate = [&] {
    return static_cast<double>(static_cast<float>(random.uniform(-70, 70)));
  };
  for (int i = 0; i < 2000; ++i) {
    const Vec3d a{{coordinate(), coordinate(), coordinate()}};
    const Vec3d b{{coordinate(), coordinate(), coordinate()}};
    const Vec3d c{{coordinate(), coordinate(), coordinate()}};
    // Two corners at one place, in any order; and a corner in the middle of an edge.
    EXPECT_EQ(orientation(a, b, c, c), 0);
    EXPECT_EQ(orientation(b, a, c, b), 0);
    EXPECT_EQ(orientation(a, b, c, (b + c) * 0.5), 0);
    // Off the plane by less than the products' rounding.
    Vec3d off = (b + c) * 0.5;
    const Vec3d normal = cross(b - a, c - a);
    off[0] = std::nextafter(off[0], off[0] + normal[0]);
    if (off[0] != (b[0] + c[0]) * 0.5) EXPECT_EQ(orientation(a, b, c, off), 1);
    if (off[0] != (b[0] + c[0]) * 0.5) EXPECT_EQ(orientation(b, a, c, off), -1);
  }
}

TEST(tetra_fields, of_cells_say_where_other_regions_have_a_share_in_them) {
  const TetrahedraOutcome outcome = tetrahedra_of(field_mesh(), {.fields = {"p"}});
  const AveragedField& p = outcome.report.averaged.at(0);
  // -1 at the points that both share; region -2 has a cell of -4, region 7 one of 8.
  ASSERT_EQ(p.regions.size(), 2U);
  EXPECT_EQ(p.regions[0].id, -2);
  EXPECT_EQ(p.regions[0].cell_min, -4);
  EXPECT_EQ(p.regions[0].cell_max, -4);
  EXPECT_EQ(p.regions[0].point_min, -4);
  EXPECT_NEAR(p.regions[0].point_max, -1, 1e-14);
  EXPECT_EQ(p.regions[1].id, 7);
  EXPECT_EQ(p.regions[1].cell_min, 8);
  EXPECT_NEAR(p.regions[1].point_min, -1, 1e-14);
  CellMesh apart = field_mesh();
  apart.cell_fields[1].values = {7, 7};
  EXPECT_TRUE(tetrahedra_of(apart, {.fields = {"p"}}).report.averaged.at(0).regions.empty());
}

TEST(tetra_fields, of_cells_have_no_mean_beyond_what_they_are_means_of) {
  oracles::Random random(5);
  CellMesh mesh = field_mesh();
  mesh.cell_fields[0].values = {0.1, 0.1};
  for (int i = 0; i < 200; ++i) {
    for (Vec3d& p : mesh.points)
      for (double& x : p.v) x += random.uniform(-1e-3, 1e-3);
    const TetraMesh made = tetrahedra_of(mesh, {.fields = {"p"}}).mesh;
    for (const double value : made.fields[0].values) ASSERT_EQ(value, 0.1);
  }
}

TEST(tetra_fields, of_tensors_have_von_mises_scalar) {
  CellMesh mesh = field_mesh();
  // Simple tension, pure shear, the same in all directions, and one of no symmetry.
  mesh.point_fields = {{"S", ScalarType::float64, 6, {}}, {"T", ScalarType::float64, 9, {}}};
  const std::vector<std::array<double, 6>> tensors = {{5, 0, 0, 0, 0, 0},
                                                      {0, 0, 0, 2, 0, 0},
                                                      {3, 3, 3, 0, 0, 0},
                                                      {1, 2, 4, 3, 5, 6},
                                                      {0, 0, -7, 0, 0, 0}};
  for (const auto& [xx, yy, zz, xy, yz, xz] : tensors) {
    for (const double c : {xx, yy, zz, xy, yz, xz}) mesh.point_fields[0].values.push_back(c);
    for (const double c : {xx, xy + 1, xz, xy - 1, yy, yz, xz, yz, zz})
      mesh.point_fields[1].values.push_back(c);
  }
  const double root3 = std::sqrt(3.0);
  const std::vector<double> expected = {5, 2 * root3, 0, std::sqrt(7 + 3.0 * (9 + 25 + 36)), 7};
  for (const char* name : {"S:mises", "T:mises"}) {
    const TetraMesh made = tetrahedra_of(mesh, {.fields = {name}}).mesh;
    EXPECT_EQ(made.fields[0].name, name);
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(made.fields[0].values[i], expected[i], 1e-14);
  }
  expect_no_tetrahedra(field_mesh(), {"6 or 9 components", "'v:mises'", "got 3"},
                       {.fields = {"v:mises"}});
}

TEST(tetra_fields, of_all_kinds_are_measured_ones_of_cells_too) {
  const TetraMesh made = tetrahedra_of(field_mesh(), {.fields = {"t"}, .has_all = true}).mesh;
  EXPECT_EQ(names_of(made),
            (std::vector<std::string>{"t", "v:0", "v:1", "v:2", "a:1", "p", "zones"}));
}

TEST(tetra_regions, of_which_one_is_wanted_leave_out_the_cells_of_others) {
  CellMesh mesh = field_mesh();
  test::add_cell(mesh, CellType::triangle, {0, 1, 2});
  mesh.cell_fields[0].values.push_back(std::nan(""));
  mesh.cell_fields[1].values.push_back(5);
  mesh.cell_fields[2].values.push_back(1);
  const TetrahedraOutcome outcome = tetrahedra_of(mesh, {.fields = {"p"}, .only_regions = {"-2"}});
  EXPECT_EQ(outcome.report.n_other_regions, 1U);
  EXPECT_EQ(outcome.report.n_cells, 1U);
  EXPECT_EQ(outcome.mesh.tetrahedra.size(), 1U);
  EXPECT_EQ(outcome.mesh.fields[0].values, (std::vector<double>{-4, -4, -4, -4}));
  EXPECT_EQ(outcome.mesh.region_ids, std::vector<std::int64_t>{-2});
  // What was between two regions is the boundary now, and has its patch.
  EXPECT_EQ(outcome.report.n_patch_cells, 1U);
  EXPECT_EQ(tetrahedra_of(mesh, {.fields = {"p"}, .only_regions = {"7", "-2"}}).report.n_cells, 2U);
  expect_no_tetrahedra(mesh, {"one of its regions (-2, 7)", "'8'"}, {.only_regions = {"8"}});
  mesh.cell_fields.resize(1);
  expect_no_tetrahedra(mesh, {"cells with regions"}, {.only_regions = {"8"}});
}

TEST(tetra_fields, of_cells_of_some_regions_say_which_lack_values) {
  CellMesh mesh = field_mesh();
  mesh.cell_fields[0].values[1] = std::nan("");
  const AveragedField p = tetrahedra_of(mesh, {.fields = {"p"}}).report.averaged.at(0);
  EXPECT_EQ(p.nonfinite_regions, std::vector<std::int64_t>{-2});
  EXPECT_EQ(p.finite_regions, std::vector<std::int64_t>{7});
  EXPECT_TRUE(
      tetrahedra_of(mesh, {.fields = {"p"}, .only_regions = {"7"}}).report.nonfinite.empty());
  mesh.cell_fields[0].values[0] = std::nan("");
  EXPECT_TRUE(
      tetrahedra_of(mesh, {.fields = {"p"}}).report.averaged.at(0).nonfinite_regions.empty());
}

}  // namespace
}  // namespace lode::io
