#include "lode/api/terrain_raster.h"

#include <cpl_error.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "lode/api/files.h"
#include "tests/io/height_files.h"
#include "tests/oracles/random.h"

namespace lode {
namespace {

using io::test::RasterFile;

constexpr double kNorthUp[] = {500000.1, 30, 0, 4000000.7, 0, -30};

double hills(int x, int y) {
  return std::round(800 * std::sin(0.17 * x) * std::cos(0.13 * y) + 30 * std::sin(1.3 * x + y));
}

std::vector<double> samples_of(int n_columns, int n_rows, double (*height)(int, int)) {
  std::vector<double> samples;
  for (int y = 0; y < n_rows; ++y)
    for (int x = 0; x < n_columns; ++x) samples.push_back(height(x, y));
  return samples;
}

/// A raster as GDAL reads it.
struct ReadRaster {
  int n_columns = 0;
  int n_rows = 0;
  GDALDataType type = GDT_Unknown;
  std::vector<double> samples;
  std::vector<std::uint8_t> mask;
  std::array<double, 6> geotransform{};
  bool has_position = false;
  bool is_point = false;
  std::string crs;
  std::string unit;
  double nodata = 0;
  std::string compression;
};

ReadRaster read_back(const std::string& path) {
  GDALAllRegister();
  ReadRaster read;
  GDALDatasetH dataset = GDALOpen(path.c_str(), GA_ReadOnly);
  EXPECT_NE(dataset, nullptr) << path;
  if (dataset == nullptr) return read;
  GDALRasterBandH band = GDALGetRasterBand(dataset, 1);
  read.n_columns = GDALGetRasterXSize(dataset);
  read.n_rows = GDALGetRasterYSize(dataset);
  read.type = GDALGetRasterDataType(band);
  const auto n = static_cast<std::size_t>(read.n_columns) * static_cast<std::size_t>(read.n_rows);
  read.samples.resize(n);
  read.mask.resize(n);
  const auto take = [&](GDALRasterBandH from, void* to, GDALDataType type) {
    EXPECT_EQ(GDALRasterIO(from, GF_Read, 0, 0, read.n_columns, read.n_rows, to, read.n_columns,
                           read.n_rows, type, 0, 0),
              CE_None);
  };
  take(band, read.samples.data(), GDT_Float64);
  take(GDALGetMaskBand(band), read.mask.data(), GDT_Byte);
  read.has_position = GDALGetGeoTransform(dataset, read.geotransform.data()) == CE_None;
  const char* pixel = GDALGetMetadataItem(dataset, "AREA_OR_POINT", nullptr);
  read.is_point = pixel != nullptr && std::string(pixel) == "Point";
  read.crs = GDALGetProjectionRef(dataset);
  read.unit = GDALGetRasterUnitType(band);
  read.nodata = GDALGetRasterNoDataValue(band, nullptr);
  const char* codec = GDALGetMetadataItem(dataset, "COMPRESSION", "IMAGE_STRUCTURE");
  read.compression = codec == nullptr ? "" : codec;
  GDALClose(dataset);
  return read;
}

/// A directory that is gone when the test is.
class terrain_raster : public testing::Test {
 protected:
  terrain_raster()
      : directory_(std::filesystem::temp_directory_path() /
                   ("lode_terrain_raster_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(directory_);
  }
  ~terrain_raster() override { std::filesystem::remove_all(directory_); }
  terrain_raster(const terrain_raster&) = delete;
  terrain_raster& operator=(const terrain_raster&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_ / name).string();
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(directory_))
      names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
  }
  OpenedTerrain open(const std::string& file, const TerrainReadOptions& options = {}) {
    auto opened = open_terrain(file, options, {}, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    return *std::move(opened);
  }
  TerrainRasterReport write(const OpenedTerrain& opened, double max_error,
                            const TerrainRasterOptions& wanted = {}) {
    auto made =
        write_terrain_raster(opened, {.max_error = max_error}, wanted, path("out.tif"), progress_);
    EXPECT_TRUE(made) << made.error().message;
    return made ? *made : TerrainRasterReport{};
  }
  /// Writes, goes the whole way, and holds what comes back against what was written.
  void check(const RasterFile& raster, double max_error, GDALDataType expected_type);

  std::filesystem::path directory_;
  Progress progress_;
};

/// Heights of the TIN by trying every triangle at every sample.
std::vector<double> heights_by_trying(const OpenedTerrain& opened, double max_error) {
  Progress progress;
  const auto made = extract_terrain(opened.terrain, {.max_error = max_error}, progress);
  EXPECT_TRUE(made);
  const HeightFrame& frame = opened.facts.frame;
  std::vector<double> heights(
      static_cast<std::size_t>(frame.n_columns) * static_cast<std::size_t>(frame.n_rows),
      std::numeric_limits<double>::quiet_NaN());
  const Surface& surface = made->surface;
  for (const auto& corner : surface.triangles) {
    std::array<std::array<std::int64_t, 2>, 3> at{};
    std::array<long double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3d world = surface.world_position(corner[i]);
      const auto place = frame.lattice(world[0], world[1]);
      at[i] = {std::lround(place[0]), std::lround(place[1])};
      z[i] = surface.values[corner[i]];
    }
    const auto area = [](const auto& a, const auto& b, const auto& c) {
      return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    };
    const std::int64_t whole = area(at[0], at[1], at[2]);
    for (std::int64_t y = 0; y < frame.n_rows; ++y)
      for (std::int64_t x = 0; x < frame.n_columns; ++x) {
        const std::array p{x, y};
        const std::array weight{area(at[1], at[2], p), area(at[2], at[0], p),
                                area(at[0], at[1], p)};
        if (std::ranges::any_of(weight, [&](std::int64_t w) { return whole > 0 ? w < 0 : w > 0; }))
          continue;
        long double sum = 0;
        for (std::size_t i = 0; i < 3; ++i) sum += static_cast<long double>(weight[i]) * z[i];
        heights[static_cast<std::size_t>(y * frame.n_columns + x)] =
            static_cast<double>(sum / static_cast<long double>(whole));
      }
  }
  return heights;
}

void terrain_raster::check(const RasterFile& raster, double max_error, GDALDataType expected_type) {
  const std::string in = path("in.tif");
  io::test::write_raster(in, raster);
  const OpenedTerrain opened = open(in);
  const TerrainRasterReport report = write(opened, max_error, {.difference = path("less.tif")});
  const ReadRaster before = read_back(in);
  const ReadRaster after = read_back(path("out.tif"));
  const ReadRaster less = read_back(path("less.tif"));
  EXPECT_EQ(after.type, expected_type);
  EXPECT_EQ(after.compression, "DEFLATE");
  for (const ReadRaster* one : {&after, &less}) {
    EXPECT_EQ(one->n_columns, before.n_columns);
    EXPECT_EQ(one->n_rows, before.n_rows);
    EXPECT_EQ(one->has_position, before.has_position);
    EXPECT_EQ(one->geotransform, before.geotransform);
    EXPECT_EQ(one->is_point, before.is_point);
    EXPECT_EQ(one->crs, before.crs);
    EXPECT_EQ(one->unit, before.unit);
  }
  if (raster.nodata) {
    EXPECT_EQ(after.nodata, *raster.nodata);
  }
  const std::vector<double> expected = heights_by_trying(opened, max_error);
  double worst = 0;
  std::uint64_t n_heights = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    ASSERT_EQ(after.mask[i] != 0, !std::isnan(expected[i])) << "sample " << i;
    ASSERT_EQ(less.mask[i] != 0, !std::isnan(expected[i])) << "sample " << i;
    if (std::isnan(expected[i])) continue;
    const double sample = before.samples[i] * raster.scale + raster.offset;
    worst = std::max(worst, std::abs(after.samples[i] - sample));
    ++n_heights;
    // A unit of the type, to keep the error; of float64 of what heights are summed of.
    const double unit = expected_type == GDT_Float32 ? 0x1p-23 : 0x1p-43;
    EXPECT_LE(std::abs(after.samples[i] - expected[i]), unit * (std::abs(expected[i]) + 1));
    EXPECT_NEAR(less.samples[i], after.samples[i] - sample, 0x1p-23 * max_error);
    EXPECT_LE(std::abs(less.samples[i]), max_error);
  }
  EXPECT_EQ(report.error_kind, RasterErrorKind::measured);
  EXPECT_EQ(report.error, worst);
  EXPECT_LE(worst, max_error);
  EXPECT_EQ(report.n_heights, n_heights);
  EXPECT_EQ(files(), (std::vector<std::string>{"in.tif", "less.tif", "out.tif"}));
}

