// --to-crs, in the commands that write coordinates of terrain or measure distances.
#include <fmt/format.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "lode/api/files.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

/// 61 x 61 heights from 45 to 46 north, 10 to 11 east, in the format of SRTM, which has a CRS.
void write_degrees(const std::string& path) {
  std::string bytes;
  for (int y = 0; y < 61; ++y)
    for (int x = 0; x < 61; ++x) {
      const auto z = std::lround(1000 + 400 * std::sin(0.2 * x) * std::cos(0.17 * y) + 3 * x);
      bytes += static_cast<char>(z >> 8);
      bytes += static_cast<char>(z & 255);
    }
  write_bytes(path, bytes);
}

/// The place in longitudes and latitudes as GDAL's own library puts it into a CRS.
std::array<double, 2> mapped_by_gdal(int epsg, double x, double y) {
  OGRSpatialReferenceH from = OSRNewSpatialReference(nullptr);
  OGRSpatialReferenceH to = OSRNewSpatialReference(nullptr);
  OSRImportFromEPSG(from, 4326);
  OSRImportFromEPSG(to, epsg);
  OSRSetAxisMappingStrategy(from, OAMS_TRADITIONAL_GIS_ORDER);
  OSRSetAxisMappingStrategy(to, OAMS_TRADITIONAL_GIS_ORDER);
  OGRCoordinateTransformationH way = OCTNewCoordinateTransformation(from, to);
  EXPECT_TRUE(OCTTransform(way, 1, &x, &y, nullptr));
  OCTDestroyCoordinateTransformation(way);
  OSRDestroySpatialReference(from);
  OSRDestroySpatialReference(to);
  return {x, y};
}

/// Of the first layer of a GeoPackage.
struct ReadLayer {
  std::string crs;
  std::vector<std::array<double, 2>> places;  ///< Of lines, and of outer rings.
};

