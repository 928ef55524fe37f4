#include <filesystem>
#include <fstream>
#include <random>

#include "tests/io/height_files.h"
#include "tests/io/height_reading.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::RasterFile;
using test::twelve;
using test::write_raster;

class height_reader : public test::HeightReading {};

TEST_F(height_reader, finds_missing_floats_by_the_decimals_of_their_files) {
  std::vector<double> samples = twelve(0.25);
  samples[3] = samples[8] = static_cast<double>(-9999.9F);
  write_raster((*this)("a.tif"), {.type = GDT_Float32, .samples = samples});
  EXPECT_EQ(read((*this)("a.tif")).grid.n_missing(), 0U);
  EXPECT_EQ(read((*this)("a.tif"), {.nodata = -9999.9}).grid.n_missing(), 2U);
  write_raster((*this)("scaled.tif"), {.type = GDT_Float32, .samples = samples, .scale = 0.1});
  EXPECT_EQ(read((*this)("scaled.tif"), {.nodata = -9999.9}).grid.n_missing(), 2U);
}

struct Kind {
  const char* name;
  const char* driver;
  GDALDataType type = GDT_Int16;
};

/// Beside GeoTIFF, PNG and ESRI ASCII, which other tests have.
constexpr std::array kKinds{Kind{"a.dt0", "DTED"},
                            Kind{"erdas.img", "HFA"},
                            Kind{"a.jp2", "JP2OpenJPEG"},
                            Kind{"a.sdat", "SAGA", GDT_Float32},
                            Kind{"ascii.grd", "GSAG", GDT_Float32},
                            Kind{"six.grd", "GSBG", GDT_Float32},
                            Kind{"seven.grd", "GS7BG", GDT_Float64},
                            Kind{"a.bt", "BT"},
                            Kind{"envi.dat", "ENVI"},
                            Kind{"envi.img", "ENVI", GDT_Float32},
                            Kind{"esri.bil", "EHdr"},
                            Kind{"float.flt", "EHdr", GDT_Float32},
                            Kind{"nameless", "GTiff"}};

/// A degree of 121 x 121 samples, as DTED has it.
RasterFile degree(GDALDataType type) {
  RasterFile raster{.n_columns = 121, .n_rows = 121, .type = type};
  for (int i = 0; i < 121 * 121; ++i) raster.samples.push_back((i * 7919) % 4001 - 100);
  constexpr double kStep = 1 / 120.0;
  raster.geotransform = {8 - kStep / 2, kStep, 0, 47 + kStep / 2, 0, -kStep};
  raster.epsg = 4326;
  return raster;
}

TEST_F(height_reader, reads_terrain_in_its_usual_formats) {
  for (const Kind& kind : kKinds) {
    SCOPED_TRACE(std::string(kind.name) + ", " + kind.driver);
    GDALAllRegister();
    ASSERT_NE(GDALGetDriverByName(kind.driver), nullptr);
    const std::string path = (*this)(kind.name);
    const RasterFile written = degree(kind.type);
    write_raster(path, written, kind.driver);
    EXPECT_TRUE(is_height_path(path));
    const HeightRaster raster = read(path);
    EXPECT_EQ(raster.format, kind.driver);
    EXPECT_EQ(raster.grid.n_columns, 121);
    EXPECT_EQ(raster.grid.n_rows, 121);
    EXPECT_EQ(raster.grid.n_missing(), 0U);
    expect_samples(raster.grid, written.samples);
    EXPECT_NEAR(raster.grid.world(0, 0)[0], 8, 1e-6);
    EXPECT_NEAR(raster.grid.world(0, 0)[1], 47, 1e-6);
    EXPECT_NEAR(raster.grid.world(120, 120)[0], 9, 1e-6);
    EXPECT_NEAR(raster.grid.world(120, 120)[1], 46, 1e-6);
  }
}

