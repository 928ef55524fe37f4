#include "lode/io/vector_file.h"

#include <cpl_conv.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace lode::io {
namespace {

using Points = VectorWriter::Points;

std::string wkt_of(int epsg) {
  OGRSpatialReferenceH crs = OSRNewSpatialReference(nullptr);
  EXPECT_EQ(OSRImportFromEPSG(crs, epsg), OGRERR_NONE);
  char* text = nullptr;
  EXPECT_EQ(OSRExportToWkt(crs, &text), OGRERR_NONE);
  std::string wkt = text;
  CPLFree(text);
  OSRDestroySpatialReference(crs);
  return wkt;
}

/// A directory that is gone when the test is.
class vector_file : public testing::Test {
 protected:
  vector_file()
      : directory_(std::filesystem::temp_directory_path() /
                   ("lode_vector_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(directory_);
    GDALAllRegister();
  }
  ~vector_file() override { std::filesystem::remove_all(directory_); }
  vector_file(const vector_file&) = delete;
  vector_file& operator=(const vector_file&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_ / name).string();
  }
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(directory_))
      names.push_back(entry.path().filename().string());
    return names;
  }

  std::filesystem::path directory_;
};

Result<void> write_two(const std::string& path, const std::string& crs) {
  LODE_TRY(VectorWriter writer,
           VectorWriter::create(path, {.name = "contours", .columns = {{"height"}}, .crs = crs}));
  const Points first{{{500000.1, 4000000.2}}, {{500010.3, 4000020.4}}};
  const Points second{
      {{500100, 4000100}}, {{500200, 4000100}}, {{500100, 4000300}}, {{500100, 4000100}}};
  const double low = 100.5;
  const double high = 200;
  LODE_CHECK(writer.add({&low, 1}, {&first, 1}));
  LODE_CHECK(writer.add({&high, 1}, {&second, 1}));
  return writer.commit(Progress());
}

TEST_F(vector_file, is_read_back_by_gdal_from_a_geopackage_with_its_crs) {
  const std::string file = path("lines.gpkg");
  const auto status = write_two(file, wkt_of(32611));
  ASSERT_TRUE(status) << status.error().message;
  EXPECT_EQ(files(), std::vector<std::string>{"lines.gpkg"});
  GDALDatasetH dataset = GDALOpenEx(file.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(dataset, nullptr);
  OGRLayerH layer = GDALDatasetGetLayerByName(dataset, "contours");
  ASSERT_NE(layer, nullptr);
  EXPECT_EQ(OGR_L_GetFeatureCount(layer, 1), 2);
  EXPECT_EQ(OGR_L_GetGeomType(layer), wkbLineString);
  EXPECT_STREQ(OSRGetAuthorityCode(OGR_L_GetSpatialRef(layer), nullptr), "32611");
  OGRFeatureH feature = OGR_L_GetNextFeature(layer);
  EXPECT_EQ(OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "height")), 100.5);
  OGRGeometryH line = OGR_F_GetGeometryRef(feature);
  ASSERT_EQ(OGR_G_GetPointCount(line), 2);
  EXPECT_EQ(OGR_G_GetX(line, 1), 500010.3);
  EXPECT_EQ(OGR_G_GetY(line, 1), 4000020.4);
  OGR_F_Destroy(feature);
  GDALClose(dataset);
}

