// Lines that become edges of terrain: --keep-features and --breaklines.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

class cli_terrain_lines : public testing::Test {
 protected:
  cli_terrain_lines() : dem_(scratch_ / "dem.asc"), lines_(scratch_ / "lines.geojson") {
    std::ofstream dem(dem_);
    dem << "ncols 40\nnrows 30\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n";
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x)
        dem << std::round(500 + 100 * std::sin(0.4 * x) * std::cos(0.3 * y)) / 10 << ' ';
      dem << '\n';
    }
    std::ofstream(scratch_ / "dem.prj")
        << "PROJCS[\"WGS 84 / UTM zone 33N\",GEOGCS[\"WGS 84\","
           "DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
           "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\","
           "0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
           "PARAMETER[\"latitude_of_origin\",0],"
           "PARAMETER[\"central_meridian\",15],"
           "PARAMETER[\"scale_factor\",0.9996],"
           "PARAMETER[\"false_easting\",500000],"
           "PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
  }
  void write_lines(const std::string& geometry) const {
    std::ofstream(lines_)
        << R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":)"
        << R"("urn:ogc:def:crs:EPSG::32633"}},"features":[{"type":"Feature","properties":{},)"
        << R"("geometry":)" << geometry << "}]}";
  }

  Scratch scratch_;
  std::string dem_;
  std::string lines_;
};

TEST_F(cli_terrain_lines, of_features_are_counted_and_verified) {
  const std::string out = scratch_ / "out.ply";
  const auto json =
      run_lode({"extract", dem_, out, "--max-error", "20", "--feature-relief", "5", "--json"})
          .json();
  const auto& features = json.at("lines").at("features");
  EXPECT_EQ(features.at("relief"), 5);
  const auto& kept = features.at("kept");
  EXPECT_GT(kept.at("peaks"), 5);
  EXPECT_EQ(kept.at("peaks").get<int>() + kept.at("pits").get<int>(),
            kept.at("passes").get<int>() + 1);
  EXPECT_GT(features.at("ridges"), 5);
  EXPECT_EQ(
      run_lode({"verify", dem_, "--surface", out, "--max-error", "20", "--feature-relief", "5"})
          .exit_code,
      0);
  // What was made without has not all of them.
  EXPECT_EQ(run_lode({"extract", dem_, out, "--max-error", "20"}).exit_code, 0);
  const auto run =
      run_lode({"verify", dem_, "--surface", out, "--max-error", "20", "--feature-relief", "5"});
  EXPECT_NE(run.exit_code, 0);
  EXPECT_NE(run.err.find("lines are edges"), std::string::npos) << run.err;
}

TEST_F(cli_terrain_lines, that_break_the_surface_have_their_heights_in_answers) {
  write_lines(R"({"type":"LineString","coordinates":[[5.5,5.5,80],[30.5,5.5,180]]})");
  const auto json = run_lode({"profile", dem_, "--from", "5.5,5.5", "--to", "30.5,5.5",
                              "--breaklines", lines_, "--max-error", "3", "--json"})
                        .json();
  EXPECT_EQ(json.at("lines").at("breaklines").at("lines"), 1);
  EXPECT_EQ(json.at("lines").at("breaklines").at("own_heights"), 1);
  // Its 26 places are samples.
  EXPECT_EQ(json.at("lines").at("breaklines").at("replaced_samples"), 26);
  const auto height = run_lode({"height", dem_, "--at", "18,5.5", "--breaklines", lines_,
                                "--max-error", "3", "--json"})
                          .json();
  EXPECT_NEAR(height.at("points").at(0).at("height").get<double>(), 130, 1e-6);
  const auto draped = run_lode({"height", dem_, "--at", "18.5,5.5", "--breaklines", lines_,
                                "--drape", "--max-error", "0", "--json"})
                          .json();
  EXPECT_LT(draped.at("points").at(0).at("height").get<double>(), 61);
}

TEST_F(cli_terrain_lines, that_meet_at_different_heights_are_warned_of) {
  write_lines(R"({"type":"MultiLineString","coordinates":[[[5.5,5.5,80],[30.5,5.5,80]],)"
              R"([[10.5,2.5,50],[10.5,8.5,50]]]})");
  const Words words{"extract",      dem_,  scratch_ / "out.ply", "--max-error", "5",
                    "--breaklines", lines_};
  const Finished run = run_lode(words);
  EXPECT_NE(run.err.find("in 1 places lines meet at different heights, up to 30 apart"),
            std::string::npos)
      << run.err;
  EXPECT_NE(run.out.find("averaged"), std::string::npos) << run.out;
  Words as_json = words;
  as_json.emplace_back("--json");
  const auto lines = run_lode(as_json).json().at("lines").at("breaklines");
  EXPECT_EQ(lines.at("unequal_crossings"), 1);
  EXPECT_NEAR(lines.at("largest_spread").get<double>(), 30, 1e-9);
}