ReadLayer read_layer_of(const std::string& path, const char* name) {
  GDALAllRegister();
  ReadLayer read;
  GDALDatasetH dataset = GDALOpenEx(path.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
  EXPECT_NE(dataset, nullptr) << path;
  if (dataset == nullptr) return read;
  OGRLayerH layer = GDALDatasetGetLayerByName(dataset, name);
  const char* crs = OSRGetAttrValue(OGR_L_GetSpatialRef(layer), "PROJCS", 0);
  if (crs != nullptr) read.crs = crs;
  while (OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    OGRGeometryH shape = OGR_F_GetGeometryRef(feature);
    if (wkbFlatten(OGR_G_GetGeometryType(shape)) == wkbPolygon)
      shape = OGR_G_GetGeometryRef(shape, 0);
    for (int i = 0; i < OGR_G_GetPointCount(shape); ++i)
      read.places.push_back({OGR_G_GetX(shape, i), OGR_G_GetY(shape, i)});
    OGR_F_Destroy(feature);
  }
  GDALClose(dataset);
  return read;
}

class cli_to_crs : public testing::Test {
 protected:
  cli_to_crs() : dem_(scratch_ / "N45E010.hgt") { write_degrees(dem_); }

  [[nodiscard]] Words in_utm(Words words) const {
    for (const char* word : {"--to-crs", "EPSG:32632"}) words.emplace_back(word);
    return words;
  }

  Scratch scratch_;
  std::string dem_;
};

TEST_F(cli_to_crs, writes_meshes_whose_error_is_measured_there) {
  ASSERT_EQ(run_lode({"extract", dem_, scratch_ / "own.ply", "--max-error", "20"}).exit_code, 0);
  const auto own = read_placed_surface(scratch_ / "own.ply");
  ASSERT_TRUE(own);
  for (const char* name : {"dem.ply", "dem.obj", "dem.vtp", "dem.glb"}) {
    const Finished run =
        run_lode(in_utm({"extract", dem_, scratch_ / name, "--max-error", "20", "--json"}));
    const auto json = run.json();
    const auto& there = json.at("to_crs");
    EXPECT_EQ(there.at("name"), "WGS 84 / UTM zone 32N");
    EXPECT_EQ(there.at("measured_at"), "all samples");
    EXPECT_LE(json.at("achieved_error").get<double>(), 20);
    EXPECT_GT(there.at("error").get<double>(), 20);
    EXPECT_EQ(there.at("error_met"), false);
    EXPECT_GT(there.at("samples_in_no_triangle").get<int>(), 0);
    EXPECT_EQ(there.at("samples").get<int>() + there.at("samples_in_no_triangle").get<int>(),
              61 * 61);
    EXPECT_NE(run.err.find("WGS 84 / UTM zone 32N samples are up to"), std::string::npos)
        << run.err;
    EXPECT_NE(read_bytes(scratch_ / name).find("UTM zone 32N"), std::string::npos) << name;
  }
  const auto made = read_placed_surface(scratch_ / "dem.ply");
  ASSERT_TRUE(made);
  EXPECT_EQ(made->surface.triangles, own->surface.triangles);
  ASSERT_EQ(made->places.size(), own->surface.positions.size());
  for (std::uint32_t v = 0; v < made->places.size(); ++v) {
    const Vec3d degrees = PlacedSurfaceView{own->surface, own->places}.world_position(v);
    // The file in degrees has floats, which are off by up to 2^-24 of a degree, 7 mm.
    const auto wanted = mapped_by_gdal(32632, degrees[0], degrees[1]);
    ASSERT_NEAR(made->places[v][0], wanted[0], 0.1);
    ASSERT_NEAR(made->places[v][1], wanted[1], 0.1);
    ASSERT_EQ(made->places[v][2], degrees[2]);
  }
  const auto glb = read_bytes(scratch_ / "dem.glb");
  EXPECT_NE(glb, "");
}

TEST_F(cli_to_crs, says_what_is_written_in_words) {
  const Finished run =
      run_lode(in_utm({"extract", dem_, scratch_ / "dem.ply", "--max-error", "20"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* words : {"in the CRS of the file", "written in", "error there", "measured",
                            "in no triangle there", "samples, beside edges that bend"})
    EXPECT_NE(run.out.find(words), std::string::npos) << words << '\n' << run.out;
  const auto none = run_lode({"extract", dem_, scratch_ / "own.ply", "--json"}).json();
  EXPECT_TRUE(none.at("to_crs").is_null());
}

TEST_F(cli_to_crs, takes_files_and_measures_what_they_keep) {
  const auto build = [&](const char* model, const char* name) {
    ASSERT_EQ(
        run_lode({"build", dem_, scratch_ / name, "--model", model, "--levels", "5,50"}).exit_code,
        0)
        << model;
  };
  build("delaunay_pyramid", "pyramid.lode");
  Finished run = run_lode(in_utm(
      {"extract", scratch_ / "pyramid.lode", scratch_ / "a.ply", "--max-error", "50", "--json"}));
  EXPECT_EQ(run.json().at("to_crs").at("measured_at"), "vertices of the finest mesh");
  EXPECT_TRUE(run.json().at("to_crs").at("error_met").is_null());
  EXPECT_NE(run.err.find("in the CRS of the file only"), std::string::npos) << run.err;
  ASSERT_EQ(
      run_lode({"build", dem_, scratch_ / "bisected.lode", "--model", "right_triangle_bisection"})
          .exit_code,
      0);
  run = run_lode(in_utm(
      {"extract", scratch_ / "bisected.lode", scratch_ / "b.ply", "--max-error", "50", "--json"}));
  EXPECT_EQ(run.json().at("to_crs").at("measured_at"), "all samples");
  // A model that is built for the question has its raster at hand.
  run = run_lode(in_utm({"extract", dem_, scratch_ / "c.ply", "--max-error", "50", "--model",
                         "implicit_delaunay_pyramid", "--json"}));
  EXPECT_EQ(run.json().at("to_crs").at("measured_at"), "all samples");
  // Its slivers join samples far apart, and turn over.
  expect_refusal(run_lode(in_utm({"extract", dem_, scratch_ / "d.ply", "--max-error", "50",
                                  "--model", "ternary_triangulation"})),
                 1, {"N45E010.hgt", "turn over", "right_triangle_bisection"});
}

TEST_F(cli_to_crs, refuses_what_cannot_be_meant) {
  const Words extract{"extract", dem_, scratch_ / "dem.ply", "--max-error", "20"};
  const auto with = [](Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  for (const char* heights : {"EPSG:5773", "EPSG:4326+5773", "EPSG:4979"})
    expect_refusal(run_lode(with(extract, {"--to-crs", heights})), 2,
                   {"--to-crs", "--to-vertical-crs"});
  expect_refusal(run_lode(with(extract, {"--to-crs", "EPSG:4978"})), 2, {"--to-crs", "geocentric"});
  expect_refusal(run_lode(with(extract, {"--to-crs", "metres"})), 2, {"--to-crs", "EPSG:N"});
  expect_refusal(run_lode(in_utm({"extract", dem_, scratch_ / "dem.tif"})), 2,
                 {"--to-crs", "dem.tif", "gdalwarp"});
  expect_refusal(run_lode(with(in_utm(extract), {"--wrap"})), 2, {"--wrap", "--to-crs"});
  expect_refusal(run_lode(in_utm({"contours", dem_, scratch_ / "a.geojson", "--interval", "100"})),
                 2, {"--to-crs", "a.geojson", "RFC 7946"});
  write_dem(scratch_ / "plain.asc");
  expect_refusal(run_lode(in_utm({"extract", scratch_ / "plain.asc", scratch_ / "plain.ply"})), 1,
                 {"plain.asc", "--to-crs", "--crs"});
  // A view of the earth from space, on whose other side the tile is.
  const std::string far_side =
      R"(PROJCS["far side",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,)"
      R"(298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],)"
      R"(PROJECTION["Orthographic"],PARAMETER["latitude_of_origin",-45],)"
      R"(PARAMETER["central_meridian",-170],PARAMETER["false_easting",0],)"
      R"(PARAMETER["false_northing",0],UNIT["metre",1]])";
  expect_refusal(run_lode(with(extract, {"--to-crs", far_side})), 1,
                 {"N45E010.hgt", "far side", "PROJ finds no place", "10, 46"});
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode(in_utm({"extract", scratch_ / "ball.nrrd", scratch_ / "ball.ply",
                                  "--isovalue", "100"})),
                 2, {"ball.nrrd", "--to-crs"});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "dem.ply"));
}

TEST_F(cli_to_crs, writes_contours_and_bands_and_features) {
  for (const bool is_bands : {false, true}) {
    Words words{"contours", dem_, scratch_ / "own.gpkg", "--interval", "100", "--json"};
    if (is_bands) words.emplace_back("--polygons");
    const char* layer = is_bands ? "bands" : "contours";
    ASSERT_TRUE(run_lode(words).json().at("to_crs").is_null());
    const ReadLayer own = read_layer_of(scratch_ / "own.gpkg", layer);
    words[2] = scratch_ / "utm.gpkg";
    const auto json = run_lode(in_utm(words)).json();
    EXPECT_EQ(json.at("to_crs").at("name"), "WGS 84 / UTM zone 32N");
    const double bend = json.at("to_crs").at("largest_bend").get<double>();
    EXPECT_GT(bend, 0);
    EXPECT_LT(bend, 1000);
    const ReadLayer utm = read_layer_of(scratch_ / "utm.gpkg", layer);
    EXPECT_EQ(utm.crs, "WGS 84 / UTM zone 32N");
    ASSERT_EQ(utm.places.size(), own.places.size());
    for (std::size_t i = 0; i < own.places.size(); ++i) {
      const auto wanted = mapped_by_gdal(32632, own.places[i][0], own.places[i][1]);
      ASSERT_NEAR(utm.places[i][0], wanted[0], 1e-6);
      ASSERT_NEAR(utm.places[i][1], wanted[1], 1e-6);
      if (i == 40) break;  // GDAL makes its way anew for each
    }
  }
  const auto json =
      run_lode(in_utm({"features", dem_, scratch_ / "features.gpkg", "--json"})).json();
  EXPECT_GT(json.at("to_crs").at("largest_bend").get<double>(), 0);
  const ReadLayer points = read_layer_of(scratch_ / "features.gpkg", "critical_points");
  EXPECT_EQ(points.crs, "WGS 84 / UTM zone 32N");
  ASSERT_FALSE(points.places.empty());
  for (const auto& [x, y] : points.places) {
    EXPECT_GT(x, 570000);
    EXPECT_GT(y, 4.98e6);
  }
}

TEST_F(cli_to_crs, measures_distances_of_profiles_and_sight_and_says_so) {
  const Words ends{"--from", "10.1,45.2", "--to", "10.9,45.2", "--json"};
  const auto run = [&](Words words, const Words& more) {
    words.insert(words.end(), ends.begin(), ends.end());
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words).json();
  };
  for (const char* command : {"profile", "sight"}) {
    const char* key = std::string(command) == "profile" ? "length" : "distance";
    const auto own = run({command, dem_}, {});
    EXPECT_TRUE(own.at("distance_crs").is_null());
    EXPECT_EQ(own.at("ellipsoid"), "WGS 84");
    const auto utm = run({command, dem_}, {"--to-crs", "EPSG:32632"});
    EXPECT_EQ(utm.at("distance_crs"), "WGS 84 / UTM zone 32N");
    EXPECT_EQ(utm.at("distance_is_planar"), true);
    EXPECT_TRUE(utm.at("ellipsoid").is_null());
    EXPECT_EQ(utm.at("distance_unit"), "metre");
    // Along the parallel: the scale of the zone times its length on the ellipsoid; between 86 and
    // 149 km from the central meridian that is 0.9996 (1 + d^2 / 2 R^2).
    const double share = utm.at(key).get<double>() / own.at(key).get<double>();
    EXPECT_NEAR(share, 0.9996 * (1 + 118 * 118 / (2 * 6378.0 * 6378)), 5e-5) << command;
    const auto feet = run({command, dem_}, {"--to-crs", "EPSG:2226"});
    EXPECT_EQ(feet.at("distance_unit"), "US survey foot");
    const auto other = run({command, dem_}, {"--to-crs", "EPSG:4258"});
    EXPECT_EQ(other.at("ellipsoid"), "GRS 1980");
    EXPECT_EQ(other.at("distance_is_planar"), false);
    EXPECT_NEAR(other.at(key).get<double>(), own.at(key).get<double>(), 1e-3);
  }
  const Finished words = run_lode(
      {"profile", dem_, "--from", "10.1,45.2", "--to", "10.9,45.2", "--to-crs", "EPSG:32632"});
  EXPECT_NE(words.out.find("metre, in the plane of WGS 84 / UTM zone 32N"), std::string::npos)
      << words.out;
  expect_refusal(run_lode({"profile", dem_, "--from", "10.1,45.2", "--to", "10.9,45.2", "--to-crs",
                           "EPSG:5773"}),
                 2, {"--to-crs"});
}

