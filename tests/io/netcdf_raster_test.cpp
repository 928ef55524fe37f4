// What is read of netCDF, held against what was written, and against the same raster as GeoTIFF.
#include <algorithm>
#include <cmath>
#include <utility>

#include "lode/io/height_stream.h"
#include "tests/io/height_files.h"
#include "tests/io/netcdf_reading.h"
#include "tests/oracles/trials.h"

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

class netcdf_raster : public test::NetcdfReading {
 protected:
  /// Of each library beneath one, in a fast run.
  static std::vector<int> formats() {
    return oracles::trials<std::vector<int>>({kNetcdfFormats.begin(), kNetcdfFormats.end()},
                                             {0, NC_NETCDF4});
  }
};

TEST_F(netcdf_raster, is_what_the_same_raster_is_as_geotiff) {
  constexpr std::array kTypes{std::pair{NC_UBYTE, GDT_Byte},    std::pair{NC_SHORT, GDT_Int16},
                              std::pair{NC_USHORT, GDT_UInt16}, std::pair{NC_INT, GDT_Int32},
                              std::pair{NC_UINT, GDT_UInt32},   std::pair{NC_INT64, GDT_Int64},
                              std::pair{NC_UINT64, GDT_UInt64}, std::pair{NC_FLOAT, GDT_Float32},
                              std::pair{NC_DOUBLE, GDT_Float64}};
  constexpr int kNodata = 200;
  for (const auto& [type, gdal_type] : kTypes)
    for (const double scale : {1.0, 0.1}) {
      // Of scaled ones integers and floats.
      if (!oracles::trials(true, scale == 1 || type == NC_SHORT || type == NC_FLOAT)) continue;
      SCOPED_TRACE(std::to_string(type) + ", " + std::to_string(scale));
      NetcdfFile file = alps();
      const bool is_float = type == NC_FLOAT || type == NC_DOUBLE;
      for (double& z : file.samples) z = std::abs(z) / 2 + (is_float ? 0.1 : 0);
      if (!is_float)
        for (double& z : file.samples) z = std::floor(z);
      file.samples[5] = kNodata;
      file.type = type;
      file.define = [&, t = type](int nc, int z) {
        set_number(nc, z, "_FillValue", t, kNodata);
        set_text(nc, z, "units", "feet");
        if (scale == 1) return;
        set_number(nc, z, "scale_factor", NC_DOUBLE, scale);
        set_number(nc, z, "add_offset", NC_DOUBLE, -400.3);
      };
      const double offset = scale == 1 ? 0 : -400.3;
      RasterFile tiff{.type = gdal_type, .samples = file.samples};
      tiff.geotransform = {9.875, 0.25, 0, 47.125, 0, -0.25};
      tiff.epsg = 4326;
      tiff.scale = scale;
      tiff.offset = offset;
      tiff.unit = "feet";
      if (type == NC_INT64)
        tiff.nodata64 = kNodata;
      else
        tiff.nodata = kNodata;
      write_raster((*this)("a.tif"), tiff);
      const HeightRaster ours = read(write(file), {.crs = "EPSG:4326"});
      const HeightRaster theirs = read((*this)("a.tif"));
      expect_equal(ours.grid, theirs.grid);
      EXPECT_EQ(ours.type, theirs.type);
      EXPECT_EQ(ours.form.nodata, theirs.form.nodata);
      EXPECT_EQ(ours.form.geotransform, theirs.form.geotransform);
      EXPECT_EQ(ours.grid.n_missing(), 1U);
    }
}

TEST_F(netcdf_raster, has_signed_and_unsigned_bytes) {
  NetcdfFile file = alps();
  file.type = NC_BYTE;
  file.samples = twelve(11);
  file.samples[2] = -128;
  HeightRaster raster = read(write(file));
  EXPECT_EQ(raster.type, "int8");
  EXPECT_EQ(raster.grid.n_missing(), 0U) << "bytes have no usual fill value";
  expect_samples(raster.grid, file.samples);
  file.format = 0;
  file.define = [](int nc, int z) { set_text(nc, z, "_Unsigned", "true"); };
  raster = read(write(file));
  EXPECT_EQ(raster.type, "byte");
  for (double& z : file.samples) z += z < 0 ? 256 : 0;
  expect_samples(raster.grid, file.samples);
  file.define = [](int nc, int z) {
    set_text(nc, z, "_Unsigned", "true");
    set_number(nc, z, "_FillValue", NC_BYTE, -128);
  };
  for (double& z : file.samples) z -= z > 127 ? 256 : 0;
  EXPECT_EQ(read(write(file)).grid.n_missing(), 1U);
  file.define = [](int nc, int z) {
    set_text(nc, z, "_Unsigned", "true");
    const std::array<signed char, 2> range{0, -8};  // up to 248
    nc_put_att_schar(nc, z, "valid_range", NC_BYTE, 2, range.data());
  };
  EXPECT_EQ(read(write(file)).grid.n_missing(), 1U);
}