TEST_F(terrain_raster, is_on_the_grid_of_whole_numbers_and_within_the_error_at_every_sample) {
  RasterFile raster{.n_columns = 90,
                    .n_rows = 70,
                    .samples = samples_of(90, 70, hills),
                    .geotransform = std::to_array(kNorthUp),
                    .nodata = -9999,
                    .epsg = 32633,
                    .unit = "m"};
  check(raster, 40, GDT_Float32);
  check(raster, 0, GDT_Float32);
  raster.is_point = true;
  check(raster, 40, GDT_Float32);
}

TEST_F(terrain_raster, keeps_the_error_of_floats_after_rounding) {
  oracles::Random random(5);
  RasterFile raster{.n_columns = 80, .n_rows = 60, .type = GDT_Float32, .epsg = 32633};
  for (int i = 0; i < 80 * 60; ++i)
    raster.samples.push_back(static_cast<float>(5000 + hills(i % 80, i / 80) +
                                                0.001 * static_cast<double>(random.below(1000))));
  raster.geotransform = std::to_array(kNorthUp);
  for (const double max_error : {25.0, 3.1, 0.01, 0.0004, 0.0})
    check(raster, max_error, GDT_Float32);
}

/// Where the nearest float is farther from such a sample than the TIN, one beside it is not.
TEST_F(terrain_raster, needs_no_float64_for_floats_and_whole_numbers) {
  oracles::Random random(9);
  for (int round = 0; round < 150; ++round) {
    RasterFile raster{.n_columns = 9, .n_rows = 7};
    if (round % 2 == 0) raster.type = GDT_Float32;
    for (int i = 0; i < 63; ++i) {
      const auto whole = static_cast<double>(random.below(3000)) - 1000;
      const double part = raster.type == GDT_Float32 ? random.uniform() : 0;
      raster.samples.push_back(static_cast<float>(whole + part));
    }
    io::test::write_raster(path("in.tif"), raster);
    const double max_error = random.uniform(0, 1500);
    const TerrainRasterReport report = write(open(path("in.tif")), max_error);
    ASSERT_EQ(report.type, RasterType::float32) << "round " << round;
    ASSERT_LE(report.error, report.terrain.achieved_error);
  }
}

