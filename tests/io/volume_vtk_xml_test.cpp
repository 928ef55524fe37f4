#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::base64;
using test::bytes_of;
using test::expect_failure;
using test::info_of;
using test::ramp;
using test::samples_of;
using test::TempDir;

/// A VTK XML file in parts, so that tests can break each of them.
struct XmlParts {
  std::string root = "byte_order=\"LittleEndian\" header_type=\"UInt32\"";
  std::string image = "Origin=\"0 0 0\" Spacing=\"1 1 1\"";
  std::string extent = "0 3 0 2 0 1";
  std::string arrays;
  std::string appended;

  std::string text() const {
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" " + root +
           ">\n<ImageData WholeExtent=\"" + extent + "\" " + image + ">\n<Piece Extent=\"" +
           extent + "\">\n<PointData>" + arrays + "</PointData>\n</Piece>\n</ImageData>\n" +
           appended + "\n</VTKFile>\n";
  }
};

std::string array(const std::string& type, const std::string& rest, const std::string& content) {
  return "<DataArray type=\"" + type + "\" Name=\"" + "v\" " + rest + ">" + content +
         "</DataArray>";
}

template <typename Count>
std::string counted(const std::string& bytes, ByteOrder order) {
  return bytes_of<Count>({static_cast<Count>(bytes.size())}, order) + bytes;
}

/// Header and blocks of zlib data, as VTK writes them.
template <typename Count>
std::pair<std::string, std::string> blocked(const std::string& bytes, std::size_t block,
                                            ByteOrder order) {
  std::vector<Count> header = {static_cast<Count>((bytes.size() + block - 1) / block),
                               static_cast<Count>(block), static_cast<Count>(bytes.size() % block)};
  std::string data;
  for (std::size_t i = 0; i < bytes.size(); i += block) {
    const std::string piece = test::zlibbed(bytes.substr(i, block));
    header.push_back(static_cast<Count>(piece.size()));
    data += piece;
  }
  return {bytes_of(header, order), data};
}

template <typename Count>
void expect_every_form_read(const std::string& root_start, ByteOrder order) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string raw = bytes_of(samples, order);
  const auto [header, blocks] = blocked<Count>(raw, 20, order);
  const std::string plain = counted<Count>(raw, order);
  const auto expect_read = [&](XmlParts parts, const std::string& extra) {
    parts.root = root_start + extra;
    EXPECT_EQ(samples_of<std::int16_t>(dir.write("a.vti", parts.text())), samples);
  };
  const std::string zlib = " compressor=\"vtkZLibDataCompressor\"";
  const std::string at_0 = "format=\"appended\" offset=\"0\"";
  const std::string at_7 = "format=\"appended\" offset=\"7\"";
  const std::string raw_tag = "<AppendedData encoding=\"raw\">\n  _";
  const std::string base64_tag = "<AppendedData encoding=\"base64\">_";
  const std::string end = "</AppendedData>";
  expect_read({.arrays = array("Int16", "format=\"binary\"", "\n " + base64(plain) + "\n")}, "");
  expect_read({.arrays = array("Int16", "format=\"binary\"", base64(header) + base64(blocks))},
              zlib);
  expect_read({.arrays = array("Int16", at_7, ""), .appended = raw_tag + "1234567" + plain + end},
              "");
  expect_read({.arrays = array("Int16", at_0, ""), .appended = raw_tag + header + blocks + end},
              zlib);
  expect_read({.arrays = array("Int16", at_0, ""), .appended = base64_tag + base64(plain) + end},
              "");
  expect_read({.arrays = array("Int16", at_0, ""),
               .appended = base64_tag + base64(header) + base64(blocks) + end},
              zlib);
}

TEST(vtk_xml_reader, reads_every_binary_form_in_either_byte_order) {
  expect_every_form_read<std::uint32_t>("byte_order=\"LittleEndian\"", ByteOrder::little);
  expect_every_form_read<std::uint64_t>("byte_order=\"LittleEndian\" header_type=\"UInt64\"",
                                        ByteOrder::little);
  expect_every_form_read<std::uint32_t>("byte_order=\"BigEndian\" header_type=\"UInt32\"",
                                        ByteOrder::big);
  expect_every_form_read<std::uint64_t>("byte_order=\"BigEndian\" header_type=\"UInt64\"",
                                        ByteOrder::big);
}

