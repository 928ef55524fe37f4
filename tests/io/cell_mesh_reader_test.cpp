#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/io/cell_mesh_files.h"

namespace lode::io {
namespace {

using test::TempDir;
using test::XmlForm;

std::string name_of_form(const testing::TestParamInfo<XmlForm>& form) { return form.param.name; }

class xml_meshes : public testing::TestWithParam<XmlForm> {};

TEST_P(xml_meshes, come_back_as_written) {
  const TempDir directory;
  const CellMesh mesh = test::varied_mesh();
  test::expect_same_mesh(
      test::read_mesh(directory.write("mesh.vtu", test::vtu_of({mesh}, GetParam()))), mesh);
}

TEST_P(xml_meshes, of_several_pieces_are_joined) {
  const TempDir directory;
  const CellMesh mesh = test::varied_mesh();
  const CellMesh joined = test::read_mesh(
      directory.write("pieces.vtu", test::vtu_of({mesh, test::empty_cells(), mesh}, GetParam())));
  const std::size_t n = mesh.n_cells();
  ASSERT_EQ(joined.n_cells(), 2 * n);
  ASSERT_EQ(joined.points.size(), 2 * mesh.points.size());
  for (std::size_t cell = 0; cell < n; ++cell) {
    EXPECT_EQ(joined.types[n + cell], mesh.types[cell]);
    std::vector<std::uint32_t> moved;
    for (const std::uint32_t corner : mesh.corners_of(cell)) moved.push_back(corner + 24);
    EXPECT_TRUE(std::ranges::equal(joined.corners_of(n + cell), moved));
    EXPECT_TRUE(std::ranges::equal(joined.faces_of(cell), mesh.faces_of(cell)));
    EXPECT_EQ(joined.faces_of(n + cell).size(), mesh.faces_of(cell).size());
    EXPECT_EQ(joined.cell_fields[3].at(n + cell), mesh.cell_fields[3].at(cell));
  }
  EXPECT_EQ(joined.faces_of(n + 2)[1], 24U);
  EXPECT_EQ(joined.point_fields[4].at(24 + 5, 1), mesh.point_fields[4].at(5, 1));
}

TEST_P(xml_meshes, have_a_time) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  const std::string path = directory.write("mesh.vtu", test::vtu_of({mesh}, GetParam()));
  EXPECT_EQ(test::read_mesh(path).time, std::nullopt);
  mesh.time = -0.1;
  mesh.region_names = {{3, "steel"}};
  directory.write("mesh.vtu", test::vtu_of({mesh}, GetParam()));
  EXPECT_EQ(test::read_mesh(path).time, mesh.time);
  EXPECT_TRUE(test::read_mesh(path).times.empty());
}

TEST_P(xml_meshes, have_names_of_patches_and_regions) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  mesh.patch_names = {{5, "in let \xC3\xA9"}, {-7, ""}, {8, std::string(300, 'x')}};
  mesh.region_names = {{3, "steel"}, {-1, "\xFF"}};
  const CellMesh read =
      test::read_mesh(directory.write("mesh.vtu", test::vtu_of({mesh}, GetParam())));
  EXPECT_EQ(read.patch_names, mesh.patch_names);
  EXPECT_EQ(read.region_names, mesh.region_names);
}

INSTANTIATE_TEST_SUITE_P(forms, xml_meshes, testing::ValuesIn(test::xml_forms()), name_of_form);

class legacy_meshes : public testing::TestWithParam<test::LegacyForm> {};

TEST_P(legacy_meshes, have_a_time) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  for (const std::optional<double> time : {std::optional<double>(), std::optional(2.75)}) {
    mesh.time = time;
    EXPECT_EQ(test::read_mesh(directory.write("mesh.vtk", test::legacy_of(mesh, GetParam()))).time,
              time);
  }
}

TEST_P(legacy_meshes, come_back_as_written) {
  const TempDir directory;
  const CellMesh mesh = test::varied_mesh();
  test::expect_same_mesh(
      test::read_mesh(directory.write("mesh.vtk", test::legacy_of(mesh, GetParam()))), mesh);
}

