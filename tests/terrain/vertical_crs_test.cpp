// What heights are above: read, declared, transformed, and written again.
#include <cpl_conv.h>
#include <gtest/gtest.h>
#include <ogr_srs_api.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "lode/api/files.h"
#include "lode/io/gdal_crs.h"
#include "lode/io/height_stream.h"
#include "tests/io/height_files.h"
#include "tests/io/point_files.h"

namespace lode {
namespace {

using io::test::RasterFile;

constexpr double kSurveyFoot = 1200.0 / 3937;

class vertical_crs : public testing::Test {
 protected:
  vertical_crs()
      : directory_(std::filesystem::temp_directory_path() /
                   ("lode_vertical_crs_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(directory_);
    GDALAllRegister();
  }
  ~vertical_crs() override { std::filesystem::remove_all(directory_); }
  vertical_crs(const vertical_crs&) = delete;
  vertical_crs& operator=(const vertical_crs&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_ / name).string();
  }
  /// 20 x 15 heights round 10 east, 45 north, a hundredth of a degree apart, one missing.
  std::string write(const std::string& crs, const std::string& unit = "") {
    RasterFile raster{.n_columns = 20, .n_rows = 15, .type = GDT_Float32, .nodata = -9999};
    for (int i = 0; i < 300; ++i)
      raster.samples.push_back(100 + std::round(40 * std::sin(0.1 * i)));
    raster.samples[47] = -9999;
    raster.geotransform = {9.995, 0.01, 0, 45.005, 0, -0.01};
    raster.crs = crs;
    raster.unit = unit;
    io::test::write_raster(path("dem.tif"), raster);
    return path("dem.tif");
  }
  HeightRaster read(const std::string& file, const VerticalOptions& options) {
    auto raster = read_heights(file, {.vertical = options}, progress_);
    EXPECT_TRUE(raster) << raster.error().message;
    return raster ? *std::move(raster) : HeightRaster{};
  }
  std::string refusal(const std::string& file, const VerticalOptions& options) {
    const auto raster = read_heights(file, {.vertical = options}, progress_);
    EXPECT_FALSE(raster);
    return raster ? std::string() : raster.error().message;
  }
  /// A grid of undulations 20 + (longitude - 10) + 2 (latitude - 45), 5 x 5 half degrees.
  std::string write_geoid() {
    const std::string file = path("geoid.gtx");
    RasterFile geoid{.n_columns = 5, .n_rows = 5, .type = GDT_Float32};
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x) geoid.samples.push_back(20 + 0.5 * (x - 2) - 1.0 * (y - 2));
    geoid.geotransform = {8.75, 0.5, 0, 46.25, 0, -0.5};
    geoid.epsg = 4326;
    io::test::write_raster(file, geoid, "GTX");
    return file;
  }
  static std::string bound_to(const std::string& grid) {
    return R"(VERT_CS["our geoid",VERT_DATUM["our geoid",2005,EXTENSION["PROJ4_GRIDS",")" + grid +
           R"("]],UNIT["metre",1],AXIS["Up",UP]])";
  }

  std::filesystem::path directory_;
  Progress progress_;
};

void expect_heights(const HeightRaster& got, const HeightRaster& before, double slack,
                    const std::function<double(double x, double y, double z)>& height) {
  ASSERT_EQ(got.grid.n_missing(), before.grid.n_missing());
  for (std::int32_t y = 0; y < got.grid.n_rows; ++y)
    for (std::int32_t x = 0; x < got.grid.n_columns; ++x) {
      ASSERT_EQ(got.grid.has_height(x, y), before.grid.has_height(x, y));
      if (!got.grid.has_height(x, y)) continue;
      const auto at = got.grid.world(x, y);
      ASSERT_NEAR(got.grid.height(x, y), height(at[0], at[1], before.grid.height(x, y)), slack);
    }
}

TEST_F(vertical_crs, of_a_compound_one_is_known_with_its_unit) {
  const std::string file = write("EPSG:4326+6360");
  const HeightRaster raster = read(file, {});
  EXPECT_EQ(vertical_name(raster.grid.crs), "NAVD88 height (ftUS)");
  EXPECT_EQ(metres_of_unit(raster.grid.vertical_unit), kSurveyFoot);
  EXPECT_TRUE(raster.vertical.notes.empty());
  EXPECT_TRUE(read_metric(raster.grid.crs)->ellipsoid.has_value());
  // A unit that a band gives by another name stays; one that contradicts does not.
  EXPECT_EQ(read(write("EPSG:4326+5773", "m"), {}).grid.vertical_unit, "m");
  const HeightRaster odd = read(write("EPSG:4326+5773", "ft"), {});
  EXPECT_EQ(odd.grid.vertical_unit, "metre");
  ASSERT_EQ(odd.vertical.notes.size(), 1U);
  EXPECT_NE(odd.vertical.notes[0].find("in ft; EGM96 height in metre is taken"), std::string::npos);
  EXPECT_EQ(vertical_name(read(write("EPSG:4326"), {}).grid.crs), "");
  EXPECT_EQ(vertical_name(read(write("EPSG:4979"), {}).grid.crs), "ellipsoid");
}

