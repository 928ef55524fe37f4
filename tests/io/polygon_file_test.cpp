#include "lode/io/polygon_file.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "lode/io/gdal_crs.h"
#include "lode/io/line_file.h"

namespace lode::io {
namespace {

constexpr const char* kHoled =
    "POLYGON((500000 4000000,500090 4000000,500090 4000090,500000 4000090,500000 4000000),"
    "(500030 4000030,500030 4000060,500060 4000060,500030 4000030))";
constexpr const char* kTwo =
    "MULTIPOLYGON(((500000 4000000,500009 4000000,500009 4000009,500000 4000000)),"
    "((500100 4000000,500109 4000000,500109 4000009,500100 4000000)))";

class polygon_file : public testing::Test {
 protected:
  polygon_file()
      : directory_(std::filesystem::temp_directory_path() /
                   ("lode_polygon_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(directory_);
    GDALAllRegister();
  }
  ~polygon_file() override { std::filesystem::remove_all(directory_); }
  polygon_file(const polygon_file&) = delete;
  polygon_file& operator=(const polygon_file&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_ / name).string();
  }
  /// Features of WKT geometries, an empty text for none, in a layer for each list.
  std::string write(const std::string& name, const char* driver,
                    const std::vector<std::vector<std::string>>& layers, int epsg) {
    const std::string file = path(name);
    GDALDatasetH dataset =
        GDALCreate(GDALGetDriverByName(driver), file.c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    EXPECT_NE(dataset, nullptr);
    OGRSpatialReferenceH crs = epsg == 0 ? nullptr : OSRNewSpatialReference(nullptr);
    if (crs != nullptr) {
      EXPECT_EQ(OSRImportFromEPSG(crs, epsg), OGRERR_NONE);
      OSRSetAxisMappingStrategy(crs, OAMS_TRADITIONAL_GIS_ORDER);
    }
    for (std::size_t i = 0; i < layers.size(); ++i) {
      OGRLayerH layer = GDALDatasetCreateLayer(dataset, ("layer" + std::to_string(i)).c_str(), crs,
                                               wkbUnknown, nullptr);
      for (const std::string& wkt : layers[i]) {
        OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer));
        OGRGeometryH geometry = nullptr;
        std::string text = wkt;
        char* at = text.data();
        if (!wkt.empty()) {
          EXPECT_EQ(OGR_G_CreateFromWkt(&at, nullptr, &geometry), OGRERR_NONE);
          OGR_F_SetGeometryDirectly(feature, geometry);
        }
        EXPECT_EQ(OGR_L_CreateFeature(layer, feature), OGRERR_NONE);
        OGR_F_Destroy(feature);
      }
    }
    GDALClose(dataset);
    if (crs != nullptr) OSRDestroySpatialReference(crs);
    return file;
  }
  std::string write_text(const std::string& name, const std::string& text) {
    std::ofstream(path(name)) << text;
    return path(name);
  }

  std::filesystem::path directory_;
};

std::string refusal(const std::string& file) {
  const auto read = read_polygons(file);
  EXPECT_FALSE(read);
  return read ? std::string() : read.error().message;
}

TEST_F(polygon_file, is_read_with_its_holes_and_parts_from_every_format) {
  const std::vector<std::pair<const char*, const char*>> formats{{"a.gpkg", "GPKG"},
                                                                 {"a.shp", "ESRI Shapefile"}};
  for (const auto& [name, driver] : formats) {
    const auto read = read_polygons(write(name, driver, {{kHoled, kTwo}}, 32633));
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->polygons.size(), 3U);
    ASSERT_EQ(read->polygons[0].size(), 2U);
    EXPECT_EQ(read->polygons[0][0].size(), 4U) << "the last corner is not the first again";
    EXPECT_EQ(read->polygons[0][1].size(), 3U);
    EXPECT_NE(read->crs.find("UTM zone 33N"), std::string::npos);
    const auto same = polygons_in(*read, *to_wkt("EPSG:32633"));
    ASSERT_TRUE(same);
    EXPECT_EQ(*same, read->polygons) << "nothing is rounded";
    const auto above = polygons_in(*read, *to_wkt("EPSG:32633+5773"));
    ASSERT_TRUE(above);
    EXPECT_EQ(*above, read->polygons);
  }
}

