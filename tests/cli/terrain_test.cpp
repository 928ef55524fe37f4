#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_terrain, goes_the_whole_path_in_every_surface_format) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto info = run_lode({"info", dem, "--json"}).json();
  EXPECT_EQ(info.at("columns"), 40);
  EXPECT_EQ(info.at("missing_samples"), 1);
  EXPECT_EQ(info.at("cells"), 39 * 29 - 4);
  EXPECT_EQ(info.at("format"), "AAIGrid");
  EXPECT_TRUE(info.at("crs").is_null());
  for (const char* name : {"dem.ply", "dem.vtp", "dem.obj", "dem.glb"}) {
    const std::string surface = scratch / name;
    const auto made = run_lode({"extract", dem, surface, "--max-error", "10", "--json"}).json();
    EXPECT_EQ(made.at("model"), "delaunay_selector");
    EXPECT_EQ(made.at("error_kind"), "at samples");
    EXPECT_LE(made.at("achieved_error").get<double>(), 10);
    EXPECT_EQ(made.at("missing_samples"), 1);
    EXPECT_EQ(made.at("error_met"), true);
    EXPECT_GT(made.at("triangles").get<int>(), 10);
    const Finished check = run_lode({"verify", dem, "--surface", surface, "--max-error", "10"});
    EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
    const std::string less = std::to_string(made.at("achieved_error").get<double>() * 0.9);
    const Finished strict = run_lode({"verify", dem, "--surface", surface, "--max-error", less});
    EXPECT_EQ(strict.exit_code, 1);
    EXPECT_NE(strict.err.find("samples are within the error"), std::string::npos) << strict.err;
  }
}

TEST(cli_terrain, writes_the_triangles_that_meet_a_window) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const std::string model = scratch / "dem.lode";
  ASSERT_EQ(run_lode({"build", dem, model, "--levels", "50,10"}).exit_code, 0);
  const auto extract = [&](const std::string& input, const char* clip) {
    return run_lode(
        {"extract", input, scratch / "part.ply", "--max-error", "10", "--clip", clip, "--json"});
  };
  const int all = run_lode({"extract", model, scratch / "all.ply", "--max-error", "10", "--json"})
                      .json()
                      .at("triangles");
  // The raster is from 500015 to 501185 and from 4000015 to 4000885.
  for (const std::string& input : {dem, model}) {
    const auto part = extract(input, "500200,500400,4000200,4000400").json();
    const int n = part.at("clip").at("triangles");
    EXPECT_GT(n, 0);
    EXPECT_LT(n, all / 2);
    EXPECT_EQ(part.at("triangles"), n);
    EXPECT_LT(part.at("vertices"), 3 * n);
    EXPECT_GE(part.at("clip").at("of_triangles"), all - 20);
    const auto info = read_bytes(scratch / "part.ply");
    EXPECT_NE(info.find("element face " + std::to_string(n) + "\n"), std::string::npos);
    EXPECT_EQ(extract(input, "0,1e9,0,1e9").json().at("clip").at("triangles"),
              extract(input, "0,1e9,0,1e9").json().at("clip").at("of_triangles"));
  }
  EXPECT_NE(run_lode({"extract", dem, scratch / "part.ply", "--max-error", "10", "--clip",
                      "500200,500400,4000200,4000400"})
                .out.find(" triangles meet it"),
            std::string::npos);
  ASSERT_EQ(run_lode({"extract", dem, scratch / "whole.ply", "--json"}).json().at("clip"), nullptr);
  const auto refuse = [&](const char* clip, int code, const std::vector<std::string>& words) {
    expect_refusal(run_lode({"extract", dem, scratch / "none.ply", "--clip", clip}), code, words);
  };
  refuse("0,1,0,1", 1, {"dem.asc", "clip", "meets none of"});
  EXPECT_EQ(extract(dem, "500300,500300,4000300,4000300").json().at("triangles").get<int>() > 0,
            true)
      << "a point";
  refuse("1,0,0,1", 2, {"--clip", "X0 <= X1"});
  refuse("0,1,0,1,0,1", 2, {"--clip", "four numbers"});
  expect_refusal(run_lode({"extract", dem, scratch / "part.tif", "--clip", "0,1,0,1"}), 2,
                 {"--clip", "part.tif"});
}