TEST(vtk_xml_reader, reads_text_and_refuses_numbers_out_of_range) {
  const TempDir dir;
  std::string text;
  for (int i = 0; i < 24; ++i) text += fmt::format("{} ", i * 10);
  const auto samples = samples_of<std::uint8_t>(
      dir.write("a.vti", XmlParts{.arrays = array("UInt8", "format=\"ascii\"", text)}.text()));
  ASSERT_EQ(samples.size(), 24U);
  EXPECT_EQ(samples[23], 230);
  expect_failure(
      dir.write("b.vti", XmlParts{.arrays = array("Int8", "format=\"ascii\"", text)}.text()),
      {"int8", "'130'"});
  expect_failure(dir.write("c.vti", XmlParts{.arrays = array("Int8", "", "1 2 3")}.text()),
                 {"24 numbers"});
}

TEST(vtk_xml_reader, keeps_extent_origin_spacing_and_direction) {
  const TempDir dir;
  const std::string text = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24";
  const auto path = dir.write(
      "a.vti",
      XmlParts{.image = "Origin=\"1 2 3\" Spacing=\"0.5 2 4\" Direction=\"0 -1 0 1 0 0 0 0 "
                        "1\"",
               .extent = "2 5 -1 1 0 1",
               .arrays = array("Float32", "", text)}
          .text());
  const RegularGrid grid = info_of(path).grid;
  EXPECT_EQ(grid.dims, (Index3{{4, 3, 2}}));
  EXPECT_EQ(grid.spacing, (Vec3d{{0.5, 2, 4}}));
  EXPECT_EQ(grid.origin, (Vec3d{{3, 3, 3}}));
  EXPECT_EQ(grid.to_world({{0, 1, 1}}), (Vec3d{{1, 3, 7}}));
  EXPECT_EQ(info_of(path).field_name, "v");
}

TEST(vtk_xml_reader, asks_for_a_field_and_a_component_where_there_are_several) {
  const TempDir dir;
  std::string vectors;
  std::string scalars;
  for (int i = 0; i < 24; ++i) {
    vectors += fmt::format("{} {} 0 ", 3 * i, 4 * i);
    scalars += "7 ";
  }
  const std::string velocity =
      "<DataArray type=\"Int32\" Name=\"velocity\" NumberOfComponents=\"3\">" + vectors +
      "</DataArray>";
  const auto path =
      dir.write("a.vti", XmlParts{.arrays = velocity + array("UInt8", "", scalars)}.text());
  expect_failure(path, {"2 fields", "--field", "velocity, v"});
  ReadOptions options;
  options.field = "pressure";
  expect_failure(path, {"'pressure'", "velocity, v"}, options);
  options.field = "v";
  EXPECT_EQ(samples_of<std::uint8_t>(path, options).at(3), 7);
  options.field = "velocity";
  expect_failure(path, {"3 components"}, options);
  options.component = Magnitude{};
  EXPECT_EQ(samples_of<double>(path, options).at(5), 25);
  options.component = 1;
  EXPECT_EQ(samples_of<std::int32_t>(path, options).at(5), 20);
  options.component = 3;
  expect_failure(path, {"between 0 and 2, got 3"}, options);
}

std::string rectilinear(const std::string& x, const std::string& y, const std::string& z) {
  const auto axis = [](const std::string& text) {
    return "<DataArray type=\"Float32\" format=\"ascii\">" + text + "</DataArray>";
  };
  return "<VTKFile type=\"RectilinearGrid\"><RectilinearGrid WholeExtent=\"0 3 0 2 0 0\"><Piece "
         "Extent=\"0 3 0 2 0 0\"><PointData><DataArray type=\"UInt8\" Name=\"v\">1 2 3 4 5 6 7 8 9 "
         "10 11 12</DataArray></PointData><Coordinates>" +
         axis(x) + axis(y) + axis(z) + "</Coordinates></Piece></RectilinearGrid></VTKFile>";
}

TEST(vtk_xml_reader, reads_even_axes_and_mirrors_descending_ones) {
  const TempDir dir;
  const auto path = dir.write("a.vtr", rectilinear("0.1 0.2 0.3 0.4", "10 8 6", "5"));
  const RegularGrid grid = info_of(path).grid;
  EXPECT_NEAR(grid.spacing[0], 0.1, 1e-7);
  EXPECT_EQ(grid.spacing[1], 2);
  EXPECT_EQ(grid.direction.column(1), (Vec3d{{0, -1, 0}}));
  EXPECT_EQ(grid.origin[1], 10);
  EXPECT_EQ(grid.origin[2], 5);
  EXPECT_EQ(samples_of<std::uint8_t>(path).at(11), 12);
}

TEST(vtk_xml_reader, refuses_uneven_axes_by_name_and_deviation) {
  const TempDir dir;
  expect_failure(dir.write("a.vtr", rectilinear("0 1 2 3", "0 1 3", "5")),
                 {"axis y", "not evenly spaced", "0.5"});
  expect_failure(dir.write("b.vtr", rectilinear("1 1 1 1", "0 1 2", "5")), {"axis x"});
  expect_failure(dir.write("c.vtr", rectilinear("0 1 2", "0 1 2", "5")), {"4 numbers"});
}

