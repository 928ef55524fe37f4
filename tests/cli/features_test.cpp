// lode features: critical points and the lines between them, read back with GDAL.
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "lode/api/files.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

using Places = std::vector<std::array<double, 3>>;

/// A feature as GDAL has it; values are those of columns of numbers, and none of nulls.
struct ReadFeature {
  std::string kind;
  std::map<std::string, double> values;
  Places places;
};

std::vector<ReadFeature> read_layer(GDALDatasetH dataset, const char* name) {
  std::vector<ReadFeature> read;
  OGRLayerH layer = GDALDatasetGetLayerByName(dataset, name);
  EXPECT_NE(layer, nullptr) << name;
  if (layer == nullptr) return read;
  OGRFeatureDefnH columns = OGR_L_GetLayerDefn(layer);
  OGR_L_ResetReading(layer);
  while (OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    ReadFeature& made = read.emplace_back();
    for (int i = 0; i < OGR_FD_GetFieldCount(columns); ++i) {
      const std::string column = OGR_Fld_GetNameRef(OGR_FD_GetFieldDefn(columns, i));
      if (!OGR_F_IsFieldSetAndNotNull(feature, i)) continue;
      if (column == "kind")
        made.kind = OGR_F_GetFieldAsString(feature, i);
      else
        made.values[column] = OGR_F_GetFieldAsDouble(feature, i);
    }
    OGRGeometryH shape = OGR_F_GetGeometryRef(feature);
    for (int i = 0; i < OGR_G_GetPointCount(shape); ++i)
      made.places.push_back({OGR_G_GetX(shape, i), OGR_G_GetY(shape, i), OGR_G_GetZ(shape, i)});
    OGR_F_Destroy(feature);
  }
  return read;
}

/// What a GeoPackage holds.
struct ReadNetwork {
  std::vector<ReadFeature> points;
  std::vector<ReadFeature> ridges;
  std::vector<ReadFeature> channels;
  std::string epsg;
};