TEST(cli_terrain, is_called_terrain_in_gltf) {
  const Scratch scratch;
  write_dem(scratch / "dem.asc");
  ASSERT_EQ(run_lode({"extract", scratch / "dem.asc", scratch / "dem.glb"}).exit_code, 0);
  const std::string bytes = read_bytes(scratch / "dem.glb");
  EXPECT_NE(bytes.find("\"name\":\"terrain\""), std::string::npos);
  EXPECT_EQ(bytes.find("isosurface"), std::string::npos);
}

TEST(cli_terrain, is_in_metres_in_gltf) {
  const Scratch scratch;
  write_bytes(scratch / "dem.asc",
              "ncols 3\nnrows 3\nxllcorner 10\nyllcorner 58.5\ncellsize 1\n1 2 3\n4 9 6\n7 8 9\n");
  const auto matrix = [&](const std::string& prj) {
    write_bytes(scratch / "dem.prj", prj);
    const Finished run = run_lode({"extract", scratch / "dem.asc", scratch / "dem.glb"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const std::string bytes = read_bytes(scratch / "dem.glb");
    const std::string name = "\"matrix\":";
    const std::size_t first = bytes.find(name) + name.size();
    const auto all = nlohmann::json::parse(bytes.substr(first, bytes.find(']', first) + 1 - first));
    return std::array{all[0].get<double>(), -all[6].get<double>(), all[9].get<double>()};
  };
  const auto degrees = matrix(
      "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563]],"
      "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]");
  // The usual series of metres of a degree, at 60 degrees, good to a metre.
  EXPECT_NEAR(degrees[0], 111412.84 * 0.5 - 93.5 * -1 + 0.118 * 0.5, 1);
  EXPECT_NEAR(degrees[1], 111132.92 - 559.82 * -0.5 + 1.175 * -0.5, 1);
  EXPECT_EQ(degrees[2], 1);
  const auto feet = matrix(
      "PROJCS[\"here\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,"
      "298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],"
      "PROJECTION[\"Transverse_Mercator\"],PARAMETER[\"latitude_of_origin\",0],"
      "PARAMETER[\"central_meridian\",15],PARAMETER[\"scale_factor\",1],"
      "PARAMETER[\"false_easting\",0],PARAMETER[\"false_northing\",0],UNIT[\"foot\",0.3048]]");
  EXPECT_NEAR(feet[0], 0.3048, 1e-12);
  EXPECT_NEAR(feet[1], 0.3048, 1e-12);
  EXPECT_NEAR(feet[2], 0.3048, 1e-12) << "without a unit of their own";
  const Finished unknown = run_lode({"extract", scratch / "dem.asc", scratch / "dem.glb"});
  EXPECT_NE(unknown.err.find("heights are taken to be in the unit of x and y"), std::string::npos)
      << unknown.err;
  // Pictures and lines of sight take them for the same.
  const Finished drawn =
      run_lode({"render", scratch / "dem.asc", scratch / "dem.png", "--size", "64x48"});
  EXPECT_NE(drawn.err.find("heights are taken to be in the unit of x and y"), std::string::npos)
      << drawn.err;
}

TEST(cli_terrain, warns_of_boxes_that_lie_outside_in_part) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto warnings = [&](const char* box) {
    return run_lode({"extract", dem, scratch / "out.ply", "--model", "right_triangle_bisection",
                     "--max-error", "5", "--box", box, "--json"})
        .json()
        .at("warnings");
  };
  EXPECT_EQ(warnings("500000,501200,4000000,4000900").size(), 0U) << "all pixels";
  const auto half = warnings("499400,500600,4000000,4000900");
  ASSERT_EQ(half.size(), 1U);
  EXPECT_NE(half[0].get<std::string>().find(": 50 % of it lie outside"), std::string::npos) << half;
  const auto all = warnings("0,1,0,1");
  ASSERT_EQ(all.size(), 1U);
  EXPECT_NE(all[0].get<std::string>().find("meets no triangle"), std::string::npos) << all;
}

TEST(cli_terrain, says_what_terrain_is_of_files_that_are_none_and_why_of_those_that_are_broken) {
  const Scratch scratch;
  write_bytes(scratch / "x.foo", "nothing that is known");
  const auto extract = [&](const char* name) {
    return run_lode({"extract", scratch / name, scratch / "out.ply", "--max-error", "5"});
  };
  expect_refusal(extract("x.foo"), 2, {"x.foo", "raster of heights (.tif", ".las"});
  expect_refusal(run_lode({"info", scratch / "x.foo"}), 1, {"x.foo", ".dt1", ".las"});
  expect_refusal(extract("x.nrrd"), 2, {"x.nrrd", "cannot be opened"});
  write_ball(scratch / "x.nrrd");
  expect_refusal(extract("x.nrrd"), 2, {"--isovalue"});
  write_bytes(scratch / "x.dt1", "no tile of DTED");
  expect_refusal(extract("x.dt1"), 1, {"x.dt1", "DTED", "got"});
  write_dem(scratch / "dem.asc");
  const std::string model = scratch / "dem.lode";
  ASSERT_EQ(run_lode({"build", scratch / "dem.asc", model, "--levels", "5"}).exit_code, 0);
  write_bytes(scratch / "cut.lode", read_bytes(model).substr(0, 3000));
  for (const char* name : {"cut.lode", "absent.lode"}) {
    const Finished run = extract(name);
    expect_refusal(run, 2, {name});
    EXPECT_EQ(run.err.find("--isovalue"), std::string::npos) << run.err;
  }
}

TEST(cli_terrain, gives_the_same_bytes_for_any_number_of_threads) {
  const Scratch scratch;
  write_dem(scratch / "dem.asc");
  for (const char* n : {"1", "2", "5"})
    ASSERT_EQ(run_lode({"extract", scratch / "dem.asc", scratch / (std::string(n) + ".ply"),
                        "--max-error", "5", "--threads", n})
                  .exit_code,
              0);
  EXPECT_EQ(read_bytes(scratch / "1.ply"), read_bytes(scratch / "2.ply"));
  EXPECT_EQ(read_bytes(scratch / "1.ply"), read_bytes(scratch / "5.ply"));
}

TEST(cli_terrain, is_extracted_in_tiles_and_verified_as_such) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string out = scratch / "dem.ply";
  write_dem(dem, 400, 300);
  const Finished run =
      run_lode({"extract", dem, out, "--max-error", "5", "--insertion", "tiles", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json().at("insertion"), "tiles");
  EXPECT_LE(run.json().at("achieved_error").get<double>(), 5);
  const std::vector<std::string> verify{"verify", dem, "--surface", out, "--max-error", "5"};
  EXPECT_EQ(run_lode(verify).exit_code, 1) << "edges on seams are not Delaunay";
  std::vector<std::string> as_tiles = verify;
  as_tiles.insert(as_tiles.end(), {"--insertion", "tiles"});
  const Finished checked = run_lode(as_tiles);
  EXPECT_EQ(checked.exit_code, 0) << checked.out;
  EXPECT_NE(checked.out.find("on seams"), std::string::npos) << checked.out;
  as_tiles.insert(as_tiles.end(), {"--model", "delaunay_pyramid"});
  expect_refusal(run_lode(as_tiles), 2, {"--insertion", "delaunay_pyramid"});
}

TEST(cli_terrain, keeps_max_cells_and_warns_where_the_tolerance_is_not_met) {
  const Scratch scratch;
  write_dem(scratch / "dem.asc");
  const Finished run = run_lode({"extract", scratch / "dem.asc", scratch / "dem.ply", "--max-error",
                                 "1", "--max-cells", "50", "--json"});
  EXPECT_LE(run.json().at("triangles").get<int>(), 50);
  EXPECT_EQ(run.json().at("error_met"), false);
  EXPECT_EQ(run.json().at("insertion"), "strict");
  EXPECT_NE(run.err.find("--max-error is not met"), std::string::npos) << run.err;
}

TEST(cli_terrain, refuses_what_cannot_be_meant) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string out = scratch / "dem.ply";
  write_dem(dem);
  expect_refusal(run_lode({"extract", dem, out, "--isovalue", "3"}), 2,
                 {"--isovalue", "got terrain"});
  expect_refusal(run_lode({"extract", dem, out, "--box", "0,0,0,1,1,1"}), 2, {"--box"});
  expect_refusal(run_lode({"extract", dem, out, "--max-error", "-1"}), 2, {"--max-error", ">= 0"});
  expect_refusal(run_lode({"extract", dem, out, "--model", "tin"}), 2, {"delaunay_selector"});
  expect_refusal(run_lode({"extract", dem, out, "--insertion", "odd"}), 2,
                 {"'levels', 'strict' or 'tiles'"});
  for (const char* order : {"levels", "tiles"})
    expect_refusal(run_lode({"extract", dem, out, "--insertion", order, "--max-cells", "9"}), 2,
                   {"--insertion", "strict", order});
  expect_refusal(run_lode({"extract", dem, out, "--insertion", "tiles", "--keep-features",
                           "--feature-relief", "9"}),
                 2, {"--insertion", "'tiles'", "--keep-features"});
  write_bytes(scratch / "points.xyz", "0 0 1\n9 0 2\n0 9 3\n");
  expect_refusal(run_lode({"extract", scratch / "points.xyz", out, "--insertion", "tiles"}), 2,
                 {"--insertion", "'tiles'", "scattered points"});
  expect_refusal(run_lode({"extract", dem, out, "--encoding", "jpeg"}), 2, {"terrarium"});
  expect_refusal(run_lode({"extract", dem, out, "--max-cells", "0"}), 2, {"--max-cells"});
  expect_refusal(run_lode({"extract", dem, scratch / "dem.xyz"}), 2, {".ply"});
  expect_refusal(run_lode({"extract", dem, out, "--band", "2"}), 1,
                 {"dem.asc", "band from 1 to 1"});
  expect_refusal(run_lode({"verify", dem}), 2, {"--surface"});
  expect_refusal(run_lode({"verify", dem, "--surface", out}), 2, {"--max-error"});
  write_ball(scratch / "ball.nrrd");
  expect_refusal(
      run_lode({"extract", scratch / "ball.nrrd", out, "--isovalue", "3", "--band", "1"}), 2,
      {"--band", "ball.nrrd"});
  expect_refusal(run_lode({"info", scratch / "ball.nrrd", "--encoding", "terrarium"}), 2,
                 {"--encoding"});
}