TEST(cli_to_crs_of_real_data, holds_at_all_samples_of_a_tile_in_degrees) {
  const char* data = std::getenv("LODE_DATA");
  const auto folder = data != nullptr
                          ? std::filesystem::path(data)
                          : (std::filesystem::path(LODE_TEST_FILES_DIR) / "../../../shared/data")
                                .lexically_normal();
  const std::string dem = folder / "terrain/etopo5_4320x2161_int16.tif";
  if (!std::filesystem::exists(dem)) GTEST_SKIP() << dem << " is absent; set LODE_DATA";
  const Scratch scratch;
  // All of the earth has its poles and its seam in the way.
  expect_refusal(run_lode({"extract", dem, scratch / "all.ply", "--max-error", "500", "--to-crs",
                           "EPSG:3035"}),
                 1, {"etopo5", "ETRS89"});
  const auto json = run_lode({"extract", dem, scratch / "alps.ply", "--max-error", "100", "--clip",
                              "5,16,44,49", "--to-crs", "EPSG:3035", "--json"})
                        .json();
  const auto& there = json.at("to_crs");
  EXPECT_EQ(there.at("measured_at"), "all samples");
  EXPECT_GT(there.at("samples").get<int>(), 7000);
  EXPECT_EQ(there.at("error_met").get<bool>(), there.at("error").get<double>() <= 100);
}

