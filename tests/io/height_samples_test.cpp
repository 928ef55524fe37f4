// Which numbers of a file become which heights, and where.
#include <fstream>

#include "tests/io/height_reading.h"

namespace lode::io {
namespace {

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
  // Whole numbers are exact as such, but not beside fractions, nor beyond 32 bits.
  expect_samples(written("-9999", "16777217 2147483647 -5").grid, {16777217, 2147483647, -5});
  expect_samples(written("-9999.0", "16777217 2147483647 -5").grid, {16777217, 2147483647, -5});
  expect_samples(written("-9999", "16777217 0.5 -5").grid, {16777217, 0.5, -5});
  expect_samples(written("-9999", "3000000000 0 -5").grid, {3e9, 0, -5});
  // Nor is it lost that fractions begin far down in the text, or sizes that floats have not.
  expect_samples(written("-9999", "1" + std::string(1200000, ' ') + "2.25 3").grid, {1, 2.25, 3});
  expect_samples(written("-9999", "1e-60 1e60 3").grid, {1e-60, 1e60, 3});
}

}  // namespace
}  // namespace lode::io