TEST(cli_terrain, info_says_where_it_is) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto bare = run_lode({"info", dem, "--json"}).json();
  EXPECT_EQ(bare.at("extent").at("x"), (std::vector<double>{500015, 501185}));
  EXPECT_EQ(bare.at("extent").at("y"), (std::vector<double>{4000015, 4000885}));
  EXPECT_EQ(bare.at("cell_size"), (std::vector<double>{30, 30}));
  EXPECT_EQ(bare.at("place_unit"), nullptr);
  EXPECT_EQ(bare.at("pixels"), "areas");
  EXPECT_EQ(run_lode({"info", dem, "--crs", "EPSG:32611", "--json"}).json().at("place_unit"),
            "metre");
  const std::string text = run_lode({"info", dem}).out;
  for (const char* words : {"500015.00 to 501185.00", "4000885.00", "30 x 30", "areas"})
    EXPECT_NE(text.find(words), std::string::npos) << text;
  ASSERT_EQ(run_lode({"build", dem, scratch / "dem.lode"}).exit_code, 0);
  EXPECT_EQ(run_lode({"info", scratch / "dem.lode", "--json"}).json().at("extent"),
            bare.at("extent"));
}

TEST(cli_terrain, keeps_digits_of_esri_ascii) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_bytes(dem,
              "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n"
              "1000000000.00 1000000000.10 1000000000.20\n1000000000.10 1000000000.20 "
              "1000000000.00\n1000000000.20 1000000000.00 1000000000.10\n");
  EXPECT_NE(run_lode({"info", dem}).out.find("1000000000.0000 to 1000000000.2000"),
            std::string::npos)
      << run_lode({"info", dem}).out;
  const auto json =
      run_lode({"height", dem, "--at", "0.5,1.5", "--max-error", "0", "--json"}).json();
  EXPECT_EQ(json.at("points").at(0).at("height"), 1000000000.1) << json.dump(2);
}