TEST_F(netcdf_raster, lacks_what_its_file_says_is_missing) {
  NetcdfFile file = alps();
  file.type = NC_FLOAT;
  const double usual = static_cast<double>(NC_FILL_FLOAT);
  file.samples = {1, 2, 3, usual, -5, -6, std::nan(""), 8, 9, 10, 11, 12};
  EXPECT_EQ(read(write(file)).grid.n_missing(), 2U);
  file.define = [](int nc, int z) { set_number(nc, z, "_FillValue", NC_FLOAT, -5); };
  EXPECT_EQ(read(write(file)).grid.n_missing(), 2U);
  file.define = [](int nc, int z) {
    set_number(nc, z, "_FillValue", NC_FLOAT, -5);
    const std::array<float, 2> more{-6, 12};
    nc_put_att_float(nc, z, "missing_value", NC_FLOAT, 2, more.data());
    set_number(nc, z, "valid_min", NC_FLOAT, 2);
    set_number(nc, z, "valid_max", NC_FLOAT, 10);
  };
  // -5, -6, NaN, 1, 11, 12, and what libnetcdf fills with, which is above 10.
  EXPECT_EQ(read(write(file)).grid.n_missing(), 7U);
  // Which is instead of all that the file says.
  EXPECT_EQ(read(write(file), {.nodata = 9}).grid.n_missing(), 2U);
  file.type = NC_BYTE;
  file.samples = twelve(1);
  file.define = [](int nc, int z) {
    const std::array<signed char, 2> range{-6, 3};
    nc_put_att_schar(nc, z, "valid_range", NC_BYTE, 2, range.data());
  };
  EXPECT_EQ(read(write(file)).grid.n_missing(), 2U);
  // A range in heights, of stored numbers that are scaled.
  file.type = NC_SHORT;
  file.define = [](int nc, int z) {
    set_number(nc, z, "scale_factor", NC_DOUBLE, 0.5);
    set_number(nc, z, "valid_max", NC_DOUBLE, 1.0);
  };
  EXPECT_EQ(read(write(file)).grid.n_missing(), 2U);
}

/// Samples at the bounds count, though bounds are of another type and round otherwise.
TEST_F(netcdf_raster, has_samples_at_the_ends_of_its_range) {
  NetcdfFile file = alps();
  file.type = NC_FLOAT;
  file.samples = places(-10.1, 0.3, 12);
  file.define = [](int nc, int z) {
    set_number(nc, z, "valid_min", NC_DOUBLE, -10.1);
    set_number(nc, z, "valid_max", NC_DOUBLE, -6.8);
  };
  EXPECT_EQ(read(write(file)).grid.n_missing(), 0U);
  file.type = NC_SHORT;
  file.samples = places(28, 1, 12);
  for (const double scale : {0.1, -0.1}) {
    file.define = [&](int nc, int z) {
      set_number(nc, z, "scale_factor", NC_DOUBLE, scale);
      set_number(nc, z, scale > 0 ? "valid_max" : "valid_min", NC_DOUBLE, scale > 0 ? 3.3 : -3.3);
    };
    EXPECT_EQ(read(write(file)).grid.n_missing(), 6U) << scale;  // 34 to 39
  }
}

TEST_F(netcdf_raster, holds_integers_of_64_bits_exactly) {
  NetcdfFile file = alps();
  file.type = NC_INT64;
  file.add = [](int nc, int z) {
    const std::size_t at[] = {0, 0};
    const long long large = 9007199254740991;
    nc_put_var1_longlong(nc, z, at, &large);
  };
  EXPECT_EQ(read(write(file)).grid.height(0, 0), 9007199254740991.0);
  file.add = [](int nc, int z) {
    const std::size_t at[] = {1, 2};
    const long long large = 9007199254740993;
    nc_put_var1_longlong(nc, z, at, &large);
  };
  EXPECT_NE(refused(file).find("9007199254740993 in column 2, row 1"), std::string::npos);
}

