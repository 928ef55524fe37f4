// Projected rasters that are read in degrees, held against the series of Krueger (1912), by which
// places in degrees are found in the projection again.
#include <cmath>
#include <filesystem>
#include <numbers>

#include "lode/io/height_reader.h"
#include "lode/io/height_stream.h"
#include "lode/io/resampling_error.h"
#include "tests/io/height_files.h"
#include "tests/io/volume_test_files.h"

namespace lode::io {
namespace {

using test::RasterFile;
using test::write_raster;

constexpr double kPixel = 30;
constexpr double kWest = 402'000;
constexpr double kNorth = 5'203'000;
constexpr int kColumns = 80;
constexpr int kRows = 60;

/// Easting and northing in UTM's zone 33 north, on WGS 84.
std::array<double, 2> utm_33(double longitude, double latitude) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kFlattening = 1 / 298.257223563;
  constexpr double kN = kFlattening / (2 - kFlattening);
  const double radius = 6378137 / (1 + kN) * (1 + kN * kN / 4 + kN * kN * kN * kN / 64);
  const std::array<double, 3> alpha{kN / 2 - 2 * kN * kN / 3 + 5 * kN * kN * kN / 16,
                                    13 * kN * kN / 48 - 3 * kN * kN * kN / 5,
                                    61 * kN * kN * kN / 240};
  const double s = std::sin(latitude * kDegree);
  const double k = 2 * std::sqrt(kN) / (1 + kN);
  const double t = std::sinh(std::atanh(s) - k * std::atanh(k * s));
  const double away = (longitude - 15) * kDegree;
  const double xi = std::atan2(t, std::cos(away));
  const double eta = std::atanh(std::sin(away) / std::sqrt(1 + t * t));
  double x = eta;
  double y = xi;
  for (std::size_t j = 0; j < 3; ++j) {
    const double m = 2 * static_cast<double>(j + 1);
    x += alpha[j] * std::cos(m * xi) * std::sinh(m * eta);
    y += alpha[j] * std::sin(m * xi) * std::cosh(m * eta);
  }
  return {500'000 + 0.9996 * radius * x, 0.9996 * radius * y};
}

/// Columns and rows of the file's samples, of a place in degrees.
std::array<double, 2> place_in_file(double longitude, double latitude) {
  const auto [east, north] = utm_33(longitude, latitude);
  return {(east - kWest) / kPixel - 0.5, (kNorth - north) / kPixel - 0.5};
}

double plane(double column, double row) { return 400 + 3 * column - 2 * row; }

bool is_in_hole(double column, double row, double margin) {
  return column > 30 - margin && column < 42 + margin && row > 20 - margin && row < 29 + margin;
}

/// A plane with a hole in it.
RasterFile plane_in_utm(GDALDataType type) {
  RasterFile file{.n_columns = kColumns, .n_rows = kRows, .type = type, .samples = {}};
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x)
      file.samples.push_back(is_in_hole(x, y, 0.5) ? -9999 : plane(x, y));
  file.geotransform = {kWest, kPixel, 0, kNorth, 0, -kPixel};
  file.nodata = -9999;
  file.epsg = 32633;
  return file;
}

class raster_warp : public testing::Test {
 protected:
  raster_warp() {
    std::string name = testing::TempDir() + "/lode_warp_XXXXXX";
    directory_ = mkdtemp(name.data());
  }
  ~raster_warp() override { std::filesystem::remove_all(directory_); }