TEST_F(height_reader, refuses_grids_of_saga_that_are_to_be_multiplied) {
  GDALAllRegister();
  const std::string path = (*this)("a.sdat");
  write_raster(path, degree(GDT_Float32), "SAGA");
  std::string header;
  std::getline(std::ifstream((*this)("a.sgrd")), header, '\0');
  const std::size_t at = header.find("Z_FACTOR");
  ASSERT_NE(at, std::string::npos);
  header.erase(at, header.find('\n', at) + 1 - at);
  for (const char* factor : {"1", " 1.000000\r", "1e0"}) {
    std::ofstream((*this)("a.sgrd")) << header << "Z_FACTOR\t=" << factor << "\n";
    EXPECT_EQ(read(path).grid.n_columns, 121) << factor;
  }
  for (const char* factor : {"0.3048", " 10.000000\r", "x"}) {
    std::ofstream((*this)("a.sgrd")) << header << "z_factor\t= " << factor << "\n";
    EXPECT_NE(refusal(path).find("Z_FACTOR"), std::string::npos) << factor;
  }
}

TEST_F(height_reader, tells_what_is_no_terrain_by_content) {
  std::ofstream((*this)("scan.img")) << "a volume beside scan.hdr";
  std::ofstream((*this)("scan.hdr")) << std::string(348, ' ');
  EXPECT_FALSE(is_height_path((*this)("scan.img")));
  EXPECT_FALSE(is_height_path((*this)("absent.img")));
  std::ofstream((*this)("numbers.dat")) << "1 2 3";
  EXPECT_FALSE(is_height_path((*this)("numbers.dat")));
  write_raster((*this)("a.nrrd"), {.samples = twelve(1)});
  EXPECT_FALSE(is_height_path((*this)("a.nrrd"))) << "a name that says something else";
}

TEST_F(height_reader, survives_terrain_of_any_format_that_is_cut_off_or_changed) {
  std::mt19937_64 random(5);
  for (const Kind& kind : kKinds) {
    SCOPED_TRACE(std::string(kind.name) + ", " + kind.driver);
    GDALAllRegister();
    ASSERT_NE(GDALGetDriverByName(kind.driver), nullptr);
    const std::string path = (*this)(kind.name);
    write_raster(path, degree(kind.type), kind.driver);
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    for (int round = 0; round < 40; ++round) {
      const std::string changed =
          round < 10 ? bytes.substr(0, bytes.size() * static_cast<std::size_t>(round) / 10)
                     : test::mutated(bytes, random);
      std::ofstream(path, std::ios::binary) << changed;
      Progress progress;
      const auto raster = read_heights(path, {}, progress);
      if (!raster) EXPECT_TRUE(raster.error().message.starts_with(path)) << raster.error().message;
    }
  }
}

TEST_F(height_reader, keeps_samples_of_all_types_exactly) {
  const std::vector<double> bytes{0, 1, 2, 3, 4, 5, 6, 7, 128, 200, 254, 255};
  const std::vector<double> large{0, 1, 65535, 4, 5, 6, 7, 8, 40000, 10, 11, 32768};
  const std::vector<double> whole{
      -2147483648.0, 2147483647, 16777217, -16777217, 4, 5, 6, 7, 8, 9, 10, 11};
  const std::vector<double> tiny{1e-300, 0.1, 1e9 + 0.01, -1e9 - 0.01, 4, 5, 6, 7, 8, 9, 10, 11};
  for (const auto& [type, samples, name] : {std::tuple{GDT_Byte, bytes, "byte"},
                                            {GDT_Int16, twelve(-2730), "int16"},
                                            {GDT_UInt16, large, "uint16"},
                                            {GDT_Int32, whole, "int32"},
                                            {GDT_Float32, twelve(0.25), "float32"},
                                            {GDT_Float64, tiny, "float64"}}) {
    write_raster((*this)("a.tif"), {.type = type, .samples = samples});
    const HeightRaster raster = read((*this)("a.tif"));
    EXPECT_EQ(raster.type, name);
    EXPECT_EQ(raster.format, "GTiff");
    EXPECT_EQ(raster.grid.n_columns, 4);
    EXPECT_EQ(raster.grid.n_rows, 3);
    EXPECT_EQ(raster.grid.n_missing(), 0U);
    expect_samples(raster.grid, samples);
  }
}