/// Places typed in another CRS: GDAL puts them into the terrain's, whose own answers are the same.
TEST_F(cli_to_crs, height_takes_places_of_another_crs) {
  std::string degrees = "x,y\n";
  std::string metres = "x,y\n";
  for (int i = 0; i < 50; ++i) {
    const double x = 10.01 + 0.019 * i;
    const double y = 45.02 + 0.0191 * ((7 * i) % 50);
    const auto there = mapped_by_gdal(32632, x, y);
    degrees += fmt::format("{},{}\n", x, y);
    metres += fmt::format("{},{}\n", there[0], there[1]);
  }
  write_bytes(scratch_ / "degrees.csv", degrees);
  write_bytes(scratch_ / "metres.csv", metres);
  const auto own = run_lode({"height", dem_, scratch_ / "degrees.csv", "--json"}).json();
  const auto json =
      run_lode({"height", dem_, scratch_ / "metres.csv", "--places-crs", "EPSG:32632", "--json"})
          .json();
  EXPECT_EQ(own.at("places_crs"), nullptr);
  EXPECT_EQ(json.at("places_crs"), "WGS 84 / UTM zone 32N");
  EXPECT_EQ(json.at("outside"), 0);
  for (std::size_t i = 0; i < 50; ++i) {
    const auto& point = json.at("points").at(i);
    EXPECT_GT(point.at("x").get<double>(), 1e5);  // as given
    EXPECT_NEAR(point.at("height").get<double>(), own.at("points").at(i).at("height").get<double>(),
                1e-4);
  }
  ASSERT_EQ(run_lode({"height", dem_, scratch_ / "metres.csv", "--places-crs", "EPSG:32632",
                      "--out", scratch_ / "out.csv"})
                .exit_code,
            0);
  const std::string first = metres.substr(4, metres.find('\n', 4) - 4);
  EXPECT_NE(read_bytes(scratch_ / "out.csv").find("\n" + first + ","), std::string::npos);
}