TEST_F(vector_file, of_no_crs_is_of_a_plane) {
  const std::string file = path("plane.gpkg");
  const auto status = write_two(file, "");
  ASSERT_TRUE(status) << status.error().message;
  GDALDatasetH dataset = GDALOpenEx(file.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(dataset, nullptr);
  for (const char* table : {"gpkg_contents", "gpkg_geometry_columns"}) {
    const std::string query = std::string("SELECT srs_id FROM ") + table;
    OGRLayerH answer = GDALDatasetExecuteSQL(dataset, query.c_str(), nullptr, nullptr);
    OGRFeatureH row = OGR_L_GetNextFeature(answer);
    EXPECT_EQ(OGR_F_GetFieldAsInteger(row, 0), -1) << table;
    OGR_F_Destroy(row);
    GDALDatasetReleaseResultSet(dataset, answer);
  }
  GDALClose(dataset);
}

TEST_F(vector_file, of_geojson_has_longitudes_and_latitudes_of_wgs_84) {
  const std::string file = path("lines.geojson");
  const auto status = write_two(file, wkt_of(32611));
  ASSERT_TRUE(status) << status.error().message;
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  EXPECT_EQ(text.str().find("\"crs\""), std::string::npos) << "RFC 7946, section 4";
  GDALDatasetH dataset = GDALOpenEx(file.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(dataset, nullptr);
  OGRFeatureH feature = OGR_L_GetNextFeature(GDALDatasetGetLayer(dataset, 0));
  OGRGeometryH line = OGR_F_GetGeometryRef(feature);
  // Zone 11's central meridian is 117 degrees west, at 500 km; 4,000 km are about 36.14 north.
  EXPECT_NEAR(OGR_G_GetX(line, 0), -117, 1e-4);
  EXPECT_NEAR(OGR_G_GetY(line, 0), 36.14, 0.01);
  OGR_F_Destroy(feature);
  GDALClose(dataset);
  EXPECT_FALSE(VectorWriter::create(path("none.geojson"), {.name = "x"})) << "no CRS";
}

TEST_F(vector_file, of_polygons_has_rings) {
  const std::string file = path("areas.gpkg");
  auto writer = VectorWriter::create(
      file, {.name = "bands", .shape = VectorShape::polygons, .columns = {{"lower"}, {"upper"}}});
  ASSERT_TRUE(writer) << writer.error().message;
  const std::vector<Points> rings{{{{0, 0}}, {{9, 0}}, {{9, 9}}, {{0, 9}}, {{0, 0}}},
                                  {{{3, 3}}, {{3, 6}}, {{6, 6}}, {{6, 3}}, {{3, 3}}}};
  const std::vector<double> values{1, 2};
  ASSERT_TRUE(writer->add(values, rings));
  ASSERT_TRUE(writer->commit(Progress()));
  GDALDatasetH dataset = GDALOpenEx(file.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(dataset, nullptr);
  OGRFeatureH feature = OGR_L_GetNextFeature(GDALDatasetGetLayer(dataset, 0));
  EXPECT_EQ(OGR_G_Area(OGR_F_GetGeometryRef(feature)), 72);
  EXPECT_EQ(OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "upper")), 2);
  OGR_F_Destroy(feature);
  GDALClose(dataset);
}

TEST_F(vector_file, of_several_layers_has_heights_texts_and_nulls) {
  const std::string file = path("features.gpkg");
  const std::vector<VectorLayer> layers{
      {.name = "places",
       .shape = VectorShape::points,
       .columns = {{"kind", ColumnType::text}, {"n", ColumnType::integer}, {"value"}},
       .has_heights = true},
      {.name = "ways", .columns = {{"value"}}, .has_heights = true},
      {.name = "none", .columns = {{"value"}}}};
  auto writer = VectorWriter::create(file, layers);
  ASSERT_TRUE(writer) << writer.error().message;
  const std::vector<Vec3d> places{{{1, 2, 3.5}}, {{4, 5, -6}}};
  const VectorValue infinite = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(writer->add(1, std::vector<VectorValue>{infinite}, places));
  ASSERT_TRUE(writer->add(0, std::vector<VectorValue>{"peak", 2.0, 0.25}, {&places[0], 1}));
  ASSERT_TRUE(writer->commit(Progress()));
  GDALDatasetH dataset = GDALOpenEx(file.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  ASSERT_NE(dataset, nullptr);
  ASSERT_EQ(GDALDatasetGetLayerCount(dataset), 3);
  OGRLayerH points = GDALDatasetGetLayerByName(dataset, "places");
  EXPECT_EQ(OGR_L_GetGeomType(points), wkbPoint25D);
  OGRFeatureH point = OGR_L_GetNextFeature(points);
  EXPECT_STREQ(OGR_F_GetFieldAsString(point, 0), "peak");
  EXPECT_EQ(OGR_F_GetFieldAsInteger(point, 1), 2);
  EXPECT_EQ(OGR_F_GetFieldAsDouble(point, 2), 0.25);
  EXPECT_EQ(OGR_G_GetZ(OGR_F_GetGeometryRef(point), 0), 3.5);
  OGR_F_Destroy(point);
  OGRFeatureH way = OGR_L_GetNextFeature(GDALDatasetGetLayerByName(dataset, "ways"));
  EXPECT_TRUE(OGR_F_IsFieldNull(way, 0));
  EXPECT_EQ(OGR_G_GetPointCount(OGR_F_GetGeometryRef(way)), 2);
  EXPECT_EQ(OGR_G_GetZ(OGR_F_GetGeometryRef(way), 1), -6);
  OGR_F_Destroy(way);
  EXPECT_EQ(OGR_L_GetFeatureCount(GDALDatasetGetLayerByName(dataset, "none"), 1), 0);
  GDALClose(dataset);
}

TEST_F(vector_file, of_geojson_leaves_out_heights_and_values_that_are_none) {
  const std::string file = path("mixed.geojson");
  auto writer = VectorWriter::create(file, {.name = "features",
                                            .shape = VectorShape::mixed,
                                            .columns = {{"kind", ColumnType::text}, {"a"}, {"b"}},
                                            .crs = wkt_of(4326),
                                            .has_heights = true});
  ASSERT_TRUE(writer) << writer.error().message;
  const std::vector<Vec3d> places{{{10, 20, 1000}}, {{10.5, 20, 2000}}};
  const VectorValue infinite = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(writer->add(0, std::vector<VectorValue>{"peak", infinite, {}}, {&places[0], 1}));
  ASSERT_TRUE(writer->add(0, std::vector<VectorValue>{"ridge", {}, 7.5}, places));
  ASSERT_TRUE(writer->commit(Progress()));
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  const std::string json = text.str();
  EXPECT_NE(json.find(R"("properties": { "kind": "peak", "a": null })"), std::string::npos) << json;
  EXPECT_NE(json.find(R"("properties": { "kind": "ridge", "b": 7.5 })"), std::string::npos) << json;
  EXPECT_NE(json.find(R"("type": "Point", "coordinates": [ 10.0, 20.0 ])"), std::string::npos)
      << json;
  EXPECT_EQ(json.find("1000"), std::string::npos) << "a height above no ellipsoid";
}

TEST_F(vector_file, is_whole_or_absent) {
  const std::string file = path("lines.gpkg");
  {
    auto writer = VectorWriter::create(file, {.name = "contours", .columns = {{"height"}}});
    ASSERT_TRUE(writer) << writer.error().message;
    EXPECT_FALSE(std::filesystem::exists(file));
  }
  EXPECT_TRUE(files().empty()) << "nothing is left of a writer that did not commit";
  {
    auto writer = VectorWriter::create(file, {.name = "contours", .columns = {{"height"}}});
    ASSERT_TRUE(writer);
    Progress cancelled;
    cancelled.cancel();
    EXPECT_FALSE(writer->commit(cancelled));
  }
  EXPECT_TRUE(files().empty());
  ASSERT_TRUE(write_two(file, ""));
  ASSERT_TRUE(write_two(file, "")) << "an older one is replaced";
  EXPECT_EQ(files(), std::vector<std::string>{"lines.gpkg"});
}

TEST_F(vector_file, refuses_other_names_and_places_that_cannot_be_written) {
  for (const char* name : {"lines.shp", "lines", "lines.json", "lines.gpkg.txt"}) {
    const auto writer = VectorWriter::create(path(name), {.name = "contours"});
    ASSERT_FALSE(writer);
    EXPECT_NE(writer.error().message.find(".gpkg or .geojson"), std::string::npos);
  }
  const auto absent = VectorWriter::create(path("none/such.gpkg"), {.name = "contours"});
  ASSERT_FALSE(absent);
  EXPECT_NE(absent.error().message.find("such.gpkg"), std::string::npos);
  EXPECT_FALSE(VectorWriter::create(path("a.gpkg"), {.name = "contours", .crs = "no WKT"}));
  EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace lode::io