TEST_F(height_reader, takes_samples_at_the_middle_of_pixels_whatever_area_or_point_says) {
  const std::array<double, 6> corner{1000, 30, 0, 5000, 0, -20};
  for (const bool is_point : {false, true}) {
    // Of both kinds GDAL is told the corner of the first pixel; files of the second kind store its
    // middle, which GDAL undoes.
    write_raster(
        (*this)("a.tif"),
        {.samples = twelve(1), .geotransform = corner, .epsg = 32611, .is_point = is_point});
    const HeightRaster raster = read((*this)("a.tif"));
    EXPECT_TRUE(raster.has_place);
    EXPECT_EQ(raster.grid.world(0, 0), (Vec<double, 2>{{1015, 4990}}));
    EXPECT_EQ(raster.grid.world(3, 2), (Vec<double, 2>{{1105, 4950}}));
    EXPECT_EQ(raster.grid.lattice(1105, 4950), (Vec<double, 2>{{3, 2}}));
    EXPECT_TRUE(raster.grid.is_mirrored());
    EXPECT_NE(raster.grid.crs.find("WGS 84 / UTM zone 11N"), std::string::npos);
  }
}

TEST_F(height_reader, puts_what_has_no_position_with_its_first_row_up) {
  write_raster((*this)("a.tif"), {.samples = twelve(1)});
  const HeightRaster raster = read((*this)("a.tif"));
  EXPECT_FALSE(raster.has_place);
  EXPECT_EQ(raster.grid.world(0, 0), (Vec<double, 2>{{0, 2}}));
  EXPECT_EQ(raster.grid.world(3, 2), (Vec<double, 2>{{3, 0}}));
}

TEST_F(height_reader, finds_what_is_missing) {
  std::vector<double> samples = twelve(0.5);
  samples[3] = -9999;
  samples[7] = std::numeric_limits<double>::quiet_NaN();
  samples[9] = std::numeric_limits<double>::infinity();
  write_raster((*this)("a.tif"), {.type = GDT_Float32, .samples = samples, .nodata = -9999});
  const HeightGrid marked = read((*this)("a.tif")).grid;
  EXPECT_EQ(marked.n_missing(), 3U);
  EXPECT_FALSE(marked.has_height(3, 0));
  EXPECT_FALSE(marked.has_height(3, 1));
  EXPECT_FALSE(marked.has_height(1, 2));
  const HeightGrid chosen = read((*this)("a.tif"), {.nodata = samples[0]}).grid;
  EXPECT_EQ(chosen.n_missing(), 3U) << "--nodata stands instead of the file's";
  EXPECT_FALSE(chosen.has_height(0, 0));
  EXPECT_TRUE(chosen.has_height(3, 0));
}

TEST_F(height_reader, chooses_bands_and_applies_scale_and_offset) {
  write_raster((*this)("a.tif"),
               {.samples = twelve(3), .n_bands = 2, .scale = 0.5, .offset = 10, .unit = "ft"});
  std::vector<double> expected = twelve(3);
  for (double& z : expected) z = (z + 1000) * 0.5 + 10;
  const HeightRaster raster = read((*this)("a.tif"), {.band = 2});
  expect_samples(raster.grid, expected);
  EXPECT_EQ(raster.grid.vertical_unit, "ft");
  EXPECT_NE(refusal((*this)("a.tif"), {.band = 3}).find("from 1 to 2"), std::string::npos);
}

TEST_F(height_reader, reads_esri_ascii) {
  std::ofstream((*this)("a.asc")) << "ncols 4\nnrows 3\nxllcenter 100\nyllcenter 200\ncellsize 10\n"
                                     "nodata_value -1\n1 2 3 4\n5 -1 7 8\n9 10 11 12\n";
  const HeightRaster raster = read((*this)("a.asc"));
  EXPECT_EQ(raster.grid.n_missing(), 1U);
  EXPECT_EQ(raster.grid.height(3, 2), 12);
  EXPECT_EQ(raster.grid.world(0, 2), (Vec<double, 2>{{100, 200}}));
  EXPECT_EQ(raster.grid.world(3, 0), (Vec<double, 2>{{130, 220}}));
}

