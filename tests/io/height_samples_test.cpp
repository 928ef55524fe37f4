// Which numbers of a file become which heights, and where.
#include <array>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>

#include "tests/io/height_files.h"
#include "tests/io/height_reading.h"

namespace lode::io {
namespace {

using test::twelve;
using test::write_raster;

class height_samples : public test::HeightReading {};

TEST_F(height_samples, takes_doubles_of_esri_ascii_whose_digits_floats_lose) {
  const auto written = [&](const std::string& nodata, const std::string& samples) {
    std::ofstream((*this)("a.asc"))
        << "ncols 3\nnrows 1\nxllcorner 500000.123456\nyllcorner 0\ncellsize 10\nnodata_value "
        << nodata << '\n'
        << samples << '\n';
    return read((*this)("a.asc"));
  };
  const HeightRaster precise = written("-9999", "1000000000.00 1000000000.10 1000000000.20");
  EXPECT_EQ(precise.type, "float64");
  expect_samples(precise.grid, {1e9, 1000000000.1, 1000000000.2});
  // Floats as GDAL and others write them, zeros that end a fraction, and what is missing.
  EXPECT_EQ(written("-9999", "0.10000000149011612 812.50000000 0000012.25").type, "float32");
  const HeightRaster marked =
      written("-3.4028234663852886e+38", "1.5 -3.40282346638529e+38 812.1234567");
  EXPECT_EQ(marked.type, "float64");
  EXPECT_EQ(marked.grid.n_missing(), 1U);
  EXPECT_EQ(written("-3.4028234663852886e+38", "1.5 -3.40282346638529e+38 8").type, "float32");
  // What is no float is that nearest to it, in any digits, and what is one is itself alone.
  const HeightRaster decimal = written("-9999.9", "-9999.900391 812.1234567 3");
  EXPECT_EQ(decimal.type, "float64");
  EXPECT_EQ(decimal.grid.n_missing(), 1U);
  const HeightRaster close = written("1000000000", "1000000000.00 1000000000.10 3.5");
  EXPECT_EQ(close.type, "float64");
  EXPECT_EQ(close.grid.n_missing(), 1U);
  // Whole numbers are exact as such, but not beside fractions, nor beyond 32 bits.
  expect_samples(written("-9999", "16777217 2147483647 -5").grid, {16777217, 2147483647, -5});
  expect_samples(written("-9999.0", "16777217 2147483647 -5").grid, {16777217, 2147483647, -5});
  expect_samples(written("-9999", "16777217 0.5 -5").grid, {16777217, 0.5, -5});
  expect_samples(written("-9999", "3000000000 0 -5").grid, {3e9, 0, -5});
  // Nor is it lost that fractions begin far down in the text, or sizes that floats have not.
  expect_samples(written("-9999", "1" + std::string(1200000, ' ') + "2.25 3").grid, {1, 2.25, 3});
  expect_samples(written("-9999", "1e-60 1e60 3").grid, {1e-60, 1e60, 3});
}

TEST_F(height_samples, takes_64_bit_integers_that_doubles_hold_and_names_others) {
  constexpr std::int64_t kMost = std::int64_t{1} << 53;
  const std::string path = (*this)("a.tif");
  std::vector<double> samples = twelve(1e9);
  samples[0] = static_cast<double>(-kMost);
  for (const auto& [type, name] : {std::pair{GDT_Int64, "int64"}, {GDT_UInt64, "uint64"}}) {
    if (type == GDT_UInt64)
      for (double& z : samples) z = std::abs(z);
    write_raster(path, {.type = type, .samples = samples});
    const HeightRaster raster = read(path);
    EXPECT_EQ(raster.type, name);
    expect_samples(raster.grid, samples);
  }
  write_raster(path, {.type = GDT_Int64, .samples = twelve(1), .int64 = kMost + 1});
  EXPECT_NE(refusal(path).find("got 9007199254740993 in column 0, row 0"), std::string::npos);
  // What stands for no height may be any, and is none but itself.
  constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();
  write_raster(path, {.type = GDT_Int64, .samples = twelve(1), .int64 = kLast, .nodata64 = kLast});
  EXPECT_EQ(read(path).grid.n_missing(), 1U);
  write_raster(path,
               {.type = GDT_Int64, .samples = twelve(1), .int64 = kLast - 1, .nodata64 = kLast});
  EXPECT_NE(refusal(path).find("got 9223372036854775806"), std::string::npos);
  EXPECT_EQ(read(path, {.nodata = 0x1p63}).grid.n_missing(), 1U) << "as the user says it";
}

TEST_F(height_samples, takes_signed_bytes) {
  std::vector<double> samples = twelve(10);
  samples[1] = -128;
  // GDAL 3.6 writes them as bytes.
  std::vector<double> bytes = samples;
  for (double& z : bytes)
    if (z < 0) z += 256;
  write_raster((*this)("a.tif"), {.type = GDT_Byte, .samples = bytes, .is_signed_byte = true});
  const HeightRaster raster = read((*this)("a.tif"));
  EXPECT_EQ(raster.type, "int8");
  expect_samples(raster.grid, samples);
  write_raster((*this)("b.tif"),
               {.type = GDT_Byte, .samples = bytes, .scale = 0.5, .is_signed_byte = true});
  for (double& z : samples) z *= 0.5;
  expect_samples(read((*this)("b.tif")).grid, samples);
}

TEST_F(height_samples, takes_a_crs_for_what_has_none) {
  std::ofstream((*this)("a.asc")) << "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
                                     "1 2\n3 4\n";
  EXPECT_EQ(read((*this)("a.asc")).grid.crs, "");
  const HeightRaster plain = read((*this)("a.asc"), {.crs = "EPSG:32611"});
  EXPECT_NE(plain.grid.crs.find("WGS 84 / UTM zone 11N"), std::string::npos) << plain.grid.crs;
  const HeightRaster compound = read((*this)("a.asc"), {.crs = "EPSG:32611+5703"});
  EXPECT_EQ(compound.grid.vertical_unit, "metre") << compound.grid.crs;
  const HeightRaster degrees =
      read((*this)("a.asc"), {.crs = "EPSG:32611", .to_degrees = Resampling::bilinear});
  EXPECT_NE(degrees.grid.crs.find("4326"), std::string::npos);
  EXPECT_NE(refusal((*this)("a.asc"), {.crs = "EPSG:none"}).find("EPSG:none"), std::string::npos);
  // One beside the file is the same in whatever order its axes are, and a place is needed.
  std::ofstream((*this)("b.asc")) << "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
                                     "1 2\n3 4\n";
  std::ofstream((*this)("b.prj"))
      << R"(GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137,298.257223563]],)"
         R"(PRIMEM["Greenwich",0],UNIT["Degree",0.0174532925199433]])";
  EXPECT_EQ(read((*this)("b.asc"), {.crs = "EPSG:4326"}).grid.crs, read((*this)("b.asc")).grid.crs);
  EXPECT_NE(refusal((*this)("b.asc"), {.crs = "EPSG:32611"}).find("one of its own"),
            std::string::npos);
  write_raster((*this)("nowhere.tif"), {.samples = twelve(1)});
  EXPECT_NE(refusal((*this)("nowhere.tif"), {.crs = "EPSG:4326"}).find("says where it is"),
            std::string::npos);
  // One that the file has is taken again, and no other.
  write_raster((*this)("own.tif"), {.samples = twelve(1),
                                    .geotransform = std::array<double, 6>{0, 1, 0, 0, 0, -1},
                                    .epsg = 32611});
  EXPECT_EQ(read((*this)("own.tif"), {.crs = "EPSG:32611"}).grid.crs,
            read((*this)("own.tif")).grid.crs);
  EXPECT_NE(refusal((*this)("own.tif"), {.crs = "EPSG:4326"}).find("one of its own"),
            std::string::npos);
  std::ofstream((*this)("S05W171.hgt")) << std::string(50, '\1');
  EXPECT_EQ(read((*this)("S05W171.hgt"), {.crs = "EPSG:4326"}).grid.n_rows, 5);
  EXPECT_NE(refusal((*this)("S05W171.hgt"), {.crs = "EPSG:32611"}).find("one of its own"),
            std::string::npos);
}

}  // namespace
}  // namespace lode::io