ReadNetwork read_network(const std::string& path) {
  GDALAllRegister();
  ReadNetwork read;
  GDALDatasetH dataset = GDALOpenEx(path.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  EXPECT_NE(dataset, nullptr) << path;
  if (dataset == nullptr) return read;
  read.points = read_layer(dataset, "critical_points");
  read.ridges = read_layer(dataset, "ridges");
  read.channels = read_layer(dataset, "channels");
  OGRSpatialReferenceH crs =
      OGR_L_GetSpatialRef(GDALDatasetGetLayerByName(dataset, "critical_points"));
  const char* name = crs == nullptr ? nullptr : OSRGetAttrValue(crs, "PROJCS", 0);
  if (name != nullptr) read.epsg = name;
  GDALClose(dataset);
  return read;
}

class cli_features : public testing::Test {
 protected:
  cli_features() : dem_(scratch_ / "dem.asc") {
    write_dem(dem_);
    write_dem_crs(scratch_ / "dem.prj");
  }

  [[nodiscard]] nlohmann::json write(const std::string& out, const std::string& relief) const {
    return run_lode({"features", dem_, out, "--feature-relief", relief, "--json"}).json();
  }
  /// The sample of write_dem() at a place, which has to be one's own.
  static double sample_at(const std::array<double, 3>& place) {
    const double x = (place[0] - 500015) / 30;
    const double y = 29 - (place[1] - 4000015) / 30;
    EXPECT_NEAR(x, std::round(x), 1e-9);
    EXPECT_NEAR(y, std::round(y), 1e-9);
    EXPECT_FALSE(std::round(x) == 7 && std::round(y) == 9) << "nodata";
    return std::round(900 + 300 * std::sin(0.2 * std::round(x)) * std::cos(0.3 * std::round(y)));
  }

  Scratch scratch_;
  std::string dem_;
};

std::int64_t alternating_sum(const nlohmann::json& counts) {
  return counts.at("peaks").get<std::int64_t>() - counts.at("passes").get<std::int64_t>() +
         counts.at("pits").get<std::int64_t>();
}

TEST_F(cli_features, are_read_back_from_a_geopackage_as_the_report_says) {
  for (const char* relief : {"0", "60"}) {
    const std::string out = scratch_ / "features.gpkg";
    const auto json = write(out, relief);
    const ReadNetwork read = read_network(out);
    EXPECT_EQ(read.epsg, "WGS 84 / UTM zone 11N");
    std::map<std::string, std::int64_t> counts;
    for (const ReadFeature& point : read.points) {
      ASSERT_EQ(point.places.size(), 1U);
      EXPECT_EQ(point.places[0][2], sample_at(point.places[0]));
      EXPECT_EQ(point.values.at("height"), point.places[0][2]);
      if (point.values.contains("persistence"))
        EXPECT_GE(point.values.at("persistence"), std::stod(relief));
      counts[point.kind] += static_cast<std::int64_t>(point.values.at("multiplicity"));
    }
    EXPECT_EQ(counts["peak"], json.at("kept").at("peaks"));
    EXPECT_EQ(counts["pass"], json.at("kept").at("passes"));
    EXPECT_EQ(counts["pit"], json.at("kept").at("pits"));
    EXPECT_GT(counts["peak"], 3);
    EXPECT_GT(counts["pass"], 3);
    EXPECT_EQ(json.at("euler_number"), 0) << "a disc with a hole round the missing sample";
    EXPECT_EQ(alternating_sum(json.at("kept")), 0);
    EXPECT_EQ(alternating_sum(json.at("all")), 0);
    EXPECT_EQ(read.ridges.size(), json.at("ridges"));
    EXPECT_EQ(read.channels.size(), json.at("channels"));
    std::size_t n_points = 0;
    for (const auto* lines : {&read.ridges, &read.channels})
      for (const ReadFeature& line : *lines) n_points += line.places.size();
    EXPECT_EQ(n_points, json.at("points"));
    EXPECT_EQ(std::filesystem::file_size(out), json.at("bytes"));
  }
}

/// Three layers, and one with points and lines.
TEST_F(cli_features, are_breaklines_without_their_points) {
  for (const char* name : {"features.gpkg", "features.geojson"}) {
    SCOPED_TRACE(name);
    const std::string out = scratch_ / name;
    const auto made = write(out, "60");
    const Finished run = run_lode({"extract", dem_, scratch_ / "lined.ply", "--max-error", "50",
                                   "--breaklines", out, "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto lines = run.json().at("lines").at("breaklines");
    EXPECT_EQ(lines.at("lines").get<int>(),
              made.at("ridges").get<int>() + made.at("channels").get<int>());
    EXPECT_GT(lines.at("left_out_points"), 5);
    EXPECT_EQ(lines.at("outside"), 0);
    EXPECT_NE(run.err.find("points are left out"), std::string::npos) << run.err;
  }
}

TEST_F(cli_features, run_from_passes_along_samples_up_to_peaks_and_down_to_pits) {
  const std::string out = scratch_ / "features.gpkg";
  ASSERT_FALSE(write(out, "0").empty());
  const ReadNetwork read = read_network(out);
  std::map<std::array<double, 3>, std::string> kinds;
  for (const ReadFeature& point : read.points) kinds[point.places[0]] = point.kind;
  for (const auto* lines : {&read.ridges, &read.channels}) {
    const double up = lines == &read.ridges ? 1 : -1;
    std::map<std::array<double, 3>, int> n_ends;
    for (const ReadFeature& line : *lines) {
      ++n_ends[line.places.front()];
      ++n_ends[line.places.back()];
    }
    for (const ReadFeature& line : *lines) {
      EXPECT_EQ(line.values.at("from_height"), line.places.front()[2]);
      EXPECT_EQ(line.values.at("to_height"), line.places.back()[2]);
      for (std::size_t i = 0; i < line.places.size(); ++i) {
        EXPECT_EQ(line.places[i][2], sample_at(line.places[i]));
        if (i == 0) continue;
        EXPECT_GE(up * (line.places[i][2] - line.places[i - 1][2]), 0);
        EXPECT_LE(std::abs(line.places[i][0] - line.places[i - 1][0]), 30 + 1e-6) << "no edge";
        EXPECT_LE(std::abs(line.places[i][1] - line.places[i - 1][1]), 30 + 1e-6) << "no edge";
      }
      EXPECT_TRUE(kinds[line.places.front()] == "pass" || n_ends[line.places.front()] >= 3);
      const std::string& end = kinds[line.places.back()];
      if (lines == &read.ridges)
        EXPECT_TRUE(end == "peak" || end == "pass" || n_ends[line.places.back()] >= 3) << end;
    }
  }
}

TEST_F(cli_features, of_geojson_are_one_collection_of_longitudes_and_latitudes) {
  const std::string out = scratch_ / "features.geojson";
  const auto json = write(out, "60");
  const auto collection = nlohmann::json::parse(read_bytes(out));
  EXPECT_FALSE(collection.contains("crs")) << "RFC 7946";
  std::map<std::string, int> counts;
  for (const auto& feature : collection.at("features")) {
    const auto& properties = feature.at("properties");
    const std::string kind = properties.at("kind");
    ++counts[kind];
    const bool is_line = kind == "ridge" || kind == "channel";
    EXPECT_EQ(feature.at("geometry").at("type"), is_line ? "LineString" : "Point");
    EXPECT_TRUE(properties.contains("persistence"));
    EXPECT_EQ(properties.contains("from_height"), is_line);
    EXPECT_EQ(properties.contains("height"), !is_line);
    const auto& coordinates = feature.at("geometry").at("coordinates");
    for (const auto& at : is_line ? coordinates : nlohmann::json::array({coordinates})) {
      ASSERT_EQ(at.size(), 2U) << "heights are not above the ellipsoid";
      EXPECT_NEAR(at[0].get<double>(), -117, 0.02);
      EXPECT_NEAR(at[1].get<double>(), 36.15, 0.02);
    }
  }
  EXPECT_EQ(counts["peak"], json.at("kept").at("peaks"));
  EXPECT_EQ(counts["pit"], json.at("kept").at("pits"));
  EXPECT_EQ(counts["ridge"], json.at("ridges"));
  EXPECT_EQ(counts["channel"], json.at("channels"));
}

TEST_F(cli_features, of_vtp_are_points_and_lines_in_space) {
  const std::string out = scratch_ / "features.vtp";
  const auto json = write(out, "0");
  const std::string bytes = read_bytes(out);
  const ReadNetwork read = [&] {
    static_cast<void>(write(scratch_ / "features.gpkg", "0"));
    return read_network(scratch_ / "features.gpkg");
  }();
  const std::size_t n_lines = read.ridges.size() + read.channels.size();
  EXPECT_NE(bytes.find("NumberOfVerts=\"" + std::to_string(read.points.size()) + "\""),
            std::string::npos);
  EXPECT_NE(bytes.find("NumberOfLines=\"" + std::to_string(n_lines) + "\""), std::string::npos);
  for (const char* name : {"kind", "persistence", "multiplicity", "on_outline", "height"})
    EXPECT_NE(bytes.find("Name=\"" + std::string(name) + "\""), std::string::npos) << name;
  const auto surface = read_surface(out);
  ASSERT_TRUE(surface) << surface.error().message;
  ASSERT_EQ(surface->positions.size(), read.points.size() + json.at("points").get<std::size_t>());
  EXPECT_EQ(surface->lines.size(), json.at("points").get<std::size_t>() - n_lines);
  for (std::size_t i = 0; i < read.points.size(); ++i) {
    const Vec3d at = surface->world_position(static_cast<std::uint32_t>(i));
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(at[axis], read.points[i].places[0][axis], 1e-3);
  }
}

TEST_F(cli_features, above_all_reliefs_are_an_empty_network_and_a_warning) {
  // Round the missing sample goes a pass without a pair.
  std::ofstream(dem_) << "ncols 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
                      << "1 5 1 4\n1 2 1 2\n1 1 1 1\n";
  for (const char* name : {"out.gpkg", "out.geojson", "out.vtp"}) {
    const std::string out = scratch_ / name;
    const Finished run = run_lode({"features", dem_, out, "--feature-relief", "1000000", "--json"});
    EXPECT_EQ(run.json().at("ridges"), 0);
    EXPECT_EQ(run.json().at("channels"), 0);
    EXPECT_EQ(run.json().at("kept").at("peaks"), 1) << "the highest has no pair";
    EXPECT_NE(run.err.find("there are no ridges and channels"), std::string::npos) << run.err;
    if (std::string(name) == "out.gpkg") {
      EXPECT_TRUE(read_network(out).ridges.empty());
      ASSERT_EQ(read_network(out).points.size(), 1U);
      EXPECT_FALSE(read_network(out).points[0].values.contains("persistence")) << "null";
    } else if (std::string(name) == "out.vtp") {
      EXPECT_TRUE(read_surface(out));
    }
  }
}

TEST_F(cli_features, of_files_that_keep_all_heights_are_those_of_the_raster) {
  const auto wanted = write(scratch_ / "raster.gpkg", "60");
  for (const char* model : {"surface_quadtree", "implicit_delaunay_pyramid", "delaunay_pyramid"}) {
    const std::string file = scratch_ / (std::string(model) + ".lode");
    ASSERT_EQ(run_lode({"build", dem_, file, "--model", model}).exit_code, 0);
    const Finished run =
        run_lode({"features", file, scratch_ / "model.gpkg", "--feature-relief", "60", "--json"});
    if (std::string(model) == "delaunay_pyramid") {
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_NE(run.err.find("keeps all heights"), std::string::npos) << run.err;
      continue;
    }
    for (const char* key : {"kept", "all", "ridges", "channels", "points", "euler_number"})
      EXPECT_EQ(run.json().at(key), wanted.at(key)) << model << ": " << key;
  }
}

TEST_F(cli_features, refuse_what_cannot_be_meant) {
  const std::string out = scratch_ / "out.gpkg";
  const auto refuse = [&](Words options, const std::vector<std::string>& words, int code = 2) {
    options.insert(options.begin(), {"features", dem_});
    expect_refusal(run_lode(options), code, words);
  };
  refuse({scratch_ / "out.shp"}, {"out.shp", ".gpkg", ".vtp"});
  refuse({dem_}, {"dem.asc", ".gpkg"});
  refuse({out, "--feature-relief", "-1"}, {"--feature-relief", ">= 0"});
  refuse({out, "--feature-relief", "nan"}, {"--feature-relief"});
  refuse({out, "--class", "2"}, {"--class", "raster"});
  refuse({"/none/such/out.gpkg"}, {"out.gpkg"}, 1);
  std::filesystem::remove(scratch_ / "dem.prj");
  refuse({scratch_ / "out.geojson"}, {"out.geojson", "CRS", ".gpkg"}, 1);
  write_dem(dem_, 40, 1);
  refuse({out}, {"dem.asc"}, 1);
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode({"features", scratch_ / "ball.nrrd", out}), 2, {"ball.nrrd", "raster"});
  EXPECT_EQ(scratch_.files(), (std::vector<std::string>{"ball.nrrd", "dem.asc"}));
}

}  // namespace
}  // namespace lode::test
