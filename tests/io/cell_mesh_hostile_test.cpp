#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::TempDir;
using test::XmlForm;

/// What becomes of a file: an error that names it, or a mesh whose corners are points, of which
/// tetrahedra are made or not.
void expect_survived(const std::string& path) {
  Result<CellMesh> mesh = read_cell_mesh(path, {});
  if (!mesh) {
    EXPECT_NE(mesh.error().message.find(path), std::string::npos) << mesh.error().message;
    return;
  }
  for (const std::uint32_t corner : mesh->corners) ASSERT_LT(corner, mesh->points.size());
  const Result<TetrahedraOutcome> outcome =
      to_tetrahedra(std::move(*mesh), {.weld_distance = 0, .weld_values = 1});
  if (!outcome) return;
  for (const auto& tetrahedron : outcome->mesh.tetrahedra)
    for (const std::uint32_t corner : tetrahedron)
      ASSERT_LT(corner, outcome->mesh.positions.size());
}

/// A hexahedron between a polyhedron and a wedge, of which tetrahedra can be made.
CellMesh splittable_mesh() {
  CellMesh mesh = test::empty_cells();
  for (int i = 0; i < 12; ++i)
    mesh.points.push_back({{1.0 * (i / 4), 1.0 * (i % 2), 1.0 * (i / 2 % 2)}});
  mesh.points.push_back({{3, 0, 0}});
  mesh.points.push_back({{3, 1, 0}});
  test::add_cell(mesh, CellType::hexahedron, {0, 4, 5, 1, 2, 6, 7, 3});
  test::add_polyhedron(
      mesh,
      {{4, 5, 7, 6}, {8, 9, 11, 10}, {4, 8, 9, 5}, {6, 7, 11, 10}, {4, 6, 10, 8}, {5, 9, 11, 7}});
  test::add_cell(mesh, CellType::wedge, {8, 12, 10, 9, 13, 11});
  mesh.cell_fields = {{"RegionId", ScalarType::int32, 1, {1, 2, 3}},
                      {"c", ScalarType::float32, 1, {1, 2, 3}}};
  return mesh;
}

TEST(hostile_mesh, is_made_of_files_that_are_good) {
  const TetrahedraOutcome outcome = test::tetrahedra_of(splittable_mesh());
  EXPECT_EQ(outcome.report.n_components, 1U);
  EXPECT_NEAR(test::total_volume(outcome.mesh), 2.5, 1e-14);
}

std::vector<std::pair<std::string, std::string>> good_files() {
  const CellMesh mesh = test::varied_mesh();
  std::vector<std::pair<std::string, std::string>> files;
  for (const XmlForm& form : test::xml_forms())
    files.emplace_back("x.vtu", test::vtu_of({mesh, mesh}, form));
  files.emplace_back("x.vtu", test::vtu_of({splittable_mesh()}));
  files.emplace_back("x.vtk", test::legacy_of(splittable_mesh(), {}));
  CellMesh grid;
  for (int i = 0; i < 27; ++i) grid.points.push_back({{1.0 * (i % 3), 1.0 * (i / 9), 0.5 * i}});
  for (const XmlForm& form : test::xml_forms())
    files.emplace_back("x.vts", test::vts_of("0 2 0 2 0 2", {{"0 2 0 2 0 2", grid}}, form));
  for (const auto form : {test::LegacyForm::ascii_counts, test::LegacyForm::binary_counts,
                          test::LegacyForm::ascii_offsets, test::LegacyForm::binary_offsets})
    files.emplace_back("x.vtk", test::legacy_of(mesh, form));
  files.emplace_back("x.mesh",
                     "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 1\n1 0 0 1\n"
                     "0 1 0 2 # Here\n0 0 1 2\nTriangles 1\n1 2 3 5\nTetrahedra 1\n1 2 3 4 7\n");
  return files;
}

TEST(hostile_mesh, cut_anywhere_gives_an_error_or_a_valid_mesh) {
  const TempDir directory;
  for (const auto& [name, bytes] : good_files())
    for (std::size_t i = 1; i < 60; ++i)
      expect_survived(directory.write(name, bytes.substr(0, bytes.size() * i / 60)));
}

TEST(hostile_mesh, changed_at_random_gives_an_error_or_a_valid_mesh) {
  const TempDir directory;
  std::mt19937_64 random(20020611);
  for (const auto& [name, bytes] : good_files())
    for (int i = 0; i < 150; ++i)
      expect_survived(directory.write(name, test::mutated(bytes, random)));
}