TEST_F(terrain_raster, is_of_float64_where_no_float32_keeps_the_error) {
  RasterFile raster{.n_columns = 40,
                    .n_rows = 30,
                    .samples = samples_of(40, 30, hills),
                    .geotransform = std::to_array(kNorthUp),
                    .scale = 0.1,
                    .offset = 1000};
  check(raster, 4, GDT_Float32);
  check(raster, 0, GDT_Float64);
  raster.type = GDT_Float64;
  raster.scale = 1;
  raster.offset = 0;
  for (double& z : raster.samples) z += 1.0 / 3;
  check(raster, 1e-9, GDT_Float64);
}

TEST_F(terrain_raster, turns_and_mirrors_as_the_raster_does) {
  RasterFile raster{.n_columns = 60, .n_rows = 40, .samples = samples_of(60, 40, hills)};
  raster.geotransform = {500000.1, 30, 0, 4000000.7, 0, 30};  // South is up.
  check(raster, 40, GDT_Float32);
  raster.geotransform = {500000.1, 20, 15, 4000000.7, 15, -20};  // Turned.
  check(raster, 40, GDT_Float32);
  raster.is_point = true;
  check(raster, 40, GDT_Float32);
  raster.geotransform = std::nullopt;  // Nowhere.
  raster.is_point = false;
  check(raster, 40, GDT_Float32);
}