  [[nodiscard]] std::string operator()(const std::string& name) const {
    return (directory_ / name).string();
  }
  HeightRaster read(Resampling resampling, const RasterFile& file) const {
    write_raster((*this)("utm.tif"), file);
    Progress progress;
    auto raster = read_heights((*this)("utm.tif"), {.to_degrees = resampling}, progress);
    if (!raster) ADD_FAILURE() << raster.error().message;
    return raster ? std::move(raster).value() : HeightRaster{};
  }
  /// The same of a file whose missing samples are those that reading says.
  HeightRaster read_told(const RasterFile& file, double nodata) const {
    write_raster((*this)("untold.tif"), file);
    Progress progress;
    auto raster = read_heights((*this)("untold.tif"),
                               {.nodata = nodata, .to_degrees = Resampling::cubic}, progress);
    if (!raster) ADD_FAILURE() << raster.error().message;
    return raster ? std::move(raster).value() : HeightRaster{};
  }
  std::string refusal(const std::string& name, const HeightReadOptions& options) const {
    Progress progress;
    const auto raster = read_heights((*this)(name), options, progress);
    EXPECT_FALSE(raster);
    return raster ? "" : raster.error().message;
  }

  std::filesystem::path directory_;
};

void expect_plane(const HeightGrid& grid, double most_apart) {
  std::int64_t n_heights = 0;
  double farthest = 0;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const auto degrees = grid.world(x, y);
      const auto [column, row] = place_in_file(degrees[0], degrees[1]);
      // A pixel of tolerance for who counts at borders.
      const bool is_inside = column > 1 && row > 1 && column < kColumns - 2 && row < kRows - 2;
      const bool is_outside = column < -2 || row < -2 || column > kColumns + 1 || row > kRows + 1 ||
                              is_in_hole(column, row, -2);
      const bool has_height = grid.has_height(x, y);
      if (is_inside && !is_in_hole(column, row, 3)) EXPECT_TRUE(has_height) << column << " " << row;
      if (is_outside) EXPECT_FALSE(has_height) << column << " " << row;
      if (!has_height || !is_inside || is_in_hole(column, row, 3)) continue;
      ++n_heights;
      farthest = std::max(farthest, std::abs(grid.height(x, y) - plane(column, row)));
    }
  EXPECT_GT(n_heights, kColumns * kRows / 2);
  EXPECT_LE(farthest, most_apart);
  EXPECT_GT(farthest, 0);
}

// Places may be off by 1/64 pixel, of which a row or column has 3 or 2.
constexpr double kOff = 5.0 / 64;

TEST_F(raster_warp, puts_planes_where_they_belong) {
  for (const GDALDataType type : {GDT_Int16, GDT_Float32, GDT_Float64, GDT_Int32}) {
    const RasterFile file = plane_in_utm(type);
    expect_plane(read(Resampling::bilinear, file).grid, kOff);
    expect_plane(read(Resampling::cubic, file).grid, kOff);
    expect_plane(read(Resampling::nearest, file).grid, kOff + 2.5);
  }
}

TEST_F(raster_warp, says_how_far_the_samples_are_from_it) {
  RasterFile file = plane_in_utm(GDT_Float32);
  write_raster((*this)("utm.tif"), file);
  Progress progress;
  const auto measure = [&](Resampling resampling) {
    auto error = measure_resampling((*this)("utm.tif"), {.to_degrees = resampling}, {2}, progress);
    if (!error) ADD_FAILURE() << error.error().message;
    return error ? error.value() : ResamplingError{};
  };
  const ResamplingError plane = measure(Resampling::cubic);
  // Beside what is missing heights come from one side.
  EXPECT_LE(plane.largest, 1.5);
  EXPECT_LE(plane.rms, 2 * kOff);
  EXPECT_EQ(plane.n_measured + plane.n_outside, kColumns * kRows - 13 * 10);
  EXPECT_GT(plane.n_measured, kColumns * kRows - 16 * 13);
  EXPECT_GT(measure(Resampling::nearest).largest, 0.5);
  // A spike is lost where no new sample is on it, and no other sample errs by more.
  file.samples[10 * kColumns + 15] += 100;
  write_raster((*this)("utm.tif"), file);
  const ResamplingError spike = measure(Resampling::bilinear);
  EXPECT_GT(spike.largest, 5);
  EXPECT_LT(spike.largest, 100);
  EXPECT_LT(spike.rms, 3);
}