TEST_F(height_reader, decodes_colours) {
  RasterFile picture{.type = GDT_Byte, .samples = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
  // Bands add 1000 and are cut to a byte's 255.
  picture.n_bands = 3;
  write_raster((*this)("a.png"), picture, "PNG");
  const HeightRaster rgb = read((*this)("a.png"), {.encoding = HeightEncoding::terrain_rgb});
  EXPECT_EQ(rgb.grid.height(2, 0), (65536 * 3 + 256 * 255 + 255 - 100000) / 10.0);
  EXPECT_EQ(rgb.grid.vertical_unit, "m");
  const HeightRaster terrarium = read((*this)("a.png"), {.encoding = HeightEncoding::terrarium});
  EXPECT_EQ(terrarium.grid.height(2, 0), 256 * 3 + 255 - 32768 + 255 / 256.0);
  EXPECT_NE(refusal((*this)("a.png")).find("terrain-rgb or terrarium"), std::string::npos);
  picture.type = GDT_UInt16;
  write_raster((*this)("wide.tif"), picture);
  EXPECT_NE(
      refusal((*this)("wide.tif"), {.encoding = HeightEncoding::terrarium}).find("got UInt16"),
      std::string::npos);
  write_raster((*this)("gray.tif"), {.samples = twelve(1)});
  EXPECT_NE(
      refusal((*this)("gray.tif"), {.encoding = HeightEncoding::terrarium}).find("three bands"),
      std::string::npos);
}

std::string hgt_bytes(int side) {
  std::string bytes;
  for (int i = 0; i < side * side; ++i) {
    const int z = i == 4 ? -32768 : 3 * i - 20;
    bytes += static_cast<char>((z >> 8) & 0xff);
    bytes += static_cast<char>(z & 0xff);
  }
  return bytes;
}

TEST_F(height_reader, reads_srtm_tiles_by_their_names) {
  std::ofstream((*this)("S05W171.hgt")) << hgt_bytes(5);
  const HeightRaster raster = read((*this)("S05W171.hgt"));
  EXPECT_EQ(raster.format, "HGT");
  EXPECT_EQ(raster.grid.n_rows, 5);
  EXPECT_EQ(raster.grid.n_missing(), 1U);
  EXPECT_FALSE(raster.grid.has_height(4, 0));
  EXPECT_EQ(raster.grid.height(0, 1), -5);
  EXPECT_EQ(raster.grid.world(0, 4), (Vec<double, 2>{{-171, -5}}));
  EXPECT_EQ(raster.grid.world(4, 0), (Vec<double, 2>{{-170, -4}}));
  std::ofstream((*this)("here.hgt")) << hgt_bytes(5);
  EXPECT_NE(refusal((*this)("here.hgt")).find("N46W123"), std::string::npos);
  for (const std::size_t n : {49U, 48U, 1U}) {
    std::ofstream((*this)("S05W171.hgt")) << hgt_bytes(5).substr(0, n);
    EXPECT_NE(refusal((*this)("S05W171.hgt")).find("square"), std::string::npos);
  }
}

TEST_F(height_reader, refuses_what_is_no_raster) {
  EXPECT_NE(refusal((*this)("absent.tif")).find("absent.tif"), std::string::npos);
  std::ofstream((*this)("empty.tif"));
  (void)refusal((*this)("empty.tif"));
  std::ofstream((*this)("text.tif")) << "not a raster at all";
  EXPECT_NE(refusal((*this)("text.tif")).find("expected a GeoTIFF"), std::string::npos);
  std::filesystem::create_directory((*this)("folder.tif"));
  (void)refusal((*this)("folder.tif"));
  EXPECT_FALSE(is_height_path("scan.nrrd"));
  EXPECT_TRUE(is_height_path("A.TIF"));
  EXPECT_TRUE(is_height_path("N00E010.hgt.gz"));
}

TEST_F(height_reader, refuses_claims_that_the_file_cannot_justify) {
  // 200,000 squared 16-bit samples of which the file has none.
  GDALAllRegister();
  const std::array<const char*, 5> sparse{"SPARSE_OK=TRUE", "BIGTIFF=YES", "TILED=YES",
                                          "BLOCKXSIZE=4096", "BLOCKYSIZE=4096"};
  std::array<char*, 6> options{};
  for (std::size_t i = 0; i < sparse.size(); ++i) options[i] = const_cast<char*>(sparse[i]);
  const std::string path = (*this)("huge.tif");
  GDALClose(GDALCreate(GDALGetDriverByName("GTiff"), path.c_str(), 200000, 200000, 1, GDT_Int16,
                       options.data()));
  EXPECT_NE(refusal(path).find("200000 x 200000"), std::string::npos);
}

TEST_F(height_reader, survives_files_that_are_cut_off_or_changed) {
  std::vector<double> samples;
  for (int i = 0; i < 64 * 64; ++i) samples.push_back((i * 7919) % 4001);
  for (const bool is_compressed : {false, true}) {
    const std::string path = (*this)("a.tif");
    write_raster(path, {.n_columns = 64,
                        .n_rows = 64,
                        .samples = samples,
                        .geotransform = std::array<double, 6>{0, 1, 0, 0, 0, -1},
                        .nodata = 5,
                        .is_compressed = is_compressed});
    std::ifstream file(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    const std::string damaged = (*this)("b.tif");
    std::mt19937_64 random(3);
    for (int round = 0; round < 300; ++round) {
      const std::string changed =
          round < 40 ? bytes.substr(0, bytes.size() * static_cast<std::size_t>(round) / 40)
                     : test::mutated(bytes, random);
      std::ofstream(damaged, std::ios::binary) << changed;
      Progress progress;
      const auto raster = read_heights(damaged, {}, progress);
      if (raster) {
        EXPECT_GT(raster->grid.n_samples(), 0);
      } else {
        EXPECT_TRUE(raster.error().message.starts_with(damaged)) << raster.error().message;
      }
    }
  }
}

struct RealRaster {
  const char* name;
  std::int32_t n_columns, n_rows;
  double lower, upper;
  std::uint64_t n_missing;
  const char* crs;
  HeightEncoding encoding = HeightEncoding::none;
};

class real_rasters : public testing::TestWithParam<RealRaster> {};

TEST_P(real_rasters, are_what_their_readme_says) {
  const RealRaster& real = GetParam();
  const std::string path = (test::data_directory() / "terrain" / real.name).string();
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is absent; set LODE_DATA";
  Progress progress;
  const auto raster = read_heights(path, {.encoding = real.encoding}, progress);
  ASSERT_TRUE(raster) << raster.error().message;
  EXPECT_EQ(raster->grid.n_columns, real.n_columns);
  EXPECT_EQ(raster->grid.n_rows, real.n_rows);
  EXPECT_EQ(raster->grid.n_missing(), real.n_missing);
  EXPECT_NE(raster->grid.crs.find(real.crs), std::string::npos) << raster->grid.crs;
  const HeightRange range = height_range(raster->grid);
  // The README gives two decimals, of floats.
  EXPECT_NEAR(range.lower, real.lower, 0.006);
  EXPECT_NEAR(range.upper, real.upper, 0.006);
}

INSTANTIATE_TEST_SUITE_P(
    terrain, real_rasters,
    testing::Values(
        RealRaster{"st_helens_327x468_int16.tif", 327, 468, 682, 2543, 4151,
                   "NAD27 / UTM zone 10N"},
        RealRaster{"big_tujunga_1197x643_int16.tif", 1197, 643, 315, 2295, 0, "UTM zone 11N"},
        RealRaster{"gabilan_lidar_921x859_float32.tif", 921, 859, 187.9, 307.28, 0, "UTM"},
        RealRaster{"trinidad_co_2401x1201_float32.tif", 2401, 1201, 4457.52, 14176.16, 0, "WGS 84"},
        RealRaster{"etopo5_4320x2161_int16.tif", 4320, 2161, -10376, 7833, 0, "WGS 84"},
        RealRaster{"N00E010_1201x1201_int16be.hgt.gz", 1201, 1201, 1, 1005, 0, "WGS 84"},
        RealRaster{"fuji_terrain_rgb_512x512.png", 512, 512, 13.7, 3751, 0, "",
                   HeightEncoding::terrain_rgb}),
    [](const auto& real) {
      std::string name = real.param.name;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
      return name;
    });

}  // namespace
}  // namespace lode::io