INSTANTIATE_TEST_SUITE_P(forms, legacy_meshes,
                         testing::Values(test::LegacyForm::ascii_counts,
                                         test::LegacyForm::binary_counts,
                                         test::LegacyForm::ascii_offsets,
                                         test::LegacyForm::binary_offsets));

/// Points of a grid nx x ny x nz from a first one, with fields that say where they are.
CellMesh grid_content(std::array<int, 3> first, std::array<int, 3> n) {
  CellMesh mesh;
  mesh.point_fields = {{"place", ScalarType::int32, 1, {}}};
  mesh.cell_fields = {{"cell", ScalarType::int32, 1, {}}};
  for (int z = first[2]; z < first[2] + n[2]; ++z)
    for (int y = first[1]; y < first[1] + n[1]; ++y)
      for (int x = first[0]; x < first[0] + n[0]; ++x) {
        mesh.points.push_back({{x * 1.5, y * 1.0, z * 0.1}});
        mesh.point_fields[0].values.push_back(100 * z + 10 * y + x);
        const bool is_cell =
            x + 1 < first[0] + n[0] && y + 1 < first[1] + n[1] && z + 1 < first[2] + n[2];
        if (is_cell) mesh.cell_fields[0].values.push_back(100 * z + 10 * y + x);
      }
  return mesh;
}

class xml_grids : public testing::TestWithParam<XmlForm> {};

TEST_P(xml_grids, become_hexahedra) {
  const TempDir directory;
  const CellMesh content = grid_content({0, 0, 0}, {3, 4, 2});
  const CellMesh mesh = test::read_mesh(directory.write(
      "grid.vts", test::vts_of("0 2 0 3 0 1", {{"0 2 0 3 0 1", content}}, GetParam())));
  ASSERT_EQ(mesh.n_cells(), 2U * 3U);
  EXPECT_EQ(mesh.points, content.points);
  EXPECT_FALSE(mesh.has_narrow_points);
  EXPECT_EQ(mesh.point_fields[0].values, content.point_fields[0].values);
  EXPECT_EQ(mesh.cell_fields[0].values, content.cell_fields[0].values);
  const std::vector<std::uint32_t> last = {7, 8, 11, 10, 19, 20, 23, 22};
  EXPECT_TRUE(std::ranges::equal(mesh.corners_of(5), last));
}

INSTANTIATE_TEST_SUITE_P(forms, xml_grids, testing::ValuesIn(test::xml_forms()), name_of_form);

TEST(xml_grid, of_several_pieces_is_joined_without_ghosts) {
  const TempDir directory;
  CellMesh left = grid_content({0, 0, 0}, {4, 3, 2});
  CellMesh right = grid_content({2, 0, 0}, {3, 3, 2});
  // The left piece has a column of the right one's cells, with values that are not to be seen.
  left.cell_fields.push_back({"vtkGhostType", ScalarType::uint8, 1, {0, 0, 1, 0, 0, 1}});
  left.cell_fields[0].values[2] = -1;
  left.cell_fields[0].values[5] = -1;
  right.cell_fields.push_back({"vtkGhostType", ScalarType::uint8, 1, {0, 0, 0, 32}});
  const CellMesh mesh = test::read_mesh(directory.write(
      "pieces.vts", test::vts_of("0 4 0 2 0 1", {{"0 3 0 2 0 1", left}, {"2 4 0 2 0 1", right}})));
  EXPECT_EQ(mesh.points, grid_content({0, 0, 0}, {5, 3, 2}).points);
  EXPECT_EQ(mesh.cell_fields[0].values, (std::vector<double>{0, 1, 2, 3, 10, 11, 12}));
  EXPECT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_EQ(mesh.n_ghost_cells, 0U);
  EXPECT_EQ(mesh.n_hidden_cells, 1U);
}

TEST(xml_grid, leaves_out_the_cells_of_hidden_points) {
  const TempDir directory;
  CellMesh content = grid_content({0, 0, 0}, {3, 3, 2});
  MeshField hidden{"vtkGhostType", ScalarType::uint8, 1, std::vector<double>(18, 0)};
  hidden.values[2] = 2;   // A corner of the grid, of one cell.
  hidden.values[17] = 1;  // Another piece's, which says nothing.
  content.point_fields.push_back(hidden);
  const CellMesh mesh = test::read_mesh(
      directory.write("hidden.vts", test::vts_of("0 2 0 2 0 1", {{"0 2 0 2 0 1", content}})));
  EXPECT_EQ(mesh.cell_fields[0].values, (std::vector<double>{0, 10, 11}));
  EXPECT_EQ(mesh.n_hidden_cells, 1U);
  EXPECT_EQ(mesh.point_fields.size(), 1U);
}