/// A mesh of one tetrahedron in ASCII, of which one piece of text is another.
std::string altered(const std::string& from, const std::string& to) {
  CellMesh mesh = test::empty_cells();
  mesh.points = {{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 7}}};
  test::add_cell(mesh, CellType::tetrahedron, {0, 1, 2, 3});
  mesh.point_fields = {{"t", ScalarType::float32, 1, {1, 2, 3, 4.5}}};
  std::string text = test::vtu_of({mesh});
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// As what other programs blank.
TEST(hostile_mesh, may_have_points_anywhere_that_no_cell_has) {
  const TempDir directory;
  for (const char* number : {"nan", "inf", "1e39"}) {
    CellMesh mesh = test::empty_cells();
    mesh.points = {{{0, 0, 0}}, {{3, 5, 7}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    test::add_cell(mesh, CellType::tetrahedron, {0, 2, 3, 4});
    mesh.point_fields = {{"t", ScalarType::float32, 1, {1, 2, 3, 4, 5}}};
    std::string text = test::vtu_of({mesh});
    const std::size_t at = text.find("3 5 7");
    ASSERT_NE(at, std::string::npos);
    text.replace(at, 5, std::string("3 ") + number + " 7");
    auto read = read_cell_mesh(directory.write("x.vtu", text), {});
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_TRUE(std::isfinite(read->points[1][1]));
    const auto made = to_tetrahedra(std::move(*read), {.fields = {"t"}});
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->report.n_unused_points, 1U);
    EXPECT_EQ(made->mesh.positions.size(), 4U);
    EXPECT_EQ(made->mesh.fields[0].values, (std::vector<double>{1, 3, 4, 5}));
  }
}

TEST(hostile_mesh, in_text_is_refused_by_what_is_wrong) {
  const TempDir directory;
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::vector<std::string>& parts) {
    test::expect_mesh_failure(directory.write("x.vtu", altered(from, to)), parts);
  };
  refused(">0 1 2 3 <", ">0 1 2 4 <", {"connectivity", "got 4 at place 3"});
  refused(">0 1 2 3 <", ">0 1 -2 3 <", {"connectivity", "got -2"});
  refused(">0 1 2 3 <", ">0 1 2 <", {"4 numbers"});
  refused(">4 <", ">5 <", {"5 numbers"});
  refused(">4 <", ">3 <", {"expected 4 corners for cell 0, a tetrahedron, got 3"});
  refused(">4 <", ">4000000000000 <", {"can hold"});
  refused(">10 <", ">99 <", {"VTK's types", "got 99 for cell 0"});
  refused(">10 <", ">300 <", {"uint8"});
  refused(">10 <", ">42 <", {"faceoffsets"});
  refused("0 7 <", "0 nan <", {"finite positions", "for point 3"});
  refused("NumberOfPoints=\"4\"", "NumberOfPoints=\"99999999999999\"", {"NumberOfPoints"});
  refused("NumberOfPoints=\"4\"", "NumberOfPoints=\"4000000000\"", {"can hold"});
  refused("NumberOfCells=\"1\"", "NumberOfCells=\"4000000000\"", {"can hold"});
  refused("NumberOfCells=\"1\"", "NumberOfCells=\"-1\"", {"NumberOfCells"});
  refused("Name=\"offsets\"", "Name=\"of\"", {"offsets", "got none"});
  refused("Name=\"t\" NumberOfComponents=\"1\"", "Name=\"t\" NumberOfComponents=\"1000000000\"",
          {"can hold"});
  refused("Name=\"t\" NumberOfComponents=\"1\"", "Name=\"t\" NumberOfComponents=\"0\"",
          {"components"});
  refused("Name=\"Points\" NumberOfComponents=\"3\"", "Name=\"Points\" NumberOfComponents=\"2\"",
          {"3 components"});
  refused("<Piece ", "<Part ", {""});
}

TEST(hostile_mesh, whose_arrays_share_their_bytes_may_not_take_all_memory) {
  const TempDir directory;
  CellMesh mesh = test::empty_cells();
  mesh.points.resize(200000);
  mesh.point_fields = {{"f", ScalarType::float64, 1, std::vector<double>(200000)}};
  std::string text =
      test::vtu_of({mesh}, {"", "appended", "raw", "UInt64", ByteOrder::little, 1 << 20});
  const std::size_t begin = text.find("<DataArray");
  const std::string array = text.substr(begin, text.find("/>", begin) + 2 - begin);
  for (int i = 0; i < 1000; ++i) text.insert(begin, array);
  test::expect_mesh_failure(directory.write("x.vtu", text), {"what the file can hold"});
}

