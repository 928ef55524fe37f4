// lode neighbours: triangles at places and beside them, as text, CSV and features.
#include <fmt/format.h>
#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>

#include <set>
#include <sstream>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

/// The world of dem_fixture.h: the middle of a pixel, rows from the north.
std::string pixel_place(double column, double row) {
  return fmt::format("{},{}", 500015 + 30 * column, 4000015 + 30 * (29 - row));
}

std::vector<std::vector<std::string>> rows_of(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream stream(csv);
  for (std::string line; std::getline(stream, line);) {
    std::vector<std::string>& row = rows.emplace_back(1);
    for (const char c : line) {
      if (c == ',')
        row.emplace_back();
      else
        row.back() += c;
    }
  }
  return rows;
}

class cli_neighbours : public testing::Test {
 protected:
  cli_neighbours() : dem_(scratch_ / "dem.asc") {
    write_dem(dem_);
    write_dem_crs(scratch_ / "dem.prj");
  }

  Scratch scratch_;
  std::string dem_;
};

TEST_F(cli_neighbours, are_beside_each_other) {
  const auto json =
      run_lode({"neighbours", dem_, "--at", pixel_place(20.3, 14.4), "--at", pixel_place(7, 9),
                "--at", "0,0", "--max-error", "10", "--rings", "4", "--json"})
          .json();
  EXPECT_EQ(json.at("command"), "neighbours");
  EXPECT_EQ(json.at("rings"), 4);
  EXPECT_EQ(json.at("outside"), 1);
  EXPECT_EQ(json.at("in_gaps"), 1);
  ASSERT_EQ(json.at("points").size(), 3U);
  EXPECT_EQ(json.at("points")[1].at("status"), "gap");
  EXPECT_TRUE(json.at("points")[2].at("triangles").empty());
  const auto& triangles = json.at("points")[0].at("triangles");
  ASSERT_GT(triangles.size(), 10U);
  EXPECT_EQ(json.at("answered_triangles"), triangles.size());
  std::map<int, nlohmann::json> by_number;
  for (const auto& one : triangles) by_number[one.at("triangle")] = one;
  std::size_t n_pairs = 0;
  for (const auto& [number, one] : by_number)
    for (std::size_t edge = 0; edge < 3; ++edge)
      for (const auto& other : one.at("beside")[edge]) {
        const auto at = by_number.find(other.at("triangle"));
        if (at == by_number.end()) {
          EXPECT_EQ(one.at("ring"), 4) << "of others all neighbours are there";
          continue;
        }
        const std::size_t other_edge = other.at("edge").get<std::size_t>() - 1;
        const auto& back = at->second.at("beside")[other_edge];
        EXPECT_EQ(back[0].at("triangle"), number);
        EXPECT_EQ(back[0].at("edge"), edge + 1);
        EXPECT_EQ(one.at("corners")[edge], at->second.at("corners")[(other_edge + 1) % 3]);
        EXPECT_EQ(one.at("corners")[(edge + 1) % 3], at->second.at("corners")[other_edge]);
        ++n_pairs;
      }
  EXPECT_GT(n_pairs, 2 * triangles.size());
}

TEST_F(cli_neighbours, are_the_same_in_csv_whoever_made_the_mesh_and_say_where_the_domain_ends) {
  const std::string file = scratch_ / "dem.lode";
  ASSERT_EQ(
      run_lode({"build", dem_, file, "--model", "delaunay_pyramid", "--levels", "20,10"}).exit_code,
      0);
  write_bytes(scratch_ / "places.csv",
              "x,y\n" + pixel_place(0, 0) + "\n" + pixel_place(21, 17.2) + "\n1,2\n");
  const Finished run = run_lode({"neighbours", file, scratch_ / "places.csv", "--max-error", "10",
                                 "--out", scratch_ / "near.csv", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_FALSE(run.json().contains("points"));
  EXPECT_NE(run.err.find("1 of 3 places lie in no triangle"), std::string::npos) << run.err;
  const auto rows = rows_of(read_bytes(scratch_ / "near.csv"));
  EXPECT_EQ(fmt::format("{}", fmt::join(rows.front(), ",")),
            "place,x,y,ring,triangle,x1,y1,height1,x2,y2,height2,x3,y3,height3,bound,bound_kind,"
            "beside1,beside2,beside3");
  std::size_t n_ends = 0;
  std::size_t n_of_first = 0;
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), 19U);
    n_of_first += row[0] == "1" && row[3] == "0" ? 1 : 0;
    if (row[0] == "1" && row[3] == "0")
      for (std::size_t i = 16; i < 19; ++i) n_ends += row[i] == "none" ? 1 : 0;
  }
  EXPECT_GE(n_of_first, 1U);
  EXPECT_EQ(n_ends, 2U) << "at a corner of the raster two edges end it";
  EXPECT_EQ(rows.back()[0], "3");
  EXPECT_EQ(rows.back()[4], "");
  // Other encodings of the pyramid have the same mesh.
  const std::string links = scratch_ / "links.lode";
  ASSERT_EQ(run_lode({"build", dem_, links, "--model", "complete_pyramid", "--levels", "20,10"})
                .exit_code,
            0);
  ASSERT_EQ(run_lode({"neighbours", links, scratch_ / "places.csv", "--max-error", "10", "--out",
                      scratch_ / "too.csv"})
                .exit_code,
            0);
  std::set<std::string> corners;
  std::set<std::string> too;
  for (const auto& row : rows)
    corners.insert(fmt::format("{}", fmt::join(row.begin() + 5, row.begin() + 14, ",")));
  for (const auto& row : rows_of(read_bytes(scratch_ / "too.csv"))) {
    // The first corner may be another one.
    for (const std::size_t first : {5U, 8U, 11U}) {
      std::string turned;
      for (std::size_t i = 0; i < 9; ++i)
        turned += (i > 0 ? "," : "") + row[5 + (first - 5 + i) % 9];
      if (corners.contains(turned)) too.insert(turned);
    }
  }
  EXPECT_EQ(corners, too);
}