TEST(xml_mesh, leaves_out_ghost_and_hidden_cells) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  MeshField ghosts{"vtkGhostType", ScalarType::uint8, 1, std::vector<double>(10, 0)};
  ghosts.values[0] = 1;
  ghosts.values[2] = 33;
  ghosts.values[3] = 32;
  ghosts.values[5] = 16;  // Exterior: stays.
  mesh.cell_fields.push_back(ghosts);
  const CellMesh kept = test::read_mesh(directory.write("ghosts.vtu", test::vtu_of({mesh})));
  EXPECT_EQ(kept.n_ghost_cells, 2U);
  EXPECT_EQ(kept.n_hidden_cells, 1U);
  ASSERT_EQ(kept.n_cells(), 7U);
  const std::vector<std::size_t> stay = {1, 4, 5, 6, 7, 8, 9};
  for (std::size_t i = 0; i < stay.size(); ++i) {
    EXPECT_EQ(kept.types[i], mesh.types[stay[i]]);
    EXPECT_TRUE(std::ranges::equal(kept.corners_of(i), mesh.corners_of(stay[i])));
    EXPECT_TRUE(std::ranges::equal(kept.faces_of(i), mesh.faces_of(stay[i])));
    EXPECT_EQ(kept.cell_fields[0].at(i), mesh.cell_fields[0].at(stay[i]));
  }
  EXPECT_EQ(kept.cell_fields.size(), 10U);
}

TEST(xml_mesh, has_names_of_patches_whose_characters_have_signs) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  mesh.patch_names = {{5, "\xC3\xA9"}};
  std::string text = test::vtu_of({mesh});
  const std::size_t codes = text.find("195 169");
  ASSERT_NE(codes, std::string::npos);
  text.replace(codes, 7, "-61 -87");
  EXPECT_EQ(test::read_mesh(directory.write("mesh.vtu", text)).patch_names, mesh.patch_names);
}

TEST(xml_mesh, with_broken_names_of_patches_is_refused) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  mesh.patch_names = {{5, "inlet"}};
  for (const XmlForm& form : test::xml_forms()) {
    if (form.format != "appended") continue;
    std::string text = test::vtu_of({mesh}, form);
    const std::size_t offset = text.find("offset=\"", text.find("PatchNames")) + 8;
    text.replace(offset, text.find('"', offset) - offset, "7");
    test::expect_mesh_failure(directory.write("mesh.vtu", text), {});
  }
}

TEST(xml_mesh, has_a_time_of_one_finite_number) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  mesh.time = 0.5;
  const std::string text = test::vtu_of({mesh});
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    const std::size_t at = changed.find(from, changed.find("<FieldData>"));
    EXPECT_NE(at, std::string::npos);
    return directory.write("mesh.vtu", changed.replace(at, from.size(), to));
  };
  const std::string name = "Name=\"TimeValue\"";
  // Of several, and of vectors, none is the time.
  EXPECT_EQ(test::read_mesh(with(name, name + " NumberOfTuples=\"2\"")).time, std::nullopt);
  EXPECT_EQ(test::read_mesh(with(name, name + " NumberOfTuples=\"4294967297\"")).time,
            std::nullopt);
  EXPECT_EQ(test::read_mesh(with("NumberOfComponents=\"1\"", "NumberOfComponents=\"3\"")).time,
            std::nullopt);
  test::expect_mesh_failure(with("0.5", "nan"), {"a finite TimeValue"});
  test::expect_mesh_failure(with("0.5", "soon"), {});
}