TEST_F(polygon_file, is_taken_to_the_crs_of_the_points_along_its_edges) {
  const auto read = read_polygons(write_text(
      "a.geojson",
      R"({"type":"Polygon","coordinates":[[[14,50],[16,50],[16,51],[14,51],[14,50]]]})"));
  ASSERT_TRUE(read) << read.error().message;
  const auto made = polygons_in(*read, *to_wkt("EPSG:32633"));
  ASSERT_TRUE(made) << made.error().message;
  const auto& ring = made->at(0).at(0);
  EXPECT_EQ(ring.size(), 2U * 64 + 2 * 32);
  // Zone 33 is symmetric about 15 east, at 500 km; a parallel bends north of the chord between its
  // ends, by some 600 m here.
  EXPECT_NEAR(ring[0][0] + ring[64][0], 1e6, 1e-3);
  EXPECT_NEAR(ring[0][1], ring[64][1], 1e-3);
  EXPECT_NEAR(ring[32][0], 500000, 1e-3);
  EXPECT_LT(ring[32][1], ring[0][1] - 400);
}

TEST_F(polygon_file, is_refused_where_only_one_crs_is_known) {
  const auto unknown = read_polygons(write("a.shp", "ESRI Shapefile", {{kHoled}}, 0));
  ASSERT_TRUE(unknown) << unknown.error().message;
  EXPECT_EQ(unknown->crs, "");
  EXPECT_EQ(*polygons_in(*unknown, ""), unknown->polygons);
  const auto refused = polygons_in(*unknown, *to_wkt("EPSG:32633"));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("a.shp"), std::string::npos);
  EXPECT_NE(refused.error().message.find(".prj"), std::string::npos);
  const auto known = read_polygons(write("b.shp", "ESRI Shapefile", {{kHoled}}, 32633));
  ASSERT_TRUE(known);
  const auto other = polygons_in(*known, "");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("--crs"), std::string::npos);
}

TEST_F(polygon_file, is_refused_by_file_and_feature_where_it_has_something_else) {
  const auto expect = [&](const std::string& file, const std::vector<std::string>& words) {
    const std::string message = refusal(file);
    for (const std::string& word : words)
      EXPECT_NE(message.find(word), std::string::npos) << message;
  };
  expect(write("line.gpkg", "GPKG", {{kHoled, "LINESTRING(0 0,1 1)"}}, 32633),
         {"line.gpkg", "linestring in feature 2"});
  expect(write("point.gpkg", "GPKG", {{"GEOMETRYCOLLECTION(POINT(1 1))"}}, 32633),
         {"point.gpkg", "point in feature 1"});
  expect(write("null.gpkg", "GPKG", {{kHoled, ""}}, 32633), {"null.gpkg", "feature 2"});
  expect(write("empty.gpkg", "GPKG", {{"POLYGON EMPTY"}}, 32633), {"empty.gpkg", "feature 1"});
  expect(write("two.gpkg", "GPKG", {{kHoled}, {kTwo}}, 32633),
         {"two.gpkg", "got 2: layer0, layer1"});
  expect(write("none.gpkg", "GPKG", {{}}, 32633), {"none.gpkg", "no feature"});
  expect(write("flat.gpkg", "GPKG", {{"POLYGON((0 0,1 1,0 0))"}}, 32633),
         {"flat.gpkg", "three corners or more, got 2 in feature 1"});
  expect(path("absent.geojson"), {"absent.geojson"});
  expect(write_text("cut.geojson", R"({"type":"Polygon","coordinates":[[[14,50)"),
         {"cut.geojson", "expected GeoJSON"});
  expect(write_text("other.json", R"({"a":1})"), {"other.json", "expected GeoJSON"});
  expect(write_text("no.gpkg", "SQLite format 3"), {"no.gpkg", "GeoPackage"});
  expect(write_text("no.shp", "none"), {"no.shp", "shapefile"});
  expect(write_text("a.kml", "none"), {"a.kml", ".geojson"});
  std::filesystem::create_directory(path("folder.gpkg"));
  expect(path("folder.gpkg"), {"folder.gpkg"});
}