TEST_F(vertical_crs, that_is_declared_is_taken_and_contradictions_are_said) {
  const HeightRaster plain = read(write("EPSG:4326"), {.declared = "EPSG:5773"});
  EXPECT_EQ(vertical_name(plain.grid.crs), "EGM96 height");
  EXPECT_EQ(plain.grid.vertical_unit, "metre");
  EXPECT_TRUE(plain.vertical.notes.empty());
  const std::string file = write("EPSG:4326+5773");
  EXPECT_TRUE(read(file, {.declared = "EPSG:5773"}).vertical.notes.empty());
  const HeightRaster other = read(file, {.declared = "EPSG:6360"});
  EXPECT_EQ(vertical_name(other.grid.crs), "NAVD88 height (ftUS)");
  EXPECT_EQ(metres_of_unit(other.grid.vertical_unit), kSurveyFoot);
  ASSERT_FALSE(other.vertical.notes.empty());
  EXPECT_NE(other.vertical.notes[0].find("EGM96 height in metre; NAVD88 height (ftUS)"),
            std::string::npos);
  // Heights are as they were.
  expect_heights(other, read(file, {}), 0, [](double, double, double z) { return z; });
  EXPECT_EQ(vertical_name(read(write("EPSG:4326"), {.declared = "ellipsoid"}).grid.crs),
            "ellipsoid");
  // Without any CRS its unit is what can be kept.
  const HeightRaster nowhere = read(write(""), {.declared = "EPSG:6360"});
  EXPECT_EQ(nowhere.grid.crs, "");
  EXPECT_EQ(metres_of_unit(nowhere.grid.vertical_unit), kSurveyFoot);
}

TEST_F(vertical_crs, changes_units_without_grids_also_where_no_place_is_known) {
  for (const char* crs : {"EPSG:4326", ""}) {
    const std::string file = write(crs);
    const HeightRaster feet = read(file, {.declared = "EPSG:5703", .target = "EPSG:6360"});
    EXPECT_EQ(metres_of_unit(feet.grid.vertical_unit), kSurveyFoot);
    EXPECT_EQ(feet.type, "float64");
    EXPECT_FALSE(feet.vertical.transformation.empty());
    expect_heights(feet, read(file, {}), 1e-9,
                   [](double, double, double z) { return z / kSurveyFoot; });
  }
  // Depths are heights turned over.
  const HeightRaster depths =
      read(write("EPSG:4326"), {.declared = "EPSG:5714", .target = "EPSG:5715"});
  EXPECT_LT(depths.grid.height(0, 0), 0);
}

TEST_F(vertical_crs, takes_heights_above_a_geoid_to_the_ellipsoid_and_back) {
  const std::string geoid = bound_to(write_geoid());
  const std::string file = write("EPSG:4326");
  const HeightRaster before = read(file, {});
  const auto undulation = [](double x, double y) { return 20 + (x - 10) + 2 * (y - 45); };
  const HeightRaster above = read(file, {.declared = geoid, .target = "ellipsoid"});
  EXPECT_EQ(vertical_name(above.grid.crs), "ellipsoid");
  EXPECT_EQ(above.grid.vertical_unit, "metre");
  // The grid has floats.
  expect_heights(above, before, 1e-5,
                 [&](double x, double y, double z) { return z + undulation(x, y); });
  const HeightRaster below = read(file, {.declared = "ellipsoid", .target = geoid});
  expect_heights(below, before, 1e-5,
                 [&](double x, double y, double z) { return z - undulation(x, y); });
  EXPECT_EQ(vertical_name(below.grid.crs), "our geoid");
}

