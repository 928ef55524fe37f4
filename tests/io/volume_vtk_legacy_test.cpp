#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::bytes_of;
using test::expect_failure;
using test::info_of;
using test::ramp;
using test::samples_of;
using test::TempDir;

std::string head(const std::string& encoding) {
  return "# vtk DataFile Version 3.0\na title\n" + encoding + "\n";
}

std::string points(const std::string& encoding) {
  return head(encoding) +
         "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 2\nSPACING 1 2 -3\nORIGIN 5 6 7\n";
}

template <typename T>
std::string text_of(const std::vector<T>& numbers) {
  std::string text;
  for (const T number : numbers) text += fmt::format("{} ", number);
  return text + "\n";
}

TEST(vtk_legacy_reader, reads_binary_and_ascii_scalars) {
  const TempDir dir;
  const auto samples = ramp<std::int16_t>(24);
  const std::string scalars = "POINT_DATA 24\nSCALARS some%20name short 1\nLOOKUP_TABLE default\n";
  const auto binary =
      dir.write("a.vtk", points("BINARY") + scalars + bytes_of(samples, ByteOrder::big) + "\n");
  const auto ascii = dir.write("b.vtk", points("ASCII") + scalars + text_of(samples));
  EXPECT_EQ(samples_of<std::int16_t>(binary), samples);
  EXPECT_EQ(samples_of<std::int16_t>(ascii), samples);
  EXPECT_EQ(info_of(binary).field_name, "some name");
  const RegularGrid grid = info_of(binary).grid;
  EXPECT_EQ(grid.spacing, (Vec3d{{1, 2, 3}}));
  EXPECT_EQ(grid.direction.column(2), (Vec3d{{0, 0, -1}}));
  EXPECT_EQ(grid.origin, (Vec3d{{5, 6, 7}}));
}

TEST(vtk_legacy_reader, reads_colours_as_the_same_bytes_from_binary_and_ascii) {
  const TempDir dir;
  std::vector<std::uint8_t> samples(256);
  std::string fractions;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<std::uint8_t>(i);
    // Six digits, as VTK writes them.
    fractions += fmt::format("{:g} ", static_cast<float>(i) / 255.0F);
  }
  const auto file = [&](const std::string& encoding, const std::string& data) {
    return head(encoding) +
           "DATASET STRUCTURED_POINTS\nDIMENSIONS 16 8 2\nPOINT_DATA 256\nCOLOR_SCALARS c 1\n" +
           data + "\n";
  };
  EXPECT_EQ(samples_of<std::uint8_t>(dir.write("a.vtk", file("BINARY", bytes_of(samples)))),
            samples);
  EXPECT_EQ(samples_of<std::uint8_t>(dir.write("b.vtk", file("ASCII", fractions))), samples);
  for (const char* wrong : {"1.2", "-0.1", "nan"})
    expect_failure(dir.write("c.vtk", file("ASCII", wrong + fractions.substr(fractions.find(' ')))),
                   {"from 0 to 1", wrong});
}

TEST(vtk_legacy_reader, reads_lines_that_end_in_carriage_returns) {
  const TempDir dir;
  const auto samples = ramp<std::uint16_t>(24);
  std::string header = points("BINARY") +
                       "POINT_DATA 24\nSCALARS s unsigned_short\nLOOKUP_TABLE "
                       "default\n";
  for (std::size_t at = 0; (at = header.find('\n', at)) != std::string::npos; at += 2)
    header.insert(at, "\r");
  EXPECT_EQ(
      samples_of<std::uint16_t>(dir.write("a.vtk", header + bytes_of(samples, ByteOrder::big))),
      samples);
}

TEST(vtk_legacy_reader, picks_among_scalars_vectors_and_fields_behind_cell_data) {
  const TempDir dir;
  const auto vectors = ramp<float>(72);
  const auto field = ramp<double>(24);
  const std::string path = dir.write(
      "a.vtk",
      points("BINARY") + "FIELD FieldData 1\nTIME 1 1 double\n" + bytes_of<double>({3}) +
          "\nCELL_DATA 6\nSCALARS cells unsigned_char\nLOOKUP_TABLE default\nabcdef\nPOINT_DATA "
          "24\nVECTORS wind float\n" +
          bytes_of(vectors, ByteOrder::big) +
          "\nMETADATA\nINFORMATION 0\n\nFIELD FieldData 2\nheat 1 24 double\n" +
          bytes_of(field, ByteOrder::big) + "\nMETADATA\nINFORMATION 0\n\npair 2 24 char\n" +
          std::string(48, 'q') + "\nLOOKUP_TABLE colours 2\n12345678\n");
  expect_failure(path, {"3 fields", "wind, heat, pair"});
  ReadOptions options;
  options.field = "heat";
  EXPECT_EQ(samples_of<double>(path, options), field);
  options.field = "wind";
  options.component = 2;
  EXPECT_EQ(samples_of<float>(path, options).at(4), vectors[14]);
}