TEST_F(terrain_raster, of_four_samples_and_round_islands_of_missing_ones) {
  check({.n_columns = 2, .n_rows = 2, .samples = {3, 1, 4, 1}}, 0, GDT_Float32);
  RasterFile raster{.n_columns = 50,
                    .n_rows = 40,
                    .samples = samples_of(50, 40, hills),
                    .geotransform = std::to_array(kNorthUp),
                    .nodata = -32768};
  for (const int at : {0, 51, 52, 53, 101, 102, 103, 777, 1999, 50 * 20 + 24, 50 * 21 + 26})
    raster.samples[static_cast<std::size_t>(at)] = -32768;
  check(raster, 60, GDT_Float32);
}

TEST_F(terrain_raster, is_whole_across_tiles_whatever_the_number_of_threads) {
  const RasterFile raster{
      .n_columns = 300,
      .n_rows = 530,
      .samples = samples_of(300, 530, [](int x, int y) { return hills(x / 40, y / 90); }),
      .geotransform = std::to_array(kNorthUp)};
  check(raster, 200, GDT_Float32);
  const OpenedTerrain opened = open(path("in.tif"));
  std::vector<std::string> bytes;
  for (const int n : {1, 3}) {
    (void)write(opened, 200, {.threads = {n}});
    std::stringstream text;
    text << std::ifstream(path("out.tif"), std::ios::binary).rdbuf();
    bytes.push_back(text.str());
  }
  EXPECT_EQ(bytes[0], bytes[1]);
}

TEST_F(terrain_raster, takes_another_nodata_value_where_a_height_equals_that_of_the_raster) {
  // The plane of the corners passes through 0, which no sample is.
  const RasterFile raster{
      .n_columns = 3, .n_rows = 2, .samples = {-6, 1, 6, -6, 1, 6}, .nodata = 0};
  io::test::write_raster(path("in.tif"), raster);
  const TerrainRasterReport report = write(open(path("in.tif")), 2);
  ASSERT_EQ(report.terrain.triangles, 2U);
  const ReadRaster after = read_back(path("out.tif"));
  EXPECT_EQ(after.samples[1], 0);
  EXPECT_EQ(after.mask, (std::vector<std::uint8_t>(6, 255)));
  EXPECT_EQ(after.nodata, static_cast<double>(std::numeric_limits<float>::lowest()));
}

TEST_F(terrain_raster, keeps_nodata_values_of_floats) {
  for (const double nodata : {std::numeric_limits<double>::quiet_NaN(), -3.4028234663852886e+38}) {
    RasterFile raster{.n_columns = 30, .n_rows = 20, .type = GDT_Float32};
    raster.samples = samples_of(30, 20, hills);
    raster.samples[153] = nodata;
    raster.nodata = nodata;
    io::test::write_raster(path("in.tif"), raster);
    (void)write(open(path("in.tif")), 30);
    const ReadRaster after = read_back(path("out.tif"));
    EXPECT_EQ(std::isnan(after.nodata), std::isnan(nodata));
    EXPECT_EQ(after.mask[153], 0);
    EXPECT_EQ(std::ranges::count(after.mask, 0), 1);
  }
}

