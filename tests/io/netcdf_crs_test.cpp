// In which CRS rasters of netCDF are.
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

class netcdf_crs : public test::NetcdfReading {};

TEST_F(netcdf_crs, is_in_degrees_of_wgs_84_unless_something_else_is_said) {
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

TEST_F(netcdf_crs, is_in_the_crs_of_its_grid_mapping) {
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

TEST_F(netcdf_crs, is_in_the_crs_of_cfs_attributes) {
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

/// What a mapping cannot be of, and kilometres of no CRS of the file's own.
TEST_F(netcdf_crs, is_refused_where_axes_are_not_those_of_the_mapping) {
  NetcdfFile file = alps();
  file.define = Mapping{{{"epsg_code", "EPSG:32632"}}};
  EXPECT_NE(refused(file).find("lengths of the projection along lon"), std::string::npos);
  file.x_name = "x";
  file.y_name = "y";
  file.x_units = file.y_units = "m";
  file.define = Mapping{{}, {{"epsg_code", 4326}}};
  EXPECT_NE(refused(file).find("expected degrees along x, got m"), std::string::npos);
  file.define = {};
  file.x_units = file.y_units = "km";
  const HeightRaster raster = read(write(file), {.crs = "EPSG:3411"});
  EXPECT_EQ(raster.grid.to_world[1], 250);
  EXPECT_EQ(raster.grid.to_world[0], 10000);
  EXPECT_EQ(raster.vertical.notes.size(), 2U);
}

}  // namespace
}  // namespace lode::io