/// Of 200 x 100 steps of a kilometre.
RasterFile kilometres(double west, double north, const std::string& crs) {
  RasterFile file{.n_columns = 200, .n_rows = 100, .type = GDT_Float32, .samples = {}};
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) file.samples.push_back(500 + 40 * std::sin(0.05 * (x - y)));
  file.geotransform = {west, 1000, 0, north, 0, -1000};
  file.crs = crs;
  return file;
}

/// Also of one that lies aslant, of small ones, and where the steps in degrees are those of the
/// file.
TEST_F(raster_warp, has_all_samples_of_a_file_without_holes_inside) {
  std::vector<RasterFile> files;
  for (const double turn : {0.0, 0.4, 2.3}) {
    RasterFile file = plane_in_utm(GDT_Float32);
    file.samples.clear();
    for (int y = 0; y < kRows; ++y)
      for (int x = 0; x < kColumns; ++x) file.samples.push_back(plane(x, y));
    const double c = kPixel * std::cos(turn);
    const double s = kPixel * std::sin(turn);
    file.geotransform = {kWest, c, s, kNorth, s, -c};
    files.push_back(file);
  }
  files.push_back(kilometres(600'000, 5'000'000, "EPSG:32660"));
  files.push_back(kilometres(1'000'000, 300'000, "EPSG:4087"));  // degrees, but for their unit
  RasterFile& smallest = files.emplace_back(plane_in_utm(GDT_Int16));
  smallest.n_columns = smallest.n_rows = 2;
  smallest.samples = {1, 2, 3, 4};
  Progress progress;
  for (std::size_t i = 0; i < files.size(); ++i) {
    SCOPED_TRACE(i);
    const auto n = static_cast<std::uint64_t>(files[i].samples.size());
    write_raster((*this)("utm.tif"), files[i]);
    for (const int oversampling : {1, 3}) {
      const HeightReadOptions options{.to_degrees = Resampling::cubic,
                                      .oversampling = oversampling};
      const auto error = measure_resampling((*this)("utm.tif"), options, {2}, progress);
      ASSERT_TRUE(error) << error.error().message;
      EXPECT_EQ(error->n_outside, 0U) << oversampling;
      EXPECT_EQ(error->n_measured, n) << oversampling;
      // A sample on the border is no farther from the patch that it is in than a cell is high.
      EXPECT_LE(error->largest, 6);
    }
  }
}

TEST_F(raster_warp, leaves_out_what_it_is_told) {
  RasterFile file = plane_in_utm(GDT_Int16);
  file.nodata.reset();
  expect_plane(read_told(file, -9999).grid, kOff);
}

/// Where one band has a hole another has heights.
TEST_F(raster_warp, leaves_out_what_its_own_band_misses) {
  RasterFile file = plane_in_utm(GDT_Int16);
  file.n_bands = 2;  // the second 1000 higher, -8999 in the hole
  expect_plane(read(Resampling::cubic, file).grid, kOff);
  file.nodata.reset();
  expect_plane(read_told(file, -9999).grid, kOff);
}

TEST_F(raster_warp, goes_on_beyond_180_degrees) {
  // Zone 60 ends in the middle.
  const RasterFile file = kilometres(600'000, 5'000'000, "EPSG:32660");
  const HeightRaster raster = read(Resampling::cubic, file);
  const auto first = raster.grid.world(0, 0);
  const auto last = raster.grid.world(raster.grid.n_columns - 1, 0);
  EXPECT_LT(first[0], 180);
  EXPECT_GT(last[0], 180);
  EXPECT_LT(last[0] - first[0], 4);
  write_raster((*this)("utm.tif"), file);
  Progress progress;
  const auto error =
      measure_resampling((*this)("utm.tif"), {.to_degrees = Resampling::cubic}, {2}, progress);
  ASSERT_TRUE(error) << error.error().message;
  EXPECT_GT(error->n_measured, 200 * 100 * 9 / 10);
  EXPECT_LT(error->largest, 2);
}

TEST_F(raster_warp, keeps_samples_near_poles_and_refuses_poles) {
  // From the pole on, in one direction: far from it a step of longitude is small.
  const RasterFile beside = kilometres(20'000, 50'000, "EPSG:3413");
  const HeightRaster raster = read(Resampling::cubic, beside);
  EXPECT_GT(raster.grid.n_columns, 200);
  EXPECT_GT(raster.grid.n_rows, 100);
  write_raster((*this)("pole.tif"), kilometres(-100'000, 50'000, "EPSG:3413"));
  EXPECT_NE(refusal("pole.tif", {.to_degrees = Resampling::cubic}).find("without a pole"),
            std::string::npos);
}

TEST_F(raster_warp, keeps_what_numbers_stand_for) {
  RasterFile file = plane_in_utm(GDT_Int16);
  file.scale = 0.5;
  file.offset = 200;
  for (double& z : file.samples)
    if (z != -9999) z = 2 * (z - 200);
  file.unit = "ft";
  const HeightRaster raster = read(Resampling::bilinear, file);
  expect_plane(raster.grid, kOff);
  EXPECT_EQ(raster.grid.vertical_unit, "ft");
  EXPECT_EQ(raster.format, "GTiff");
}

TEST_F(raster_warp, keeps_what_heights_are_above) {
  RasterFile file = plane_in_utm(GDT_Float32);
  file.epsg = 0;
  file.crs = "EPSG:32633+5773";
  const HeightRaster raster = read(Resampling::bilinear, file);
  EXPECT_EQ(vertical_name(raster.grid.crs), "EGM96 height");
  expect_plane(raster.grid, kOff);
  EXPECT_EQ(vertical_name(read(Resampling::bilinear, plane_in_utm(GDT_Int16)).grid.crs), "");
}

TEST_F(raster_warp, gives_rows_of_a_stream_as_the_whole) {
  const HeightRaster whole = read(Resampling::cubic, plane_in_utm(GDT_Float32));
  Progress progress;
  const auto stream =
      HeightStream::open((*this)("utm.tif"), {.to_degrees = Resampling::cubic}, progress);
  ASSERT_TRUE(stream) << stream.error().message;
  const HeightGrid& grid = whole.grid;
  std::vector<double> row(static_cast<std::size_t>(grid.n_columns));
  for (std::int32_t y = 0; y < grid.n_rows; y += 7) {
    ASSERT_TRUE(stream->read(y, 1, row));
    for (std::int32_t x = 0; x < grid.n_columns; ++x) {
      const double z = row[static_cast<std::size_t>(x)];
      EXPECT_EQ(std::isnan(z), !grid.has_height(x, y));
      if (!std::isnan(z)) EXPECT_EQ(z, grid.height(x, y));
    }
  }
}

TEST_F(raster_warp, refuses_what_it_cannot_put_anywhere) {
  RasterFile file = plane_in_utm(GDT_Int16);
  file.epsg = 0;
  write_raster((*this)("nowhere.tif"), file);
  EXPECT_NE(refusal("nowhere.tif", {.to_degrees = Resampling::cubic})
                .find("expected a raster whose CRS is known"),
            std::string::npos);
  write_raster((*this)("utm.tif"), plane_in_utm(GDT_Int16));
  EXPECT_NE(
      refusal("utm.tif", {.encoding = HeightEncoding::terrarium, .to_degrees = Resampling::cubic})
          .find("expected no encoding"),
      std::string::npos);
  EXPECT_NE(refusal("utm.tif", {.band = 2, .to_degrees = Resampling::cubic})
                .find("expected a band from 1 to 1"),
            std::string::npos);
}

}  // namespace
}  // namespace lode::io
