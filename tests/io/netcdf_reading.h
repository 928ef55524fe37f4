#pragma once

#include <array>
#include <string>

#include "tests/io/height_reading.h"
#include "tests/io/netcdf_files.h"

namespace lode::io::test {

/// Reading of netCDF, in a directory that is gone when the test is.
class NetcdfReading : public HeightReading {
 protected:
  /// 4 x 3 samples round 10 E and 47 N, from north to south.
  static NetcdfFile alps() {
    return {.samples = twelve(25), .x = places(10, 0.25, 4), .y = places(47, -0.25, 3)};
  }
  [[nodiscard]] std::string write(const NetcdfFile& file, const std::string& name = "a.nc") const {
    write_netcdf_file((*this)(name), file);
    return (*this)(name);
  }
  [[nodiscard]] std::string refused(const NetcdfFile& file,
                                    const HeightReadOptions& options = {}) const {
    return refusal(write(file), options);
  }
  static void expect_equal(const HeightGrid& a, const HeightGrid& b) {
    EXPECT_EQ(a.n_columns, b.n_columns);
    EXPECT_EQ(a.n_rows, b.n_rows);
    EXPECT_EQ(a.to_world, b.to_world);
    EXPECT_EQ(a.crs, b.crs);
    EXPECT_EQ(a.vertical_unit, b.vertical_unit);
    EXPECT_EQ(a.heights.index(), b.heights.index());
    for (std::int32_t y = 0; y < a.n_rows; ++y)
      for (std::int32_t x = 0; x < a.n_columns; ++x) {
        ASSERT_EQ(a.has_height(x, y), b.has_height(x, y)) << x << ", " << y;
        if (a.has_height(x, y)) ASSERT_EQ(a.height(x, y), b.height(x, y)) << x << ", " << y;
      }
  }
};

inline constexpr std::array kNetcdfFormats{0, NC_64BIT_OFFSET, NC_64BIT_DATA, NC_NETCDF4,
                                           NC_NETCDF4 | NC_CLASSIC_MODEL};

}  // namespace lode::io::test
