#include <gtest/gtest.h>

#include <string>

#include "tests/io/cell_mesh_files.h"
#include "tests/io/tetra_checks.h"

namespace lode::io {
namespace {

using test::TempDir;

using Names = std::vector<std::string>;

/// A tetrahedron of which VTK 9.1 writes arrays of texts, bits and variants as here.
const std::string kAsciiArrays =
    "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET UNSTRUCTURED_GRID\n"
    "FIELD FieldData 1\nnotes 1 2 string\n\nPOINTS%209%20float\n"
    "POINTS 4 float\n0 0 0 1 0 0 0 1 0 \n0 0 1 \n"
    "METADATA\nCOMPONENT_NAMES\n\n\nzz\nINFORMATION 1\nNAME k3 LOCATION loc\nDATA 1.5\n\n"
    "CELLS 2 4\nOFFSETS vtktypeint64\n0 4 \nCONNECTIVITY vtktypeint64\n0 1 2 3 \n"
    "CELL_TYPES 1\n10\n\n"
    "CELL_DATA 1\nPEDIGREE_IDS pedigree string\nid%200\n\n"
    "FIELD FieldData 1\ncell 1 1 int\n7 \n"
    "POINT_DATA 4\nSCALARS flags bit\nLOOKUP_TABLE default\n0 1 0 1 \n"
    "FIELD FieldData 5\nnames 1 4 string\n\na%20b\n" +
    std::string(100'000, 'x') +
    "\n#%20%C3%A9\n\n"
    "bits 3 4 bit\n0 1 0 1 0 1 0 1 0 \n0 0 0 \n"
    "pair 2 4 int\n0 1 1 2 2 3 3 4 \n"
    "METADATA\nINFORMATION 3\nNAME UNITS_LABEL LOCATION vtkDataArray\nDATA \n"
    "NAME k LOCATION loc\nDATA 2\n\na%20b\n"
    "NAME k2 LOCATION loc\nDATA 2 4 5 \nCOMPONENT_NAMES\none\n\n\n"
    "any 1 4 variant\n6 3\n13 a%20b\n13 \n11 2.5\n"
    "last 1 4 double\n0 0.5 1 1.5 \n";

std::string binary_arrays() {
  const auto numbers = [](ScalarType type, const std::vector<double>& values) {
    return test::typed_bytes(type, values, ByteOrder::big);
  };
  const std::string bytes_of_bits(1, '\x50');
  return "# vtk DataFile Version 5.1\nvtk output\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
         "POINTS 4 float\n" +
         numbers(ScalarType::float32, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         "\nCELLS 2 4\nOFFSETS vtktypeint64\n" + numbers(ScalarType::int64, {0, 4}) +
         "\nCONNECTIVITY vtktypeint64\n" + numbers(ScalarType::int64, {0, 1, 2, 3}) +
         "\nCELL_TYPES 1\n" + numbers(ScalarType::int32, {10}) +
         "\nCELL_DATA 1\nPEDIGREE_IDS pedigree string\n\xC4id 0\nFIELD FieldData 1\ncell 1 1 "
         "int\n" +
         numbers(ScalarType::int32, {7}) +
         "\nPOINT_DATA 4\nSCALARS flags bit\nLOOKUP_TABLE default\n" + bytes_of_bits +
         "\nFIELD FieldData 5\nnames 1 4 string\n\xC0\xC3\n\n\n\x80\x64" + std::string(100, 'x') +
         std::string("\x40\x00\x4E\x20", 4) + std::string(20000, '\n') + "\nbits 3 4 bit\n" +
         "\x55\x40\npair 2 4 int\n" + numbers(ScalarType::int32, {0, 1, 1, 2, 2, 3, 3, 4}) +
         "\nMETADATA\nCOMPONENT_NAMES\none\n\n\nany 1 4 variant\n6 3\n13 a%20b\n13 \n11 2.5\n" +
         "last 1 4 double\n" + numbers(ScalarType::float64, {0, 0.5, 1, 1.5}) + "\n";
}

void expect_numbers_alone(const CellMesh& mesh) {
  ASSERT_EQ(mesh.point_fields.size(), 2U);
  EXPECT_EQ(mesh.point_fields[0].name, "pair");
  EXPECT_EQ(mesh.point_fields[0].values, (std::vector<double>{0, 1, 1, 2, 2, 3, 3, 4}));
  EXPECT_EQ(mesh.point_fields[1].name, "last");
  EXPECT_EQ(mesh.point_fields[1].values, (std::vector<double>{0, 0.5, 1, 1.5}));
  ASSERT_EQ(mesh.cell_fields.size(), 1U);
  EXPECT_EQ(mesh.cell_fields[0].values, (std::vector<double>{7}));
  EXPECT_EQ(mesh.skipped_arrays, (Names{"pedigree", "flags", "names", "bits", "any"}));
}

TEST(legacy_arrays, of_texts_and_bits_are_passed_over_and_named) {
  const TempDir directory;
  expect_numbers_alone(test::read_mesh(directory.write("ascii.vtk", kAsciiArrays)));
  const CellMesh mesh = test::read_mesh(directory.write("binary.vtk", binary_arrays()));
  expect_numbers_alone(mesh);
  EXPECT_EQ(test::tetrahedra_of(mesh, {.fields = {"last"}}).report.skipped_arrays,
            mesh.skipped_arrays);
}

TEST(legacy_arrays, of_texts_that_end_early_are_refused) {
  const TempDir directory;
  const std::string ascii = kAsciiArrays.substr(0, kAsciiArrays.find("bits 3") - 20);
  test::expect_mesh_failure(directory.write("ascii.vtk", ascii), {"4 lines", "names", "got"});
  const std::string binary = binary_arrays();
  for (const char* const after : {"\x80\x64", "\x40", "x\x40"}) {
    const std::size_t end = binary.find(after, binary.find("names")) + std::string(after).size();
    test::expect_mesh_failure(directory.write("binary.vtk", binary.substr(0, end)), {});
  }
}

TEST(legacy_arrays, whose_metadata_end_early_are_refused) {
  const TempDir directory;
  std::string text = kAsciiArrays;
  text.replace(text.find("INFORMATION 3"), 13, "INFORMATION 4");
  test::expect_mesh_failure(directory.write("ascii.vtk", text), {"1 more keys in METADATA"});
}

TEST(xml_arrays, of_texts_and_bits_are_passed_over_and_named) {
  const TempDir directory;
  std::string text = test::vtu_of({test::varied_mesh(), test::varied_mesh()});
  const std::string others =
      "<PointData>\n<Array type=\"String\" Name=\"names\" format=\"ascii\">97 0</Array>\n"
      "<DataArray type=\"Bit\" Name=\"bits\" format=\"ascii\">0 1</DataArray>\n";
  for (std::size_t at = text.find("<PointData>"); at != std::string::npos;
       at = text.find("<PointData>", at + others.size()))
    text.replace(at, std::string("<PointData>").size(), others);
  const CellMesh mesh = test::read_mesh(directory.write("mesh.vtu", text));
  EXPECT_EQ(mesh.skipped_arrays, (Names{"names", "bits"}));
  EXPECT_EQ(mesh.point_fields.size(), test::varied_mesh().point_fields.size());
}

}  // namespace
}  // namespace lode::io