TEST(cli_terrain, keeps_digits_of_heights_that_are_far_apart) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  std::string text = "ncols 20\nnrows 12\nxllcorner 500000\nyllcorner 4000000\ncellsize 30\n";
  for (int i = 0; i < 20 * 12; ++i)
    text += fmt::format("{:.2f} ", (i % 20 > 12 ? 1e9 : 0.0) + i * 37 % 101 / 100.0);
  write_bytes(dem, text);
  for (const char* name : {"out.ply", "out.obj", "out.vtp"}) {
    const std::string out = scratch / name;
    const Finished made = run_lode({"extract", dem, out, "--max-error", "0.05", "--json"});
    EXPECT_EQ(made.json().at("height_slack"), 0) << name;
    EXPECT_EQ(made.err.find("are floats"), std::string::npos) << made.err;
    const Finished check = run_lode({"verify", dem, "--surface", out, "--max-error", "0.05"});
    EXPECT_EQ(check.exit_code, 0) << name << check.out << check.err;
  }
  const Finished glb =
      run_lode({"extract", dem, scratch / "out.glb", "--max-error", "0.05", "--json"});
  EXPECT_GT(glb.json().at("height_slack"), 0.5);
  EXPECT_NE(glb.err.find("off by up to "), std::string::npos) << glb.err;
  EXPECT_NE(glb.err.find(".ply, .obj and .vtp hold them"), std::string::npos) << glb.err;
  EXPECT_NE(
      run_lode({"verify", dem, "--surface", scratch / "out.glb", "--max-error", "0.05"}).exit_code,
      0);
  expect_refusal(run_lode({"extract", dem, scratch / "out.stl", "--max-error", "0.05"}), 1,
                 {"out.stl", "STL holds float32", ".ply"});
  // Of scattered points, too.
  const std::string points = scratch / "wide.xyz";
  std::string places;
  for (int i = 0; i < 20 * 12; ++i)
    places += fmt::format("{} {} {:.2f}\n", i % 20 * 30 + i % 3, i / 20 * 30,
                          (i % 20 > 12 ? 1e9 : 0.0) + i * 37 % 101 / 100.0);
  write_bytes(points, places);
  ASSERT_EQ(run_lode({"extract", points, scratch / "wide.ply", "--max-error", "0.05"}).exit_code,
            0);
  const Finished check =
      run_lode({"verify", points, "--surface", scratch / "wide.ply", "--max-error", "0.05"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  // Nearer to one another than floats tell apart, many as high as others.
  std::string cluster = "0 0 0\n0 40 1\n1000000 60 1e9\n";
  for (int i = 0; i < 20 * 20; ++i)
    cluster += fmt::format("{:.2f} {:.2f} {}\n", 1e6 + 0.01 * (i % 20), 0.01 * (i / 20),
                           0.37 * (i * 7 % 3 % 2));
  write_bytes(points, cluster);
  const auto near =
      run_lode({"extract", points, scratch / "near.ply", "--max-error", "0", "--json"}).json();
  EXPECT_EQ(near.at("turned_triangles"), 0);
  const Finished near_check =
      run_lode({"verify", points, "--surface", scratch / "near.ply", "--max-error", "0"});
  EXPECT_EQ(near_check.exit_code, 0) << near_check.out << near_check.err;
  // GeoTIFF, by itself.
  const auto tif = run_lode({"extract", dem, scratch / "out.tif", "--max-error", "0.05", "--json"});
  EXPECT_LE(tif.json().at("raster").at("error").get<double>(), 0.05) << tif.out;
}

TEST(cli_terrain, refuses_a_crs_without_x_and_y) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  expect_refusal(run_lode({"info", dem, "--crs", "EPSG:5773"}), 1,
                 {"dem.asc", "geographic or projected", "heights alone", "--vertical-crs"});
  expect_refusal(run_lode({"info", dem, "--crs", "EPSG:4978"}), 1,
                 {"dem.asc", "geographic or projected", "geocentric"});
  EXPECT_EQ(run_lode({"info", dem, "--crs", "EPSG:32611+5773"}).exit_code, 0);
}