TEST(vtk_xml_reader, refuses_what_it_does_not_read) {
  const TempDir dir;
  const std::string ok = array("UInt8", "", "1");
  XmlParts one{.extent = "0 0 0 0 0 0", .arrays = ok};
  const auto with = [&](const char* name, const std::string& from, const std::string& to) {
    std::string text = one.text();
    text.replace(text.find(from), from.size(), to);
    return dir.write(name, text);
  };
  EXPECT_EQ(samples_of<std::uint8_t>(dir.write("ok.vti", one.text())).size(), 1U);
  expect_failure(with("a.vti", "type=\"ImageData\"", "type=\"PolyData\""), {"'PolyData'"});
  expect_failure(with("b.vti", "LittleEndian\"", "LittleEndian\" compressor=\"vtkLZ4Compressor\""),
                 {"vtkLZ4Compressor"});
  expect_failure(with("c.vti", "UInt32", "UInt16"), {"header_type"});
  expect_failure(
      with("d.vti", "Extent=\"0 0 0 0 0 0\">\n<PointData>", "Extent=\"0 1 0 0 0 0\">\n<PointData>"),
      {"whole extent"});
  expect_failure(with("e.vti", "</Piece>", "</Piece><Piece/>"), {"several"});
  std::string cells = one.text();
  for (std::size_t at; (at = cells.find("PointData")) != std::string::npos;)
    cells.replace(at, 9, "CellData");
  expect_failure(dir.write("f.vti", cells), {"cell data"});
  expect_failure(with("g.vti", "</ImageData>", ""), {"well-formed"});
  expect_failure(with("h.vti", "Spacing=\"1 1 1\"", "Spacing=\"1 1\""), {"3 numbers", "Spacing"});
  expect_failure(with("i.vti", "Name=", "format=\"appended\" offset=\"0\" Name="), {"appended"});
}

TEST(vtk_xml_reader, refuses_sizes_that_do_not_fit_the_file) {
  const TempDir dir;
  const auto huge = XmlParts{.extent = "0 2000000000 0 2000000000 0 2000000000",
                             .arrays = array("Float64", "", "1")};
  expect_failure(dir.write("a.vti", huge.text()), {"2^63"});
  const auto large =
      XmlParts{.extent = "0 20000 0 20000 0 200", .arrays = array("UInt8", "", "1 2 3")};
  expect_failure(dir.write("b.vti", large.text()), {"promises"});
  XmlParts compressed{.extent = large.extent};
  compressed.root += " compressor=\"vtkZLibDataCompressor\"";
  const std::string header = bytes_of<std::uint32_t>({4000000000U, 20, 0});
  compressed.arrays = array("UInt8", "format=\"binary\"", base64(header));
  expect_failure(dir.write("c.vti", compressed.text()), {"compressed blocks"});
  compressed.extent = "0 3 0 2 0 1";
  compressed.arrays = array("UInt8", "format=\"binary\"",
                            base64(bytes_of<std::uint32_t>({1, 24, 0, 4000000000U})) + "AAAA");
  expect_failure(dir.write("d.vti", compressed.text()), {"4000000000"});
}

TEST(vtk_xml_reader, refuses_truncated_and_damaged_data) {
  const TempDir dir;
  const std::string raw = counted<std::uint32_t>(std::string(24, 'x'), ByteOrder::little);
  XmlParts parts{.arrays = array("UInt8", "format=\"binary\"", base64(raw).substr(0, 20))};
  expect_failure(dir.write("a.vti", parts.text()), {"24 bytes"});
  parts.arrays = array("UInt8", "format=\"binary\"", "****" + base64(raw));
  expect_failure(dir.write("b.vti", parts.text()), {"base64"});
  parts.arrays = array("UInt16", "format=\"binary\"", base64(raw));
  expect_failure(dir.write("c.vti", parts.text()), {"48 bytes", "24"});
  parts.arrays = array("UInt8", "format=\"appended\" offset=\"0\"", "");
  parts.appended = "<AppendedData encoding=\"raw\">_" + raw;
  const std::string whole = parts.text();
  expect_failure(dir.write("d.vti", whole.substr(0, whole.size() - 20)), {"24 bytes"});
  parts.arrays = array("UInt8", "format=\"appended\" offset=\"999999\"", "");
  expect_failure(dir.write("e.vti", parts.text()), {"'999999'"});
  expect_failure(dir.write("f.vti", std::string(4000, '\x03')), {"VTK XML"});
}

}  // namespace
}  // namespace lode::io