TEST_F(cli_to_crs, height_refuses_places_of_no_crs_and_those_that_are_none) {
  const Words asked{"height", dem_, "--at", "10.5,45.5", "--places-crs"};
  const auto with = [&](const char* crs) {
    Words words = asked;
    words.emplace_back(crs);
    return run_lode(words);
  };
  for (const char* crs : {"EPSG:5773", "EPSG:4326+5773", "EPSG:4978", "metres", "EPSG:5513"}) {
    const Finished run = with(crs);
    // The last one is a CRS, but its axes are not x and y, which the terrain's place shows.
    EXPECT_EQ(run.exit_code, std::string(crs) == "EPSG:5513" ? 1 : 2) << crs;
    EXPECT_NE(run.err.find("--places-crs"), std::string::npos) << run.err;
  }
  EXPECT_EQ(with("EPSG:4326").exit_code, 0);
  // Beyond what the projection has.
  const Finished none = run_lode(
      {"height", dem_, "--at", "10.5,45.5", "--at", "1e9,1e9", "--places-crs", "EPSG:32632"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_NE(none.err.find("place 2: expected one that the CRS of the terrain has"),
            std::string::npos)
      << none.err;
  write_bytes(scratch_ / "plain.asc",
              "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  const Finished plain =
      run_lode({"height", scratch_ / "plain.asc", "--at", "1,1", "--places-crs", "EPSG:4326"});
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_NE(plain.err.find("expected terrain whose CRS is known"), std::string::npos) << plain.err;
}

TEST_F(cli_to_crs, surfaces_are_verified_where_they_are) {
  const std::string path = scratch_ / "dem.ply";
  const auto verified = [&](const char* crs) {
    const Finished run = run_lode(
        {"verify", dem_, "--surface", path, "--max-error", "20", "--to-crs", crs, "--json"});
    EXPECT_EQ(run.exit_code == 0, run.json().at("passed").get<bool>()) << run.err;
    return run;
  };
  const auto check = [](const Finished& run, const std::string& part) {
    const nlohmann::json json = run.json();
    for (const auto& one : json.at("checks"))
      if (one.at("name").get<std::string>().find(part) != std::string::npos) return one;
    return nlohmann::json();
  };
  const Finished made = run_lode(in_utm({"extract", dem_, path, "--max-error", "20", "--json"}));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Finished good = verified("EPSG:32632");
  EXPECT_EQ(good.exit_code, 0) << good.out;
  EXPECT_TRUE(check(good, "has samples").at("passed").get<bool>());
  const double there = made.json().at("to_crs").at("error").get<double>();
  const auto measured = check(good, "(measured)");
  EXPECT_NE(measured.at("detail").get<std::string>().find(fmt::format("up to {},", there)),
            std::string::npos)
      << measured;
  // In another CRS, or in none, its vertices are at no samples.
  EXPECT_EQ(verified("EPSG:32633").exit_code, 1);
  EXPECT_NE(run_lode({"verify", dem_, "--surface", path, "--max-error", "20"}).exit_code, 0);
  // A vertex that is a metre off is one, too.
  std::string bytes = read_bytes(path);
  const std::size_t first = bytes.find("end_header\n") + 11;
  double x = 0;
  std::memcpy(&x, &bytes[first], sizeof x);
  ASSERT_GT(x, 1e5);
  x += 1;
  std::memcpy(&bytes[first], &x, sizeof x);
  write_bytes(path, bytes);
  const Finished moved = verified("EPSG:32632");
  EXPECT_EQ(moved.exit_code, 1);
  EXPECT_FALSE(check(moved, "has samples").at("passed").get<bool>());
  EXPECT_NE(check(moved, "has samples").at("detail").get<std::string>().find("1 are not"),
            std::string::npos);
  // Volumes are in no CRS.
  EXPECT_EQ(run_lode({"verify", scratch_ / "none.lode", "--to-crs", "EPSG:32632"}).exit_code, 2);
}

/// Ends of ways likewise, of profiles and lines of sight.
TEST_F(cli_to_crs, ways_may_be_typed_in_another_crs) {
  const auto text = [](const std::array<double, 2>& place) {
    return fmt::format("{:.17g},{:.17g}", place[0], place[1]);
  };
  const std::string from = text(mapped_by_gdal(32632, 10.1, 45.2));
  const std::string to = text(mapped_by_gdal(32632, 10.8, 45.7));
  for (const char* command : {"profile", "sight"}) {
    const Words ends{command, dem_, "--max-error", "50", "--json", "--from"};
    const auto with = [&](Words more) {
      Words words = ends;
      words.insert(words.end(), more.begin(), more.end());
      return run_lode(words);
    };
    const auto own = with({"10.1,45.2", "--to", "10.8,45.7"}).json();
    const auto json = with({from, "--to", to, "--places-crs", "EPSG:32632"}).json();
    EXPECT_EQ(own.at("places_crs"), nullptr);
    EXPECT_EQ(json.at("places_crs"), "WGS 84 / UTM zone 32N");
    const char* length = std::string(command) == "profile" ? "length" : "distance";
    EXPECT_NEAR(json.at(length).get<double>(), own.at(length).get<double>(), 0.01);
    EXPECT_GT(own.at(length).get<double>(), 7e4);
    if (std::string(command) == "sight") EXPECT_EQ(json.at("verdict"), own.at("verdict"));
    const Finished none = with({from, "--to", "1e9,1e9", "--places-crs", "EPSG:32632"});
    EXPECT_EQ(none.exit_code, 1);
    EXPECT_NE(none.err.find("--to: expected one that the CRS of the terrain has"),
              std::string::npos)
        << none.err;
    EXPECT_EQ(with({from, "--to", to, "--places-crs", "EPSG:5773"}).exit_code, 2);
  }
}

}  // namespace
}  // namespace lode::test