TEST_F(cli_terrain_lines, that_cannot_be_are_refused) {
  const std::string out = scratch_ / "out.ply";
  const auto expect_refused = [&](std::vector<std::string> more, const std::string& reason) {
    std::vector<std::string> arguments{"extract", dem_, out, "--max-error", "5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = run_lode(arguments);
    EXPECT_NE(run.exit_code, 0) << reason;
    EXPECT_NE(run.err.find(reason), std::string::npos) << run.err;
  };
  expect_refused({"--drape"}, "expected --breaklines");
  expect_refused({"--drape-error", "-1", "--breaklines", lines_}, "--drape-error: expected");
  expect_refused({"--feature-relief", "-1"}, "--feature-relief: expected a number >= 0");
  expect_refused({"--breaklines", lines_, "--model", "surface_quadtree"}, "delaunay_pyramid");
  expect_refused({"--breaklines", lines_, "--model", "restricted_quadtree"}, "delaunay_selector");
  expect_refused({"--breaklines", scratch_ / "none.geojson"}, "none.geojson");
  expect_refused({"--breaklines", dem_}, ".geojson");
  write_lines(R"({"type":"Point","coordinates":[5,5]})");
  expect_refused({"--breaklines", lines_}, "expected lines, got a point in feature 0");
  write_lines(R"({"type":"LineString","coordinates":[]})");
  expect_refused({"--breaklines", lines_}, "empty geometry");
}

/// A raster in longitudes from 245 degrees on, and what files say of places there: -115 and on.
TEST_F(cli_terrain_lines, a_turn_away_are_where_the_terrain_is) {
  const std::string dem = scratch_ / "east.asc";
  std::ofstream(dem) << std::ifstream(dem_).rdbuf();
  std::string text = read_bytes(dem);
  text.replace(text.find("xllcorner 0"), 11, "xllcorner 245");
  text.replace(text.find("cellsize 1"), 10, "cellsize 0.1");
  write_bytes(dem, text);
  write_bytes(scratch_ / "east.prj",
              "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
              "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]");
  write_bytes(lines_, R"({"type":"LineString","coordinates":[[-114.5,0.5,80],[-112.2,1.7,80]]})");
  const std::string out = scratch_ / "out.ply";
  const auto lined =
      run_lode({"extract", dem, out, "--max-error", "5", "--breaklines", lines_, "--json"}).json();
  EXPECT_EQ(lined.at("lines").at("breaklines").at("outside"), 0);
  EXPECT_GT(lined.at("lines").at("edges"), 0);
  const auto triangles = [&](const std::string& option, const std::string& value) {
    Words words{"extract",     dem,   out,    "--model", "delaunay_pyramid",
                "--max-error", "0.5", option, value};
    if (option == "--focus-point") words.insert(words.end(), {"--growth", "0.001"});
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.err.find("outside of the terrain"), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find("meets no triangle"), std::string::npos) << run.err;
    const auto json = run.json();
    const auto& clip = json.at("clip");
    return clip.is_null() ? json.at("triangles") : clip.at("triangles");
  };
  for (const char* option : {"--box", "--clip"})
    EXPECT_EQ(triangles(option, "-114.5,-113,0.5,1.5"), triangles(option, "245.5,247,0.5,1.5"));
  EXPECT_EQ(triangles("--focus-point", "-114,1"), triangles("--focus-point", "246,1"));
  const auto profile = [&](const std::string& from, const std::string& to) {
    return run_lode({"profile", dem, "--from", from, "--to", to, "--json"}).json().at("points");
  };
  EXPECT_EQ(profile("-114.5,1", "-112,2"), profile("245.5,1", "248,2"));
  const auto sight = [&](const std::string& from, const std::string& to) {
    return run_lode({"sight", dem, "--from", from, "--to", to, "--json"}).json().at("verdict");
  };
  EXPECT_EQ(sight("-114.5,1", "-112,2"), sight("245.5,1", "248,2"));
}

TEST_F(cli_terrain_lines, are_in_rasters_too) {
  const std::string out = scratch_ / "out.tif";
  EXPECT_EQ(run_lode({"extract", dem_, out, "--max-error", "5", "--keep-features"}).exit_code, 0);
  write_lines(R"({"type":"LineString","coordinates":[[5.5,5.5,80],[30.2,17.7,80]]})");
  const Words words{"extract", dem_, out, "--max-error", "5", "--breaklines", lines_};
  expect_refusal(run_lode(words), 1, {"expected a cell", "breaklines"});
  Words with_cell = words;
  with_cell.insert(with_cell.end(), {"--cell", "0.5"});
  EXPECT_EQ(run_lode(with_cell).exit_code, 0);
}

TEST_F(cli_terrain_lines, within_a_number_of_triangles_are_verified_with_their_drape_error) {
  write_lines(R"({"type":"LineString","coordinates":[[2,3],[37,26]]})");
  const std::string out = scratch_ / "out.ply";
  const auto json = run_lode({"extract", dem_, out, "--max-cells", "150", "--breaklines", lines_,
                              "--drape-error", "1", "--json"})
                        .json();
  EXPECT_EQ(json.at("lines").at("breaklines").at("drape_error"), 1);
  EXPECT_LE(json.at("triangles"), 150);
  const std::string error = std::to_string(json.at("achieved_error").get<double>() + 1e-6);
  EXPECT_EQ(run_lode({"verify", dem_, "--surface", out, "--max-error", error, "--breaklines",
                      lines_, "--drape-error", "1"})
                .exit_code,
            0);
}