TEST(cli_terrain, says_how_growth_is_measured) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto focus = [&](const std::string& crs) {
    return run_lode({"extract", dem, scratch / "dem.ply", "--model", "delaunay_pyramid",
                     "--max-error", "1", "--focus-point", "500300,4000300", "--growth", "0.01",
                     "--crs", crs, "--json"})
        .json()
        .at("focus");
  };
  EXPECT_EQ(focus("EPSG:32611").at("distance_unit"), "metre");
  EXPECT_EQ(focus("EPSG:32611").at("ellipsoid"), nullptr);
  const Finished run =
      run_lode({"extract", dem, scratch / "dem.ply", "--model", "delaunay_pyramid", "--max-error",
                "1", "--focus-point", "500300,4000300", "--growth", "0.01"});
  EXPECT_NE(run.out.find("0.01, distances in units of x and y"), std::string::npos) << run.out;
}

TEST(cli_terrain, names_what_to_ask_instead) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string file = scratch / "dem.lode";
  write_dem(dem);
  ASSERT_EQ(run_lode({"build", dem, file}).exit_code, 0);
  expect_refusal(run_lode({"verify", file, "--surface", scratch / "dem.ply"}), 2,
                 {"dem.lode", "the raster", "--surface", "dem.ply"});
  expect_refusal(run_lode({"extract", dem, scratch / "dem.ply", "--tiles"}), 2, {"lode tiles"});
  write_dem(scratch / "row.asc", 40, 1);
  expect_refusal(run_lode({"tiles", scratch / "row.asc", scratch / "tiles", "--max-error", "1"}), 1,
                 {"row.asc", "once round the world", "40 columns of 30 degrees"});
}