TEST(xml_mesh, says_where_names_are_not_as_many_as_numbers) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  mesh.region_names = {{5, "steel"}, {6, "air"}};
  for (const char* const n : {"1", "3", "4294967296", "18446744073709551615", "-1", "many"}) {
    std::string text = test::vtu_of({mesh});
    const std::size_t at = text.find("NumberOfTuples=\"2\"");
    ASSERT_NE(at, std::string::npos);
    text.replace(at, 18, fmt::format("NumberOfTuples=\"{}\"", n));
    const CellMesh read = test::read_mesh(directory.write("mesh.vtu", text));
    EXPECT_TRUE(read.region_names.empty());
    ASSERT_FALSE(read.skipped_arrays.empty());
    EXPECT_TRUE(read.skipped_arrays.back().starts_with("RegionNames (2 for "));
  }
}

TEST(unstructured_mesh, leaves_out_the_cells_of_hidden_points) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  MeshField hidden{"vtkGhostType", ScalarType::uint8, 1,
                   std::vector<double>(mesh.points.size(), 1)};
  const std::uint32_t corner = mesh.corners_of(3).front();
  hidden.values[corner] = 3;
  mesh.point_fields.push_back(hidden);
  std::uint64_t n_hidden = 0;
  for (std::size_t cell = 0; cell < mesh.n_cells(); ++cell)
    n_hidden += static_cast<std::uint64_t>(std::ranges::count(mesh.corners_of(cell), corner));
  ASSERT_GT(n_hidden, 0U);
  for (const std::string& path :
       {directory.write("hidden.vtu", test::vtu_of({mesh})),
        directory.write("hidden.vtk", test::legacy_of(mesh, test::LegacyForm::binary_offsets))}) {
    const CellMesh kept = test::read_mesh(path);
    EXPECT_EQ(kept.n_hidden_cells, n_hidden);
    EXPECT_EQ(kept.n_cells(), mesh.n_cells() - n_hidden);
    EXPECT_EQ(kept.n_ghost_cells, 0U);
    EXPECT_EQ(kept.point_fields.size(), mesh.point_fields.size() - 1);
  }
}

std::string legacy_grid(const std::string& data) {
  return "# vtk DataFile Version 2.0\ngrid\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 2 2 3\n"
         "POINTS 12 float\n0 0 0 1 0 0 0 1 0 1 1 0\n0 0 1 1 0 1 0 1 1 1 1 1\n"
         "0 0 2 1 0 2 0 1 2 1 1 2\n" +
         data;
}

TEST(legacy_grid, becomes_hexahedra_with_fields_of_points_and_cells) {
  const TempDir directory;
  const CellMesh mesh = test::read_mesh(directory.write(
      "grid.vtk",
      legacy_grid("POINT_DATA 12\nSCALARS t float 1\nLOOKUP_TABLE default\n"
                  "0 1 2 3 4 5 6 7 8 9 10 11\nCELL_DATA 2\nVECTORS v double\n1 2 3 4 5 6.5\n")));
  ASSERT_EQ(mesh.n_cells(), 2U);
  const std::vector<std::uint32_t> upper = {4, 5, 7, 6, 8, 9, 11, 10};
  EXPECT_TRUE(std::ranges::equal(mesh.corners_of(1), upper));
  EXPECT_EQ(mesh.point_fields[0].at(11), 11);
  EXPECT_EQ(mesh.cell_fields[0].at(1, 2), 6.5);
  EXPECT_TRUE(mesh.has_narrow_points);
}

TEST(cell_mesh, is_recognised_by_content_under_any_known_extension) {
  const TempDir directory;
  const CellMesh mesh = test::varied_mesh();
  test::expect_same_mesh(test::read_mesh(directory.write("xml.vtk", test::vtu_of({mesh}))), mesh);
  test::expect_mesh_failure(directory.write("mesh.xyz", test::vtu_of({mesh})), {".vtu", ".xyz"});
  test::expect_mesh_failure(directory.write("text.vtu", "nothing of that kind"), {"expected"});
  test::expect_mesh_failure(directory.path("absent.vtu"), {});
}

TEST(cell_mesh, stays_within_the_memory_limit) {
  const TempDir directory;
  const std::string path = directory.write("mesh.vtu", test::vtu_of({test::varied_mesh()}));
  const Result<CellMesh> mesh = read_cell_mesh(path, {.memory_limit = 1000});
  ASSERT_FALSE(mesh);
  EXPECT_NE(mesh.error().message.find("memory limit"), std::string::npos) << mesh.error().message;
}

}  // namespace
}  // namespace lode::io