TEST_F(netcdf_raster, is_of_the_variable_that_was_chosen) {
  NetcdfFile file = alps();
  const auto add_more = [](int nc, int z) {
    int dimensions[2] = {};
    nc_inq_vardimid(nc, z, dimensions);
    int other = -1;
    nc_redef(nc);
    nc_def_var(nc, "tid", NC_BYTE, 2, dimensions, &other);
    // What only says where others are does not count.
    int table = -1;
    int pair = -1;
    nc_def_dim(nc, "nv", 2, &pair);
    const int bounds[2] = {dimensions[0], pair};
    nc_def_var(nc, "lat_bnds", NC_DOUBLE, 2, bounds, &table);
    nc_enddef(nc);
    const std::vector<signed char> samples(12, 7);
    nc_put_var_schar(nc, other, samples.data());
  };
  file.add = add_more;
  for (const int format : formats()) {
    file.format = format;
    const std::string path = write(file);
    const std::string said = refusal(path);
    EXPECT_NE(said.find("--variable"), std::string::npos) << said;
    EXPECT_NE(said.find("z, tid"), std::string::npos) << said;
    EXPECT_EQ(said.find("lat_bnds"), std::string::npos) << said;
    expect_samples(read(path, {.variable = "z"}).grid, file.samples);
    EXPECT_EQ(read(path, {.variable = "tid"}).grid.height(3, 2), 7);
    EXPECT_NE(refusal(path, {.variable = "depth"}).find("expected a variable 'depth', got z, tid"),
              std::string::npos);
    EXPECT_NE(refusal(path, {.variable = "lat"}).find("over two dimensions"), std::string::npos);
  }
  // In groups.
  file.format = NC_NETCDF4;
  file.add = [](int nc, int z) {
    int dimensions[2] = {};
    nc_inq_vardimid(nc, z, dimensions);
    int group = -1;
    int inner = -1;
    nc_def_grp(nc, "deep", &group);
    nc_def_var(group, "z", NC_SHORT, 2, dimensions, &inner);
    const std::vector<short> samples(12, 77);
    nc_put_var_short(group, inner, samples.data());
  };
  const std::string path = write(file);
  EXPECT_NE(refusal(path).find("z, deep/z"), std::string::npos);
  const HeightRaster inner = read(path, {.variable = "deep/z"});
  EXPECT_EQ(inner.grid.height(1, 1), 77);
  EXPECT_EQ(inner.grid.world(0, 0)[1], 47);
  EXPECT_EQ(read(path, {.variable = "/z"}).grid.height(0, 0), -7);
  write_raster((*this)("a.tif"), {.samples = twelve(1)});
  EXPECT_NE(refusal((*this)("a.tif"), {.variable = "z"}).find("expected a netCDF file"),
            std::string::npos);
}

TEST_F(netcdf_raster, is_of_the_layer_that_was_chosen) {
  for (const int format : formats()) {
    NetcdfFile file = alps();
    file.format = format;
    file.n_layers = 1;
    expect_samples(read(write(file)).grid, twelve(25));
    file.n_layers = 3;
    for (int i = 12; i < 36; ++i) file.samples.push_back(i);
    const std::string path = write(file);
    const std::string said = refusal(path);
    EXPECT_NE(said.find("expected --band 1 to 3, which layer of z along time"), std::string::npos)
        << said;
    EXPECT_EQ(read(path, {.band = 1}).grid.height(0, 0), -7);
    EXPECT_EQ(read(path, {.band = 3}).grid.height(3, 2), 35);
    EXPECT_NE(refusal(path, {.band = 4}).find("from 1 to 3"), std::string::npos);
  }
}

TEST_F(netcdf_raster, is_a_stream_as_well) {
  NetcdfFile file = alps();
  std::reverse(file.y.begin(), file.y.end());
  file.samples[4] = NC_FILL_SHORT;
  Progress progress;
  auto opened = HeightStream::open(write(file), {}, progress);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->raster().format, "netCDF");
  EXPECT_EQ(opened->raster().vertical.notes.size(), 1U);
  EXPECT_EQ(opened->n_bytes(), 24U);
  auto stream = std::move(*opened).with_vertical({.declared = "EPSG:5773", .target = {}}, progress);
  ASSERT_TRUE(stream);
  EXPECT_EQ(vertical_name(stream->raster().grid.crs), "EGM96 height");
  std::vector<double> rows(8);
  ASSERT_TRUE(stream->read(1, 2, rows));
  EXPECT_TRUE(std::isnan(rows[0]));
  for (std::size_t i = 1; i < 4; ++i) EXPECT_EQ(rows[i], file.samples[4 + i]);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(rows[4 + i], file.samples[i]);
}

TEST_F(netcdf_raster, says_what_grows_downwards) {
  NetcdfFile file = alps();
  file.variable = "depth";
  file.define = [](int nc, int z) { set_text(nc, z, "positive", "down"); };
  const HeightRaster raster = read(write(file), {.crs = "EPSG:4326"});
  ASSERT_EQ(raster.vertical.notes.size(), 1U);
  EXPECT_NE(raster.vertical.notes[0].find("depth grows downwards"), std::string::npos);
}

TEST_F(netcdf_raster, is_told_by_its_content) {
  const std::string path = write(alps());
  for (const char* name : {"b.nc4", "b.cdf", "b.grd", "gebco", "b.bin", "B.NC"}) {
    std::filesystem::copy_file(path, (*this)(name));
    EXPECT_TRUE(is_height_path((*this)(name))) << name;
    expect_samples(read((*this)(name)).grid, twelve(25));
  }
  // Of the variable x_range and z along one dimension, as GMT wrote before version 4.
  NetcdfFile old = alps();
  old.variable = "x_range";
  old.type = NC_CHAR;
  old.samples.clear();
  EXPECT_NE(refused(old).find("GMT before version 4"), std::string::npos);
}

}  // namespace
}  // namespace lode::io
