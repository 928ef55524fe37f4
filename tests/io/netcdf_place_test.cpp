// Where rasters of netCDF lie, by their coordinates.
#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/io/netcdf_reading.h"
#include "tests/oracles/trials.h"

namespace lode::io {
namespace {

using test::kNetcdfFormats;
using test::NetcdfFile;
using test::places;
using test::set_number;
using test::set_text;
using test::twelve;

class netcdf_place : public test::NetcdfReading {};

/// A height that says where it is.
double height_at(double x, double y) { return std::round(40 * x + 400 * (y - 40)); }

TEST_F(netcdf_place, has_each_height_in_its_place_whichever_way_rows_and_columns_run) {
  constexpr int kColumns = 37;
  constexpr int kRows = 23;
  for (const int format : oracles::trials<std::vector<int>>(
           {kNetcdfFormats.begin(), kNetcdfFormats.end()}, {0, NC_NETCDF4}))
    for (const double x_step : {0.125, -0.125})
      for (const double y_step : {0.25, -0.25}) {
        NetcdfFile file{.format = format, .n_columns = kColumns, .n_rows = kRows};
        file.x = places(8, x_step, kColumns);
        file.y = places(47, y_step, kRows);
        for (const double y : file.y)
          for (const double x : file.x) file.samples.push_back(height_at(x, y));
        if (format == NC_NETCDF4) file.chunk = {5, 8};
        const HeightRaster raster = read(write(file), {.crs = "EPSG:4326"});
        ASSERT_EQ(raster.grid.n_columns, kColumns);
        ASSERT_EQ(raster.grid.n_rows, kRows);
        EXPECT_EQ(raster.format, "netCDF");
        EXPECT_EQ(raster.type, "int16");
        EXPECT_TRUE(raster.has_place);
        EXPECT_GT(raster.grid.to_world[1], 0);
        EXPECT_LT(raster.grid.to_world[5], 0);
        for (int row = 0; row < kRows; ++row)
          for (int column = 0; column < kColumns; ++column) {
            const auto place = raster.grid.world(column, row);
            ASSERT_EQ(raster.grid.height(column, row), height_at(place[0], place[1]));
          }
        const auto corner = raster.grid.world(0, 0);
        EXPECT_EQ(corner[0], std::min(file.x.front(), file.x.back()));
        EXPECT_EQ(corner[1], std::max(file.y.front(), file.y.back()));
      }
}

/// What GDAL's own driver for netCDF reads: rows, and the geotransform.
TEST_F(netcdf_place, lies_as_another_reader_has_it) {
  constexpr int kColumns = 31;
  constexpr int kRows = 19;
  GDALAllRegister();
  // Its driver does not open CDF-5.
  for (const int format : {0, NC_64BIT_OFFSET, NC_NETCDF4})
    for (const double y_step : {0.25, -0.25}) {
      NetcdfFile file{.format = format, .n_columns = kColumns, .n_rows = kRows};
      file.x = places(-3, 0.125, kColumns);
      file.y = places(47, y_step, kRows);
      for (const double y : file.y)
        for (const double x : file.x) file.samples.push_back(height_at(x, y));
      const std::string path = write(file);
      const HeightRaster ours = read(path);
      GDALDatasetH theirs = GDALOpen(("NETCDF:\"" + path + "\":z").c_str(), GA_ReadOnly);
      ASSERT_NE(theirs, nullptr);
      std::array<double, 6> geotransform{};
      ASSERT_EQ(GDALGetGeoTransform(theirs, geotransform.data()), CE_None);
      EXPECT_EQ(ours.form.geotransform, geotransform);
      std::vector<double> samples(std::size_t{kColumns} * kRows);
      ASSERT_EQ(GDALRasterIO(GDALGetRasterBand(theirs, 1), GF_Read, 0, 0, kColumns, kRows,
                             samples.data(), kColumns, kRows, GDT_Float64, 0, 0),
                CE_None);
      GDALClose(theirs);
      expect_samples(ours.grid, samples);
      EXPECT_EQ(ours.grid.n_missing(), 0U);
    }
}

TEST_F(netcdf_place, is_refused_where_places_are_not_those_of_a_raster) {
  NetcdfFile file = alps();
  file.x[2] += 0.006;
  EXPECT_NE(refused(file).find("expected even places along lon"), std::string::npos);
  file.x[2] -= 0.005;  // less than a hundredth of a step
  EXPECT_EQ(read(write(file)).grid.to_world[1], 0.25);
  file = alps();
  file.y = {47, 47, 47};
  EXPECT_NE(refused(file).find("that differ"), std::string::npos);
  file = alps();
  file.y[1] = std::nan("");
  EXPECT_NE(refused(file).find("expected numbers for places along lat"), std::string::npos);
  file = alps();
  file.x.clear();
  EXPECT_NE(refused(file).find("got them along one"), std::string::npos);
  file = alps();
  std::swap(file.x_units, file.y_units);
  EXPECT_NE(refused(file).find("over lat and lon"), std::string::npos);
  file = alps();
  file.x.clear();
  file.y.clear();
  file.define = [](int nc, int z) { set_text(nc, z, "coordinates", "east north"); };
  EXPECT_NE(refused(file).find("a place of each sample"), std::string::npos);
  file = {.n_columns = 1, .n_rows = 3, .samples = {1, 2, 3}};
  EXPECT_NE(refused(file).find("two samples or more along lon"), std::string::npos);
}

TEST_F(netcdf_place, has_places_of_float32_as_even_as_these_can_be) {
  // Steps of a second of arc, a 32nd of which float32 rounds to at 179 degrees.
  constexpr int kColumns = 400;
  constexpr double kStep = 1.0 / 3600;
  NetcdfFile file{.n_columns = kColumns, .n_rows = 2};
  file.samples = std::vector<double>(2 * kColumns, 5);
  file.x = places(179, kStep, kColumns);
  file.y = places(10, kStep, 2);
  file.place_type = NC_FLOAT;
  const HeightRaster raster = read(write(file));
  EXPECT_NEAR(raster.grid.to_world[1], kStep, 0.001 * kStep);
  EXPECT_NEAR(raster.grid.world(200, 0)[0], file.x[200], kStep / 16);
}

TEST_F(netcdf_place, without_coordinates_has_no_place) {
  NetcdfFile file{.samples = twelve(3)};
  const HeightRaster raster = read(write(file));
  EXPECT_FALSE(raster.has_place);
  EXPECT_TRUE(raster.grid.crs.empty());
  expect_samples(raster.grid, file.samples);
  ASSERT_EQ(raster.vertical.notes.size(), 1U);
  EXPECT_NE(raster.vertical.notes[0].find("taken for the northern one"), std::string::npos);
  // Axes of other names, which say nothing.
  file = alps();
  file.x_units = file.y_units = "";
  file.x_name = "across";
  file.y_name = "along";
  const auto notes = read(write(file)).vertical.notes;
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("across is taken for x, and along for y"), std::string::npos);
}

/// Longitudes and latitudes along dimensions that are named otherwise; south up.
TEST_F(netcdf_place, has_degrees_along_dimensions_of_any_name) {
  NetcdfFile file{.samples = twelve(25)};
  file.define = [](int nc, int z) {
    std::array<int, 2> dimensions{};
    nc_inq_vardimid(nc, z, dimensions.data());
    int x = -1;
    int y = -1;
    nc_def_var(nc, "longitude_of_cell", NC_DOUBLE, 1, &dimensions[1], &x);
    nc_def_var(nc, "latitude_of_cell", NC_DOUBLE, 1, &dimensions[0], &y);
    set_text(nc, x, "units", "degrees_east");
    set_text(nc, y, "units", "degrees_north");
  };
  file.add = [](int nc, int) {
    int x = -1;
    int y = -1;
    nc_inq_varid(nc, "longitude_of_cell", &x);
    nc_inq_varid(nc, "latitude_of_cell", &y);
    nc_put_var_double(nc, x, places(10, 0.25, 4).data());
    nc_put_var_double(nc, y, places(46.5, 0.25, 3).data());
  };
  NetcdfFile named = alps();
  named.y = places(46.5, 0.25, 3);
  expect_equal(read(write(file)).grid, read(write(named, "b.nc")).grid);
}

TEST_F(netcdf_place, has_places_that_are_packed) {
  NetcdfFile file = alps();
  file.place_type = NC_SHORT;
  file.x = places(0, 1, 4);
  file.y = places(2, -1, 3);
  const auto pack = [](int nc, const char* name, double scale, double offset) {
    int id = -1;
    nc_inq_varid(nc, name, &id);
    set_number(nc, id, "scale_factor", NC_DOUBLE, scale);
    set_number(nc, id, "add_offset", NC_DOUBLE, offset);
  };
  file.define = [&](int nc, int) {
    pack(nc, "lon", 0.25, 10);
    pack(nc, "lat", 0.25, 46.5);
  };
  expect_equal(read(write(file)).grid, read(write(alps(), "b.nc")).grid);
}

TEST_F(netcdf_place, is_of_points_or_pixels_as_gmt_says) {
  NetcdfFile file = alps();
  EXPECT_FALSE(read(write(file)).form.is_point);
  for (const int offset : {0, 1}) {
    file.define = [&](int nc, int) { set_number(nc, NC_GLOBAL, "node_offset", NC_INT, offset); };
    const HeightRaster raster = read(write(file, "gmt.grd"));
    EXPECT_EQ(raster.form.is_point, offset == 0);
    // Coordinates are those of samples in either case.
    EXPECT_EQ(raster.grid.world(0, 0)[0], 10);
    EXPECT_EQ(raster.grid.world(3, 2)[1], 46.5);
  }
}

}  // namespace
}  // namespace lode::io
