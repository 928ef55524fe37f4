// Where rasters of netCDF lie, by their coordinates and by what they say of their CRS.
#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/io/height_files.h"
#include "tests/io/netcdf_reading.h"

namespace lode::io {
namespace {

using test::kNetcdfFormats;
using test::NetcdfFile;
using test::places;
using test::RasterFile;
using test::set_number;
using test::set_text;
using test::twelve;
using test::write_raster;

class netcdf_place : public test::NetcdfReading {};

/// A height that says where it is.
double height_at(double x, double y) { return std::round(40 * x + 400 * (y - 40)); }

TEST_F(netcdf_place, has_each_height_in_its_place_whichever_way_rows_and_columns_run) {
  constexpr int kColumns = 37;
  constexpr int kRows = 23;
  for (const int format : kNetcdfFormats)
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

TEST_F(netcdf_place, is_in_degrees_of_wgs_84_unless_something_else_is_said) {
  const std::string path = write(alps());
  const HeightRaster raster = read(path);
  write_raster(
      (*this)("a.tif"),
      {.samples = twelve(1), .geotransform = {{9.875, 0.25, 0, 47.125, 0, -0.25}}, .epsg = 4326});
  EXPECT_EQ(raster.grid.crs, read((*this)("a.tif")).grid.crs);
  ASSERT_EQ(raster.vertical.notes.size(), 1U);
  EXPECT_NE(raster.vertical.notes[0].find("taken for those of WGS 84"), std::string::npos);
  const HeightRaster stated = read(path, {.crs = "EPSG:4258"});
  EXPECT_TRUE(stated.vertical.notes.empty());
  EXPECT_NE(stated.grid.crs.find("4258"), std::string::npos);
  NetcdfFile file = alps();
  file.x_units = file.y_units = "m";
  file.x_name = "x";
  file.y_name = "y";
  EXPECT_TRUE(read(write(file)).grid.crs.empty());
}

/// A variable that says of the CRS what `text` and `numbers` do.
struct Mapping {
  std::vector<std::pair<const char*, std::string>> text;
  std::vector<std::pair<const char*, double>> numbers{};

  void operator()(int nc, int z) const {
    int mapping = -1;
    nc_def_var(nc, "where", NC_INT, 0, nullptr, &mapping);
    set_text(nc, z, "grid_mapping", "where");
    for (const auto& [name, value] : text) set_text(nc, mapping, name, value);
    for (const auto& [name, value] : numbers) set_number(nc, mapping, name, NC_DOUBLE, value);
  }
};

TEST_F(netcdf_place, is_in_the_crs_of_its_grid_mapping) {
  RasterFile tiff{.samples = twelve(25), .geotransform = {{499950, 100, 0, 5200050, 0, -100}}};
  tiff.epsg = 32632;
  write_raster((*this)("a.tif"), tiff);
  const HeightRaster utm = read((*this)("a.tif"));
  NetcdfFile file{.samples = twelve(25),
                  .x = places(500000, 100, 4),
                  .y = places(5200000, -100, 3),
                  .x_name = "x",
                  .y_name = "y",
                  .x_units = "m",
                  .y_units = "m"};
  for (const char* name : {"crs_wkt", "spatial_ref"}) {
    file.define = Mapping{{{name, utm.grid.crs}}};
    expect_equal(read(write(file)).grid, utm.grid);
  }
  file.define = Mapping{{{"epsg_code", "EPSG:32632"}}};
  expect_equal(read(write(file)).grid, utm.grid);
  const HeightReadOptions in_degrees{.to_degrees = Resampling::cubic};
  expect_equal(read(write(file), in_degrees).grid, read((*this)("a.tif"), in_degrees).grid);
  EXPECT_NE(refused(file, {.crs = "EPSG:32633"}).find("one of its own"), std::string::npos);
  // And what heights are above.
  tiff.epsg = 0;
  tiff.crs = "EPSG:32632+5773";
  write_raster((*this)("b.tif"), tiff);
  file.define = Mapping{{{"crs_wkt", read((*this)("b.tif")).grid.crs}}};
  EXPECT_EQ(vertical_name(read(write(file)).grid.crs), "EGM96 height");
  file.define = Mapping{{{"epsg_code", "EPSG:32632"}}};
  file.x = places(500, 0.1, 4);
  file.y = places(5200, -0.1, 3);
  file.x_units = file.y_units = "km";
  const HeightRaster thousands = read(write(file));
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(thousands.grid.to_world[i], utm.grid.to_world[i], 1e-6) << i;
}

TEST_F(netcdf_place, is_in_the_crs_of_cfs_attributes) {
  NetcdfFile file{.samples = twelve(25),
                  .x = places(500000, 100, 4),
                  .y = places(5200000, -100, 3),
                  .x_name = "x",
                  .y_name = "y",
                  .x_units = "m",
                  .y_units = "m"};
  file.define = Mapping{{{"grid_mapping_name", "transverse_mercator"}},
                        {{"longitude_of_central_meridian", 9},
                         {"latitude_of_projection_origin", 0},
                         {"false_easting", 500000},
                         {"false_northing", 0},
                         {"scale_factor_at_central_meridian", 0.9996},
                         {"semi_major_axis", 6378137},
                         {"inverse_flattening", 298.257223563}}};
  file.add = [](int nc, int) {
    int x = -1;
    int y = -1;
    nc_inq_varid(nc, "x", &x);
    nc_inq_varid(nc, "y", &y);
    nc_redef(nc);
    set_text(nc, x, "standard_name", "projection_x_coordinate");
    set_text(nc, y, "standard_name", "projection_y_coordinate");
    nc_enddef(nc);
  };
  std::string crs;
  for (const int format : kNetcdfFormats) {
    file.format = format;
    const std::string found = read(write(file)).grid.crs;
    EXPECT_TRUE(crs.empty() || crs == found) << format;
    crs = found;
  }
  EXPECT_NE(crs.find("Transverse_Mercator"), std::string::npos) << crs;
  EXPECT_NE(crs.find("0.9996"), std::string::npos) << crs;
  file.define = Mapping{{{"grid_mapping_name", "nobody_knows"}}};
  EXPECT_NE(refused(file).find("not understood, 'where'"), std::string::npos) << refused(file);
  EXPECT_NE(read(write(file), {.crs = "EPSG:32632"}).grid.crs.find("32632"), std::string::npos);
  file.define = [](int nc, int z) { set_text(nc, z, "grid_mapping", "nowhere"); };
  EXPECT_NE(refused(file).find("the variable 'nowhere'"), std::string::npos);
}

}  // namespace
}  // namespace lode::io