TEST(hostile_mesh, with_falling_offsets_is_refused) {
  const TempDir directory;
  CellMesh mesh = test::varied_mesh();
  std::swap(mesh.begins[3], mesh.begins[4]);
  test::expect_mesh_failure(directory.write("x.vtu", test::vtu_of({mesh})), {"rising offsets"});
}

TEST(hostile_mesh, of_polyhedra_with_wrong_faces_is_refused) {
  const TempDir directory;
  const auto refused = [&](std::size_t at, std::uint32_t number, const std::string& part) {
    CellMesh mesh = test::varied_mesh();
    mesh.faces[at] = number;
    test::expect_mesh_failure(directory.write("x.vtk", test::legacy_of(mesh, {})), {});
    mesh = test::varied_mesh();
    std::string text = test::vtu_of({mesh});
    const std::size_t place = text.find("Name=\"faces\"");
    const std::size_t first = text.find(">4 3 0 1 2 3 0 3 1 ", place);
    ASSERT_NE(first, std::string::npos);
    text[first + 1 + 2 * at + 2] = static_cast<char>('0' + number);
    test::expect_mesh_failure(directory.write("x.vtu", text), {part});
  };
  refused(0, 2, "3 corners or more");
  refused(0, 9, "3 corners or more");
}

TEST(hostile_mesh, of_grids_with_wrong_extents_is_refused) {
  const TempDir directory;
  CellMesh grid;
  for (int i = 0; i < 8; ++i) grid.points.push_back({{1.0 * (i % 2), 1.0 * (i / 4), 0.5 * i}});
  const auto refused = [&](const std::string& whole, const std::string& own,
                           const std::vector<std::string>& parts) {
    test::expect_mesh_failure(directory.write("x.vts", test::vts_of(whole, {{own, grid}})), parts);
  };
  refused("0 1 0 1 0 9", "0 1 0 1 0 1", {"cover the whole extent"});
  refused("0 30000 0 30000 0 1", "0 1 0 1 0 1", {"cover the whole extent"});
  refused("0 300000 0 300000 0 1", "0 1 0 1 0 1", {"at most"});
  refused("0 1 0 1 0 1", "1 2 0 1 0 1", {"inside the whole extent"});
  refused("0 1 0 7 0 0", "0 1 0 3 0 0", {"at least 2 points"});
  refused("0 1 0 1", "0 1 0 1 0 1", {"6 whole numbers"});
  refused("0 1 0 1 0 1", "0 1 0 1 0 2", {"36 numbers"});
}

TEST(hostile_mesh, in_legacy_form_is_refused_by_what_is_wrong) {
  const TempDir directory;
  const std::string head =
      "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
      "POINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n";
  const auto refused = [&](const std::string& rest, const std::vector<std::string>& parts) {
    test::expect_mesh_failure(directory.write("x.vtk", head + rest), parts);
  };
  refused("CELLS 1 5\n4 0 1 2 3\n", {"CELL_TYPES", "got 0"});
  refused("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n10 10\n", {"CELL_TYPES", "got 2"});
  refused("CELLS 1 5\n4 0 1 2 4\nCELL_TYPES 1\n10\n", {"corners below 4", "got 4 in cell 0"});
  refused("CELLS 1 5\n5 0 1 2 3\nCELL_TYPES 1\n10\n", {"that fit"});
  refused("CELLS 1 5\n3 0 1 2 3\nCELL_TYPES 1\n10\n", {"got 4 used"});
  refused("CELLS 1 5\n-4 0 1 2 3\nCELL_TYPES 1\n10\n", {"got -4"});
  refused("CELLS 1 9000000000000\n4 0 1 2 3\nCELL_TYPES 1\n10\n", {"CELLS"});
  refused(
      "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nPOINT_DATA 3\nSCALARS a float\n"
      "LOOKUP_TABLE default\n1 2 3\n",
      {"expected 4 values", "got 3"});
  refused("POINTS 99999999999 float\n", {"POINTS"});
  refused("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\nNONSENSE\n", {"NONSENSE"});
  test::expect_mesh_failure(
      directory.write("y.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n"),
      {"UNSTRUCTURED_GRID", "POLYDATA"});
}

}  // namespace
}  // namespace lode::io
