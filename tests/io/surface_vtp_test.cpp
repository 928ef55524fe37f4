#include <gtest/gtest.h>

#include "tests/io/surface_fixtures.h"

namespace lode::io {
namespace {

/// An ASCII file of three points; `root` adds attributes, `cells` what follows the points.
std::string ascii_vtp(std::string_view counts, std::string_view cells,
                      std::string_view points = "0 0 0  1 0 0  0 1 0", std::string_view root = "") {
  return fmt::format(
      R"(<VTKFile type="PolyData" {}><PolyData><Piece NumberOfPoints="3" {}><Points>)"
      R"(<DataArray type="Float32" NumberOfComponents="3" format="ascii">{}</DataArray>)"
      R"(</Points>{}</Piece></PolyData></VTKFile>)",
      root, counts, points, cells);
}

std::string polygons(std::string_view connectivity, std::string_view offsets) {
  return fmt::format(
      R"(<Polys><DataArray type="Int64" Name="connectivity" format="ascii">{}</DataArray>)"
      R"(<DataArray type="Int64" Name="offsets" format="ascii">{}</DataArray></Polys>)",
      connectivity, offsets);
}

constexpr std::string_view kOne = R"(NumberOfPolys="1")";

TEST(vtp_file, reads_ascii_polygons_as_fans) {
  const Result<Surface> read =
      read_bytes(".vtp", ascii_vtp(R"(NumberOfPolys="2")", polygons("0 1 2 0 2 1 0", "3 7")));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read.value().triangles.size(), 3U);
  EXPECT_EQ(read.value().triangles[1], (std::array<std::uint32_t, 3>{0, 2, 1}));
}

TEST(vtp_file, refuses_wrong_counts_offsets_and_indices) {
  EXPECT_EQ(complaint_about(".vtp", ascii_vtp(kOne, polygons("0 1 2", "3"))), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(kOne, polygons("0 1 3", "3"))), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(kOne, polygons("0 1 -2", "3"))), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(kOne, polygons("0 1 2", "4"))), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(kOne, polygons("0 1 2", "2"))), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(R"(NumberOfPolys="2")", polygons("0 1 2", "3 2"))),
            "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(R"(NumberOfPolys="99999999999999")", "")), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(kOne, "")), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp("", "", "0 0 0 1 1 1")), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp("", "", "0 0 0 1 1 1 2 2 two")), "");
  EXPECT_NE(complaint_about(".vtp", ascii_vtp(R"(NumberOfStrips="1")", "")), "");
}

TEST(vtp_file, names_a_compressor_it_lacks) {
  const std::string text =
      ascii_vtp("", "", "0 0 0 1 1 1 2 2 2", R"(compressor="vtkLZ4DataCompressor")");
  EXPECT_NE(complaint_about(".vtp", text).find("vtkLZ4DataCompressor"), std::string::npos);
}

TEST(vtp_file, refuses_arrays_that_announce_more_than_the_file) {
  // 32-bit headers in base64: 0xffffffff bytes plain; 0xffffffff blocks, or one block of 4 GB.
  for (const auto& [compressor, data] :
       {std::pair{"", "/////w=="}, std::pair{"vtkZLibDataCompressor", "/////wAAAAAAAAAA"},
        std::pair{"vtkZLibDataCompressor", "AQAAAP////8AAAAACAAAAA=="}}) {
    const std::string text = fmt::format(
        R"(<VTKFile type="PolyData" compressor="{}"><PolyData><Piece NumberOfPoints="3"><Points>)"
        R"(<DataArray type="Float32" NumberOfComponents="3" format="binary">{}</DataArray>)"
        R"(</Points></Piece></PolyData></VTKFile>)",
        compressor, data);
    EXPECT_NE(complaint_about(".vtp", text), "");
  }
}

TEST(vtp_file, keeps_its_comment_from_breaking_the_xml) {
  const std::string path = temporary_path("comment.vtp");
  expect_written(path, make_torus(4), {.comment = "--x--> <AppendedData _ ---"});
  const std::string bytes = bytes_of(path);
  EXPECT_EQ(bytes.find("<AppendedData"), bytes.find("<AppendedData encoding=\"raw\">"));
  EXPECT_TRUE(read_surface(path));
}

}  // namespace
}  // namespace lode::io