TEST_F(polygon_file, has_chords_in_place_of_arcs) {
  const auto read = read_polygons(write(
      "arc.gpkg", "GPKG", {{"CURVEPOLYGON(CIRCULARSTRING(0 0,10 10,20 0,10 -10,0 0))"}}, 32633));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->polygons.size(), 1U);
  EXPECT_GT(read->polygons[0][0].size(), 30U);
  for (const auto& p : read->polygons[0][0]) EXPECT_NEAR(std::hypot(p[0] - 10, p[1]), 10, 1e-9);
}

TEST_F(polygon_file, is_refused_where_the_crs_of_the_points_has_no_such_places) {
  const auto pole = read_polygons(write_text(
      "pole.geojson", R"({"type":"Polygon","coordinates":[[[0,95],[90,95],[180,100],[0,95]]]})"));
  ASSERT_TRUE(pole) << pole.error().message;
  const auto made = polygons_in(*pole, *to_wkt("EPSG:3857"));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("pole.geojson"), std::string::npos);
}

/// On the central meridian of the zone, whose x is 500 km; heights stay.
TEST_F(polygon_file, of_lines_is_read_in_another_crs_with_its_heights) {
  const std::string file =
      write("lines.gpkg", "GPKG",
            {{"LINESTRING Z (15 36 7,15 37 8,15.5 37 9)", "LINESTRING (15 36,15 37)"}}, 4326);
  const auto read = read_lines(file, *to_wkt("EPSG:32633"));
  ASSERT_TRUE(read) << read.error().message;
  const std::vector<PlaceLine>& lines = read->lines;
  ASSERT_EQ(lines.size(), 2);
  EXPECT_EQ(read->n_points, 0);
  const PlaceLine& line = lines.front();
  ASSERT_EQ(line.size(), 3);
  EXPECT_NEAR(line[0][0], 500000, 1e-6);
  EXPECT_NEAR(line[1][0], 500000, 1e-6);
  EXPECT_GT(line[2][0], 540000);
  EXPECT_NEAR(line[1][1] - line[0][1], 110900, 200);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(line[i][2], 7 + static_cast<double>(i));
  EXPECT_TRUE(std::isnan(lines.back()[0][2]));
  EXPECT_FALSE(read_lines(file, ""));
}

TEST_F(polygon_file, of_lines_is_read_layer_by_layer_without_points) {
  const std::string file = write("network.gpkg", "GPKG",
                                 {{"POINT Z (1 2 3)", "MULTIPOINT ((1 2),(3 4))"},
                                  {"LINESTRING (0 0,1 1)"},
                                  {},
                                  {"LINESTRING (5 5,6 6,7 7)", "POINT (5 5)"}},
                                 32633);
  const auto read = read_lines(file, *to_wkt("EPSG:32633"));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->lines.size(), 2);
  EXPECT_EQ(read->lines[0].size(), 2);
  EXPECT_EQ(read->lines[1].size(), 3);
  EXPECT_EQ(read->n_points, 4);
  const auto points =
      read_lines(write("points.gpkg", "GPKG", {{}, {"POINT (1 2)"}}, 32633), *to_wkt("EPSG:32633"));
  ASSERT_FALSE(points);
  EXPECT_NE(points.error().message.find("expected lines, got a point in feature 1"),
            std::string::npos)
      << points.error().message;
  EXPECT_FALSE(read_lines(write("none.gpkg", "GPKG", {{}, {}}, 32633), ""));
}

}  // namespace
}  // namespace lode::io