/// What the NIMA's program for EGM96 gave as test output (OUTINTPT.DAT), in metres: it takes
/// splines where PROJ is bilinear, which differ by centimetres between nodes of a quarter of a
/// degree.
TEST_F(vertical_crs, has_the_undulations_of_egm96_for_which_proj_brings_the_grid) {
  const std::vector<Vec3d> published{
      {{269.7791550, 38.6281550, -31.628}}, {{305.0211140, -14.6212170, -2.969}},
      {{102.4487290, 46.8743190, -43.575}}, {{133.8747120, -23.6174460, 15.871}},
      {{359.9995000, 38.6254730, 50.066}},  {{0.0023000, -0.4667440, 17.329}}};
  std::ofstream file(path("p.xyz"));
  file.precision(10);
  for (const Vec3d& p : published) file << p[0] << ' ' << p[1] << " 1000\n";
  file.close();
  const auto points = io::read_points(
      path("p.xyz"),
      {.crs = "EPSG:4326", .vertical = {.declared = "EPSG:5773", .target = "ellipsoid"}},
      progress_);
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->points.size(), published.size());
  for (std::size_t i = 0; i < published.size(); ++i)
    EXPECT_NEAR(points->points[i][2], 1000 + published[i][2], 0.1);
  EXPECT_EQ(points->vertical.accuracy, 1);
}

TEST_F(vertical_crs, refuses_what_proj_has_no_grid_for_and_says_which) {
  const std::string file = write("EPSG:4326");
  const std::string lost =
      refusal(file, {.declared = bound_to(path("absent.gtx")), .target = "ellipsoid"});
  EXPECT_NE(lost.find("absent.gtx"), std::string::npos) << lost;
  EXPECT_NE(lost.find("dem.tif"), std::string::npos) << lost;
  const std::string egm = refusal(file, {.declared = "EPSG:5773", .target = "EPSG:3855"});
  EXPECT_NE(egm.find("us_nga_egm08_25.tif"), std::string::npos) << egm;
  // A guess would take heights as they are.
  const std::string guess = refusal(file, {.declared = "EPSG:5705", .target = "EPSG:5711"});
  EXPECT_NE(guess.find("Baltic 1977 height to"), std::string::npos) << guess;
  // Two CRS of different places, or none: only where PROJ knows the way.
  EXPECT_NE(
      refusal(write(""), {.declared = "EPSG:5773", .target = "EPSG:5703"}).find("got nothing"),
      std::string::npos);
}

TEST_F(vertical_crs, refuses_samples_off_the_grid) {
  RasterFile raster{.n_columns = 20, .n_rows = 15};
  for (int i = 0; i < 300; ++i) raster.samples.push_back(i);
  raster.geotransform = {10.5, 0.1, 0, 45.5, 0, -0.1};
  raster.crs = "EPSG:4326";
  io::test::write_raster(path("far.tif"), raster);
  const std::string message =
      refusal(path("far.tif"), {.declared = bound_to(write_geoid()), .target = "ellipsoid"});
  EXPECT_NE(message.find("off it"), std::string::npos) << message;
  EXPECT_NE(message.find("far.tif"), std::string::npos) << message;
}

TEST_F(vertical_crs, refuses_what_is_no_vertical_crs_and_what_is_above_nothing_known) {
  const std::string file = write("EPSG:4326");
  for (const VerticalOptions& options :
       {VerticalOptions{.declared = "EPSG:32633"}, VerticalOptions{.declared = "EPSG:4326+5773"},
        VerticalOptions{.declared = "up"}, VerticalOptions{.declared = "EPSG:0"},
        VerticalOptions{.declared = "EPSG:5773", .target = "EPSG:4979"}})
    EXPECT_NE(refusal(file, options).find("expected a vertical CRS"), std::string::npos);
  EXPECT_NE(refusal(file, {.target = "ellipsoid"}).find("--vertical-crs"), std::string::npos);
  EXPECT_NE(refusal(write(""), {.declared = "ellipsoid"}).find("horizontal CRS"),
            std::string::npos);
}