/// Built once, then asked at any tolerance; and built for one question.
TEST_F(cli_terrain_lines, are_edges_of_models_of_all_tolerances) {
  write_lines(R"({"type":"LineString","coordinates":[[5.5,5.5,80],[30.2,17.7,80]]})");
  const std::string file = scratch_ / "dem.lode";
  const std::string out = scratch_ / "out.ply";
  const Words lines{"--breaklines", lines_, "--feature-relief", "5"};
  const auto with_lines = [&](Words words) {
    words.insert(words.end(), lines.begin(), lines.end());
    return run_lode(words);
  };
  for (const std::string& model : oracles::trials(
           Words{"delaunay_pyramid", "ternary_triangulation", "implicit_delaunay_pyramid"},
           Words{"ternary_triangulation", "implicit_delaunay_pyramid"})) {
    SCOPED_TRACE(model);
    Words build{"build", dem_, file, "--model", model, "--json"};
    if (model != "implicit_delaunay_pyramid") build.insert(build.end(), {"--levels", "40,5"});
    const auto json = with_lines(build).json();
    EXPECT_GT(json.at("fixed_edges"), 5);
    EXPECT_EQ(json.at("is_of_points"), true);
    EXPECT_EQ(with_lines({"verify", file, "--against", dem_}).exit_code, 0);
    expect_refusal(run_lode({"verify", file, "--against", dem_}), 1, {"dem.asc", "its lines"});
    expect_refusal(run_lode({"verify", file, "--against", dem_, "--keep-features"}), 1,
                   {"dem.asc", "read as it was"});
    EXPECT_EQ(run_lode({"extract", file, out, "--max-error", "17"}).exit_code, 0);
    Words verify{"verify", dem_, "--surface", out, "--max-error", "17", "--model", model,
                 // As when it was built, whatever the tolerance.
                 "--drape-error", "0.1"};
    EXPECT_EQ(with_lines(verify).exit_code, 0);
    const auto height =
        run_lode({"height", file, "--at", "17.85,11.6", "--max-error", "40", "--json"}).json();
    // The line is rounded to 1024ths of a cell, beside which there is a cliff.
    EXPECT_NEAR(height.at("points").at(0).at("height").get<double>(), 80, 0.05);
    expect_refusal(run_lode({"extract", file, scratch_ / "out.tif"}), 1, {"a cell"});
    EXPECT_EQ(run_lode({"extract", file, scratch_ / "out.tif", "--cell", "1"}).exit_code, 0);
    EXPECT_EQ(with_lines({"extract", dem_, out, "--model", model, "--max-error", "9", "--box",
                          "3,10,3,10", "--max-error-outside", "60"})
                  .exit_code,
              0);
  }
}

/// Python inserts the vertices again, and follows each fixed edge through each level.
TEST_F(cli_terrain_lines, in_files_are_read_from_the_format_document_alone) {
  write_lines(R"({"type":"LineString","coordinates":[[5.5,5.5],[30.2,17.7]]})");
  const std::string file = scratch_ / "dem.lode";
  for (const std::string model :
       {"delaunay_pyramid", "ternary_triangulation", "implicit_delaunay_pyramid"}) {
    SCOPED_TRACE(model);
    for (const bool has_breaklines : {false, true}) {
      // Of the first and the last with them, of the other without, in a fast run.
      if (!oracles::trials(true, has_breaklines != (model == "ternary_triangulation"))) continue;
      Words build{"build", dem_, file, "--model", model, "--feature-relief", "3", "--json"};
      if (has_breaklines) build.insert(build.end(), {"--breaklines", lines_});
      if (model != "implicit_delaunay_pyramid") build.insert(build.end(), {"--levels", "5,1"});
      const auto built = run_lode(build).json();
      std::string levels;
      for (const auto& level : built.at("levels"))
        levels += (levels.empty() ? "" : ", ") + std::to_string(level.at("triangles").get<int>());
      const std::string said = run_oracle(LODE_INSERTIONS_READER, "'" + file + "' '" + dem_ + "'");
      EXPECT_NE(said.find(" levels [" + levels + "]\n"), std::string::npos) << said << levels;
    }
  }
}

TEST_F(cli_terrain_lines, outside_are_told) {
  write_lines(
      R"({"type":"MultiLineString","coordinates":[[[-50,-50],[-40,-40]],[[5,5],[100,25]]]})");
  const auto run =
      run_lode({"extract", dem_, scratch_ / "out.ply", "--max-error", "5", "--breaklines", lines_});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("1 of 2 lines lie outside"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("1 of 2 lines are cut"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace lode::test