TEST_F(terrain_raster, of_a_file_of_lode_lies_where_the_raster_did_and_keeps_a_whole_error) {
  RasterFile raster{.n_columns = 70,
                    .n_rows = 50,
                    .samples = samples_of(70, 50, hills),
                    .geotransform = std::to_array(kNorthUp),
                    .nodata = -9999,
                    .epsg = 32633,
                    .unit = "m"};
  raster.samples[350] = -9999;
  for (const bool is_point : {false, true}) {
    raster.is_point = is_point;
    io::test::write_raster(path("in.tif"), raster);
    const OpenedTerrain source = open(path("in.tif"));
    const auto pyramid =
        BuiltTerrain::build(*source.grid, {.levels = {40, 0}, .has_place = true}, progress_);
    ASSERT_TRUE(pyramid) << pyramid.error().message;
    ASSERT_TRUE(pyramid->save(path("dem.lode"), progress_));
    OpenedTerrain opened = open(path("dem.lode"));
    opened.facts.type = "int16";
    for (const double max_error : {40.0, 0.0}) {
      const TerrainRasterReport report = write(opened, max_error);
      EXPECT_EQ(report.error_kind, RasterErrorKind::bound);
      EXPECT_EQ(report.type, RasterType::float32);
      EXPECT_LE(report.error, max_error);
      const ReadRaster before = read_back(path("in.tif"));
      const ReadRaster after = read_back(path("out.tif"));
      EXPECT_EQ(after.crs, before.crs);
      EXPECT_EQ(after.unit, "m");
      for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(after.geotransform[i], before.geotransform[i], 1e-9);
      for (std::size_t i = 0; i < before.samples.size(); ++i) {
        ASSERT_EQ(after.mask[i], before.mask[i]);
        if (after.mask[i] != 0) {
          EXPECT_LE(std::abs(after.samples[i] - before.samples[i]), report.error);
        }
      }
    }
    const auto refused = write_terrain_raster(
        opened, {.max_error = 40}, {.difference = path("less.tif")}, path("out.tif"), progress_);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("not at hand"), std::string::npos);
    const TerrainRasterReport measured =
        write(opened, 40, {.difference = path("less.tif"), .samples = source.grid});
    EXPECT_EQ(measured.error_kind, RasterErrorKind::measured);
    EXPECT_LE(measured.error, 40);
    const ReadRaster less = read_back(path("less.tif"));
    const ReadRaster heights = read_back(path("out.tif"));
    for (std::size_t i = 0; i < less.samples.size(); ++i)
      if (heights.mask[i] != 0)
        EXPECT_NEAR(less.samples[i], heights.samples[i] - raster.samples[i], 1e-4);  // of float32
  }
}

/// Vertices of whole heights do not make samples whole.
TEST_F(terrain_raster, of_a_file_of_lode_promises_no_whole_error_of_scaled_samples) {
  RasterFile raster{
      .n_columns = 21, .n_rows = 21, .geotransform = std::to_array(kNorthUp), .scale = 0.1};
  for (int i = 0; i < 441; ++i) raster.samples.push_back(i % 10 == 0 ? 10 * (i % 7) : 33);
  io::test::write_raster(path("in.tif"), raster);
  ASSERT_EQ(read_heights(path("in.tif"), {}, progress_)->type, "scaled int16");
  auto opened = open_terrain(path("in.tif"), {}, TerrainBuildOptions{.levels = {3}}, progress_);
  ASSERT_TRUE(opened) << opened.error().message;
  const TerrainRasterReport report = write(*opened, 3);
  const ReadRaster after = read_back(path("out.tif"));
  EXPECT_EQ(after.geotransform, read_back(path("in.tif")).geotransform);
  for (std::size_t i = 0; i < raster.samples.size(); ++i)
    EXPECT_LE(std::abs(after.samples[i] - 0.1 * raster.samples[i]), report.error);
  EXPECT_GT(report.error, report.terrain.achieved_error) << "rounding is in it";
}

TEST_F(terrain_raster, of_a_raster_has_pixels_of_another_size_where_one_is_given) {
  io::test::write_raster(path("in.tif"),
                         {.n_columns = 40,
                          .n_rows = 30,
                          .samples = samples_of(40, 30, hills),
                          .geotransform = std::array<double, 6>{600, 10, 0, 900, 0, -10},
                          .nodata = -9999});
  const OpenedTerrain opened = open(path("in.tif"));
  const TerrainRasterReport report = write(opened, 0, {.cell = 20});
  EXPECT_EQ(report.error_kind, RasterErrorKind::of_tin);
  const ReadRaster after = read_back(path("out.tif"));
  EXPECT_EQ(after.geotransform, (std::array<double, 6>{600, 20, 0, 900, 0, -20}));
  EXPECT_EQ(after.n_columns, 20);
  EXPECT_EQ(after.n_rows, 15);
  // At tolerance 0 cells are cut along the diagonal whose ends differ less.
  for (int y = 0; y < 15; ++y)
    for (int x = 0; x < 20; ++x) {
      const auto height = [&](int dx, int dy) { return hills(2 * x + dx, 2 * y + dy); };
      const double falling = std::abs(height(0, 0) - height(1, 1));
      const double rising = std::abs(height(1, 0) - height(0, 1));
      if (falling == rising) continue;
      EXPECT_NEAR(
          after.samples[static_cast<std::size_t>(y * 20 + x)],
          falling < rising ? (height(0, 0) + height(1, 1)) / 2 : (height(1, 0) + height(0, 1)) / 2,
          1e-9);
    }
}