TEST_F(cli_neighbours, are_polygons_that_gdal_reads) {
  GDALAllRegister();
  for (const char* name : {"near.gpkg", "near.geojson"}) {
    const std::string path = scratch_ / name;
    const Finished run = run_lode({"neighbours", dem_, "--at", pixel_place(20.3, 14.4),
                                   "--max-error", "10", "--out", path, "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    GDALDatasetH dataset = GDALOpenEx(path.c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr);
    ASSERT_NE(dataset, nullptr);
    OGRLayerH layer = GDALDatasetGetLayer(dataset, 0);
    EXPECT_STREQ(OGR_L_GetName(layer), "triangles");
    EXPECT_EQ(OGR_L_GetFeatureCount(layer, 1), 4);
    EXPECT_EQ(run.json().at("answered_triangles"), 4);
    std::size_t n_at_place = 0;
    while (OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
      const auto text = [&](const char* column) {
        return std::string(OGR_F_GetFieldAsString(feature, OGR_F_GetFieldIndex(feature, column)));
      };
      n_at_place += text("ring") == "0" ? 1 : 0;
      EXPECT_EQ(text("place"), "1");
      EXPECT_EQ(text("bound_kind"), "at samples");
      EXPECT_FALSE(text("beside2").empty());
      EXPECT_FALSE(text("height3").empty());
      OGRGeometryH shape = OGR_F_GetGeometryRef(feature);
      EXPECT_EQ(OGR_G_GetPointCount(OGR_G_GetGeometryRef(shape, 0)), 4);
      OGR_F_Destroy(feature);
    }
    EXPECT_EQ(n_at_place, 1U);
    GDALClose(dataset);
  }
}

TEST_F(cli_neighbours, are_several_beside_an_edge_where_squares_differ_in_size) {
  for (const std::string model : {"surface_quadtree", "quaternary_triangulation"}) {
    const Finished run =
        run_lode({"neighbours", dem_, "--model", model, "--at", pixel_place(20.3, 14.4),
                  "--max-error", "40", "--rings", "100", "--everywhere", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto json = run.json();
    EXPECT_EQ(json.at("bound_kind"), "everywhere");
    std::size_t n_several = 0;
    for (const auto& one : json.at("points")[0].at("triangles"))
      for (const auto& edge : one.at("beside")) n_several += edge.size() > 1 ? 1 : 0;
    EXPECT_GT(n_several, 0U) << model;
  }
  const Finished text = run_lode({"neighbours", dem_, "--at", pixel_place(20.3, 14.4)});
  EXPECT_NE(text.out.find("beside 1"), std::string::npos) << text.out;
}

TEST_F(cli_neighbours, refuse_what_cannot_be_meant) {
  const std::string at = pixel_place(3, 4);
  expect_refusal(run_lode({"neighbours", dem_}), 2, {"--at", "neither"});
  expect_refusal(run_lode({"neighbours", dem_, "--at", "1"}), 2, {"--at", "X,Y"});
  expect_refusal(run_lode({"neighbours", dem_, "--at", at, "--rings", "-1"}), 2, {"--rings"});
  expect_refusal(run_lode({"neighbours", dem_, "--at", at, "--rings", "1.5"}), 2, {"--rings"});
  expect_refusal(run_lode({"neighbours", dem_, "--at", at, "--out", scratch_ / "near.vtp"}), 2,
                 {"near.vtp", ".csv", ".gpkg"});
  expect_refusal(run_lode({"neighbours", dem_, "--at", at, "--out", "/none/such/near.csv"}), 1,
                 {"near.csv"});
  write_bytes(scratch_ / "places.csv", "1,2\n");
  expect_refusal(
      run_lode({"neighbours", dem_, scratch_ / "places.csv", "--out", scratch_ / "places.csv"}), 2,
      {"places.csv"});
  write_dem(scratch_ / "nowhere.asc");
  expect_refusal(run_lode({"neighbours", scratch_ / "nowhere.asc", "--at", at, "--out",
                           scratch_ / "near.geojson"}),
                 1, {"near.geojson", "CRS"});
  for (const auto& [n_columns, n_rows] : {std::pair{1, 1}, {1, 9}, {9, 1}}) {
    write_dem(scratch_ / "thin.asc", n_columns, n_rows);
    expect_refusal(run_lode({"neighbours", scratch_ / "thin.asc", "--at", at}), 1, {"thin.asc"});
  }
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode({"neighbours", scratch_ / "ball.nrrd", "--at", at}), 2,
                 {"ball.nrrd", "raster of heights"});
}

}  // namespace
}  // namespace lode::test