TEST_F(vertical_crs, stays_with_rasters_and_models_that_are_written) {
  const std::string file = write("EPSG:4326");
  auto opened =
      open_terrain(file, {.raster = {.vertical = {.declared = "EPSG:5703", .target = "EPSG:6360"}}},
                   {}, progress_);
  ASSERT_TRUE(opened) << opened.error().message;
  const auto made = write_terrain_raster(*opened, {.max_error = 3}, {}, path("out.tif"), progress_);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_LE(made->error, 3);
  const HeightRaster back = read(path("out.tif"), {});
  EXPECT_EQ(vertical_name(back.grid.crs), "NAVD88 height (ftUS)");
  EXPECT_EQ(metres_of_unit(back.grid.vertical_unit), kSurveyFoot);
  EXPECT_TRUE(back.vertical.notes.empty());
  expect_heights(back, read(file, {}), 3 + 1e-3,
                 [](double, double, double z) { return z / kSurveyFoot; });

  opened =
      open_terrain(file, {.raster = {.vertical = {.declared = "EPSG:5773", .target = "ellipsoid"}}},
                   {}, progress_);
  ASSERT_TRUE(opened);
  const auto pyramid = BuiltTerrain::build(*opened->grid, {.levels = {3}}, progress_);
  ASSERT_TRUE(pyramid);
  ASSERT_TRUE(pyramid->save(path("dem.lode"), progress_));
  const auto model = open_terrain(path("dem.lode"), {}, {}, progress_);
  ASSERT_TRUE(model);
  EXPECT_EQ(vertical_name(model->facts.frame.crs), "ellipsoid");
  ASSERT_TRUE(write_terrain_raster(*model, {.max_error = 3}, {}, path("out.tif"), progress_));
  EXPECT_EQ(vertical_name(read(path("out.tif"), {}).grid.crs), "ellipsoid");
  EXPECT_EQ(read_metric(read(path("out.tif"), {}).grid.crs)->ellipsoid_name, "WGS 84");
}

TEST_F(vertical_crs, above_the_ellipsoid_of_a_projected_crs_is_kept_by_a_geotiff) {
  RasterFile raster{.n_columns = 20, .n_rows = 15};
  for (int i = 0; i < 300; ++i) raster.samples.push_back(i % 17);
  raster.geotransform = {500000, 30, 0, 4000000, 0, -30};
  raster.epsg = 26710;
  io::test::write_raster(path("dem.tif"), raster);
  const auto opened = open_terrain(
      path("dem.tif"), {.raster = {.vertical = {.declared = "ellipsoid"}}}, {}, progress_);
  ASSERT_TRUE(opened) << opened.error().message;
  const auto made = write_terrain_raster(*opened, {.max_error = 3}, {}, path("out.tif"), progress_);
  ASSERT_TRUE(made) << made.error().message;
  const HeightRaster back = read(path("out.tif"), {});
  EXPECT_NE(back.grid.crs.find("NAD27 / UTM zone 10N"), std::string::npos);
  EXPECT_EQ(vertical_name(back.grid.crs), "ellipsoid");
  EXPECT_TRUE(read(path("out.tif"), {.declared = "ellipsoid"}).vertical.notes.empty());
}

/// The coordinates of the first contour at 0, as text.
std::string first_line_of(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line) && line.find("coordinates") == std::string::npos) {
  }
  return line;
}

TEST_F(vertical_crs, changes_no_place_of_contours_in_longitudes_and_latitudes) {
  std::vector<std::string> lines;
  for (const char* crs : {"EPSG:26710", "EPSG:26710+5703", "EPSG:26710+5773"}) {
    const std::string file = path("lines.geojson");
    auto writer = VectorWriter::create(
        file, {.name = "contours", .columns = {{"height"}}, .crs = *io::to_wkt(crs)});
    ASSERT_TRUE(writer) << writer.error().message;
    const VectorWriter::Points line{{{560000, 5110000}}, {{560100, 5110200}}};
    const double height = 0;
    ASSERT_TRUE(writer->add({&height, 1}, {&line, 1}));
    ASSERT_TRUE(writer->commit(progress_));
    lines.push_back(first_line_of(file));
  }
  EXPECT_EQ(lines[0], lines[1]);
  EXPECT_EQ(lines[0], lines[2]);
}

TEST_F(vertical_crs, of_tiles_is_over_the_globe_of_their_clients) {
  const auto cut = [&](const std::string& crs) {
    const std::string dem = write(crs);
    const auto report =
        write_terrain_tiles(dem, {}, {.max_error = 50, .max_level = 3}, path("tiles"), progress_);
    std::filesystem::remove_all(path("tiles"));
    return report ? std::string() : report.error().message;
  };
  EXPECT_EQ(cut("EPSG:4979"), "");
  EXPECT_EQ(cut("EPSG:4267"), "");  // Clarke's ellipsoid of 1866
  EXPECT_NE(cut("EPSG:4813").find("prime meridian Jakarta"), std::string::npos);
  EXPECT_NE(cut("+proj=longlat +R=1737400 +no_defs").find("1737400"), std::string::npos);
}