TEST(cli_terrain, names_the_file_and_the_reason_where_there_is_no_terrain) {
  const Scratch scratch;
  const std::string out = scratch / "dem.ply";
  write_bytes(scratch / "empty.tif", "");
  write_bytes(scratch / "text.tif", "II*");
  write_dem(scratch / "row.asc", 40, 1);
  expect_refusal(run_lode({"extract", scratch / "empty.tif", out}), 1, {"empty.tif"});
  expect_refusal(run_lode({"extract", scratch / "text.tif", out}), 1,
                 {"text.tif", "expected a GeoTIFF"});
  expect_refusal(run_lode({"extract", scratch / "row.asc", out}), 1, {"row.asc", "40 x 1"});
  EXPECT_EQ(run_lode({"info", scratch / "row.asc"}).exit_code, 0);
  expect_refusal(run_lode({"extract", scratch / "absent.tif", out}), 1, {"absent.tif"});
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"empty.tif", "row.asc", "text.tif"}));
}

/// Of so many pages of 2 x 2 bytes, little-endian, without compression.
std::string tiff_of_pages(int n_pages) {
  const auto number = [](std::uint32_t value, int n_bytes) {
    std::string bytes;
    for (int i = 0; i < n_bytes; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
    return bytes;
  };
  constexpr std::uint32_t kHead = 8;
  constexpr std::uint32_t kSamples = 4;
  std::string file = "II" + number(42, 2) + number(kHead + kSamples, 4) + std::string("\1\2\3\4");
  for (int page = 0; page < n_pages; ++page) {
    // Width, height, bits, compression, grey, where strips are, samples, rows of a strip, bytes.
    const std::vector<std::array<std::uint32_t, 2>> tags{{256, 2}, {257, 2}, {258, 8},
                                                         {259, 1}, {262, 1}, {273, kHead},
                                                         {277, 1}, {278, 2}, {279, kSamples}};
    file += number(static_cast<std::uint32_t>(tags.size()), 2);
    for (const auto& [tag, value] : tags)
      file += number(tag, 2) + number(4, 2) + number(1, 4) + number(value, 4);
    const bool is_last = page + 1 == n_pages;
    file += number(is_last ? 0 : static_cast<std::uint32_t>(file.size()) + 4, 4);
  }
  return file;
}

TEST(cli_terrain_pages, are_told_where_one_is_read) {
  const Scratch scratch;
  for (const int n_pages : {1, 3}) {
    write_bytes(scratch / "dem.tif", tiff_of_pages(n_pages));
    const Finished run = run_lode({"extract", scratch / "dem.tif", scratch / "o.ply"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err.find("several pages") != std::string::npos, n_pages > 1) << run.err;
  }
}

}  // namespace
}  // namespace lode::test