TEST(vtk_legacy_reader, reads_even_rectilinear_grids_and_refuses_others) {
  const TempDir dir;
  const auto samples = ramp<std::uint8_t>(24);
  const auto file = [&](const std::vector<float>& z) {
    return head("BINARY") + "DATASET RECTILINEAR_GRID\nDIMENSIONS 4 3 2\nX_COORDINATES 4 float\n" +
           bytes_of<float>({0, 1, 2, 3}, ByteOrder::big) + "\nY_COORDINATES 3 double\n" +
           bytes_of<double>({5, 4, 3}, ByteOrder::big) + "\nZ_COORDINATES 2 float\n" +
           bytes_of(z, ByteOrder::big) +
           "\nPOINT_DATA 24\nSCALARS v unsigned_char\nLOOKUP_TABLE default\n" + bytes_of(samples);
  };
  const auto path = dir.write("a.vtk", file({1, 3}));
  EXPECT_EQ(samples_of<std::uint8_t>(path), samples);
  EXPECT_EQ(info_of(path).grid.spacing, (Vec3d{{1, 1, 2}}));
  EXPECT_EQ(info_of(path).grid.direction.column(1), (Vec3d{{0, -1, 0}}));
  expect_failure(dir.write("b.vtk", file({1, 1})), {"axis z"});
  std::string uneven = file({1, 3});
  uneven.replace(uneven.find(bytes_of<float>({1}, ByteOrder::big)), 4,
                 bytes_of<float>({1.5F}, ByteOrder::big));
  expect_failure(dir.write("c.vtk", uneven), {"axis x", "not evenly spaced"});
}

TEST(vtk_legacy_reader, refuses_cell_data_other_datasets_and_bad_counts) {
  const TempDir dir;
  const std::string tail = "SCALARS s unsigned_char\nLOOKUP_TABLE default\n";
  expect_failure(dir.write("a.vtk", points("BINARY") + "CELL_DATA 6\n" + tail + "abcdef"),
                 {"cell data"});
  expect_failure(dir.write("b.vtk", head("BINARY") + "DATASET POLYDATA\n"), {"'POLYDATA'"});
  expect_failure(dir.write("c.vtk", points("BINARY") + "POINT_DATA 6\n" + tail + "abcdef"),
                 {"24 samples", "got 6"});
  expect_failure(
      dir.write("d.vtk",
                points("BINARY") + "POINT_DATA 24\nSCALARS s bit\nLOOKUP_TABLE default\nabc\n"),
      {"numbers", "bits in 's'"});
  expect_failure(dir.write("e.vtk", points("BINARY") + "POINT_DATA 24\nSCALARS s char\nabc\n"),
                 {"LOOKUP_TABLE"});
  expect_failure(dir.write("f.vtk", points("BINARY") + "NONSENSE 1 2\n"), {"'NONSENSE'"});
  expect_failure(dir.write("g.vtk", points("BINARY")), {"POINT_DATA"});
}

TEST(vtk_legacy_reader, passes_over_texts_and_bits) {
  const TempDir dir;
  std::string texts = "FIELD FieldData 2\nnames 1 24 string\n";
  for (int i = 0; i < 24; ++i) texts += "\xC2\n\n";
  const auto source =
      open_volume(dir.write("texts.vtk", points("BINARY") + "POINT_DATA 24\nSCALARS bits bit\n" +
                                             "LOOKUP_TABLE default\nabc\n" + texts +
                                             "\ns 1 24 unsigned_char\nabcdefghijklmnopqrstuvwx\n"),
                  {});
  ASSERT_TRUE(source) << source.error().message;
}

TEST(vtk_legacy_reader, refuses_truncation_garbage_and_overflow) {
  const TempDir dir;
  const std::string tail = "SCALARS s double\nLOOKUP_TABLE default\n";
  expect_failure(dir.write("a.vtk", points("BINARY") + "POINT_DATA 24\n" + tail + "abcdef"),
                 {"expected", "bytes"});
  expect_failure(dir.write("b.vtk", points("ASCII") + "POINT_DATA 24\n" + tail + "1 2 3"),
                 {"24 numbers", "got 3"});
  expect_failure(dir.write("c.vtk", points("BINARY") + "POINT_DATA 9000000000000000000\n" + tail),
                 {"2^63"});
  expect_failure(dir.write("d.vtk", points("ASCII") + "POINT_DATA 900000000000000000\n" + tail),
                 {"got 0"});
  std::string huge = points("BINARY") + "POINT_DATA 24\n" + tail + std::string(192, 'x');
  huge.replace(huge.find("4 3 2"), 5, "2000000000 2000000000 2000000000");
  expect_failure(dir.write("e.vtk", huge), {"2^63"});
  expect_failure(dir.write("f.vtk", std::string(5000, '\x06')), {"# vtk DataFile"});
  expect_failure(dir.write("g.vtk", head("BINARY") + std::string(100000, 'x')), {"longer than"});
}

}  // namespace
}  // namespace lode::io