/// Rows that are read and transformed again and again are those of a raster that is read whole.
TEST_F(vertical_crs, of_rows_that_stay_in_their_file_is_that_of_all) {
  const std::string file = write("EPSG:4326", "ft");
  for (const VerticalOptions& options :
       {VerticalOptions{}, VerticalOptions{.declared = bound_to(write_geoid())},
        VerticalOptions{.declared = bound_to(write_geoid()), .target = "ellipsoid"}}) {
    const HeightRaster whole = read(file, options);
    const auto stream = io::HeightStream::open(file, {.vertical = options}, progress_);
    ASSERT_TRUE(stream) << stream.error().message;
    EXPECT_EQ(stream->raster().grid.crs, whole.grid.crs);
    EXPECT_EQ(stream->raster().grid.vertical_unit, whole.grid.vertical_unit);
    EXPECT_EQ(stream->raster().type, whole.type);
    EXPECT_EQ(stream->raster().vertical.notes, whole.vertical.notes);
    EXPECT_EQ(stream->raster().vertical.transformation, whole.vertical.transformation);
    for (const auto& [first, n_rows] : {std::pair{0, 15}, {3, 1}, {2, 9}, {14, 1}, {2, 9}}) {
      std::vector<double> rows(static_cast<std::size_t>(20 * n_rows));
      ASSERT_TRUE(stream->read(first, n_rows, rows));
      for (int i = 0; i < 20 * n_rows; ++i) {
        const double z = rows[static_cast<std::size_t>(i)];
        EXPECT_EQ(std::isnan(z), !whole.grid.has_height(i % 20, first + i / 20));
        if (!std::isnan(z)) EXPECT_EQ(z, whole.grid.height(i % 20, first + i / 20));
      }
    }
  }
  RasterFile raster{.n_columns = 20, .n_rows = 15};
  for (int i = 0; i < 300; ++i) raster.samples.push_back(i);
  raster.geotransform = {10.5, 0.1, 0, 45.5, 0, -0.1};
  raster.crs = "EPSG:4326";
  io::test::write_raster(path("far.tif"), raster);
  const auto far = io::HeightStream::open(
      path("far.tif"), {.vertical = {.declared = bound_to(write_geoid()), .target = "ellipsoid"}},
      progress_);
  ASSERT_TRUE(far);
  std::vector<double> rows(20);
  const auto off = far->read(14, 1, rows);
  ASSERT_FALSE(off);
  EXPECT_NE(off.error().message.find("off it"), std::string::npos) << off.error().message;
  EXPECT_NE(off.error().message.find("far.tif"), std::string::npos) << off.error().message;
}

TEST_F(vertical_crs, of_points_is_that_of_their_keys_or_as_declared) {
  using io::test::LasFile;
  LasFile las{.geo_keys = {1, 1, 0, 2, 3072, 0, 1, 32633, 4096, 0, 1, 5703}};
  for (std::int32_t i = 0; i < 50; ++i) las.points.push_back({{i * 100, i * i * 10, 3000 + i}, 2});
  const std::string bytes = las.bytes();
  std::ofstream(path("p.las"), std::ios::binary) << bytes;
  const auto file = io::read_points(path("p.las"), {}, progress_);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(vertical_name(file->crs), "NAVD88 height");
  EXPECT_EQ(file->vertical_unit, "metre");
  std::ofstream(path("p.xyz")) << "10 45 100\n10.1 45 101\n10.1 45.1 102\n10 45.1 103\n";
  const auto points =
      io::read_points(path("p.xyz"),
                      {.crs = "EPSG:4326",
                       .vertical = {.declared = bound_to(write_geoid()), .target = "ellipsoid"}},
                      progress_);
  ASSERT_TRUE(points) << points.error().message;
  EXPECT_EQ(vertical_name(points->crs), "ellipsoid");
  EXPECT_NEAR(points->points[0][2], 120, 1e-5);
  EXPECT_NEAR(points->points[2][2], 122.3, 1e-5);
  const auto compound = io::read_points(path("p.xyz"), {.crs = "EPSG:4326+6360"}, progress_);
  ASSERT_TRUE(compound) << compound.error().message;
  EXPECT_EQ(compound->vertical_unit, "US survey foot");
  for (const char* bad : {"EPSG:4326+32633", "EPSG:5773+5703", "EPSG:4326+", "EPSG:4326+0"})
    EXPECT_FALSE(io::read_points(path("p.xyz"), {.crs = bad}, progress_)) << bad;
}

TEST_F(vertical_crs, transforms_nothing_once_cancelled) {
  const std::string file = write("EPSG:4326");
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(read_heights(file, {.vertical = {.declared = "EPSG:5703", .target = "EPSG:6360"}},
                            cancelled));
}

}  // namespace
}  // namespace lode