TEST_F(terrain_raster, of_points_has_pixels_at_multiples_of_the_cell_with_the_heights_of_the_tin) {
  std::ofstream file(path("points.xyz"));
  oracles::Random random(8);
  for (int i = 0; i < 900; ++i) {
    const double x = 1003 + 0.01 * static_cast<double>(random.below(20000));
    const double y = 2007 + 0.01 * static_cast<double>(random.below(15000));
    file << x << ' ' << y << ' ' << 50 * std::sin(0.03 * x) * std::cos(0.02 * y) << '\n';
  }
  file.close();
  const OpenedTerrain opened = open(path("points.xyz"));
  const auto refused =
      write_terrain_raster(opened, {.max_error = 1}, {}, path("out.tif"), progress_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("cell"), std::string::npos);
  const TerrainRasterReport report = write(opened, 1, {.cell = 2.5});
  EXPECT_EQ(report.error_kind, RasterErrorKind::of_tin);
  const ReadRaster after = read_back(path("out.tif"));
  for (const std::size_t i : {0U, 3U}) EXPECT_EQ(std::fmod(after.geotransform[i], 2.5), 0);
  EXPECT_EQ(after.geotransform[5], -2.5);
  EXPECT_LE(after.geotransform[0], 1003.0);
  EXPECT_GE(after.geotransform[0] + 2.5 * after.n_columns, 1202.5);
  const auto tin = TerrainTin::select(opened.terrain, {.max_error = 1}, {}, progress_);
  ASSERT_TRUE(tin);
  std::uint64_t n_heights = 0;
  for (int y = 0; y < after.n_rows; ++y)
    for (int x = 0; x < after.n_columns; ++x) {
      const Place middle{
          {after.geotransform[0] + 2.5 * (x + 0.5), after.geotransform[3] - 2.5 * (y + 0.5)}};
      std::vector<TerrainHeight> height;
      ASSERT_TRUE(tin->heights({&middle, 1}, height, {1}, progress_));
      const auto i = static_cast<std::size_t>(y * after.n_columns + x);
      const bool is_inside = height[0].where == TerrainHeight::Where::inside;
      ASSERT_EQ(after.mask[i] != 0, is_inside);
      if (!is_inside) continue;
      ++n_heights;
      EXPECT_NEAR(after.samples[i], height[0].height, report.rounding);
    }
  EXPECT_EQ(report.n_heights, n_heights);
  EXPECT_LE(report.rounding, 1e-5);
  const auto large =
      write_terrain_raster(opened, {.max_error = 1}, {.cell = 1e-6}, path("x.tif"), progress_);
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("2^32"), std::string::npos);
}

TEST_F(terrain_raster, is_whole_or_absent) {
  io::test::write_raster(path("in.tif"),
                         {.n_columns = 40, .n_rows = 30, .samples = samples_of(40, 30, hills)});
  const OpenedTerrain opened = open(path("in.tif"));
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(write_terrain_raster(opened, {.max_error = 9}, {.difference = path("less.tif")},
                                    path("out.tif"), cancelled));
  const auto absent =
      write_terrain_raster(opened, {.max_error = 9}, {}, path("none/out.tif"), progress_);
  ASSERT_FALSE(absent);
  EXPECT_NE(absent.error().message.find("none/out.tif"), std::string::npos);
  EXPECT_FALSE(write_terrain_raster(opened, {.max_error = 9}, {}, path("out.png"), progress_));
  EXPECT_EQ(files(), std::vector<std::string>{"in.tif"});
}

}  // namespace
}  // namespace lode
