// lode height, profile: questions to the TIN of a raster of heights.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// Of the file that write_dem() writes: the middle of a pixel, rows from the north.
std::string place_of(double column, double row) {
  return std::to_string(500015 + 30 * column) + ',' + std::to_string(4000015 + 30 * (29 - row));
}

double dem_height(int x, int y) {
  return std::round(900 + 300 * std::sin(0.2 * x) * std::cos(0.3 * y));
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class cli_terrain_query : public testing::Test {
 protected:
  cli_terrain_query() : dem_(scratch_ / "dem.asc") { write_dem(dem_); }

  Scratch scratch_;
  std::string dem_;
};

TEST_F(cli_terrain_query, gives_heights_at_places_of_a_file_with_bounds) {
  std::string csv = "name,X,Y\n";
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) csv += "p," + place_of(x, y) + "\n";
  csv += "off," + place_of(-1, 3) + "\n";
  write_bytes(scratch_ / "places.csv", csv);
  for (const char* max_error : {"0", "15"}) {
    const std::string out = scratch_ / "heights.csv";
    const Finished run = run_lode({"height", dem_, scratch_ / "places.csv", "--out", out,
                                   "--max-error", max_error, "--json"});
    const auto json = run.json();
    EXPECT_EQ(json.at("places"), 1201);
    EXPECT_EQ(json.at("outside"), 1);
    EXPECT_EQ(json.at("in_gaps"), 1);
    EXPECT_EQ(json.at("bound_kind"), "at samples");
    EXPECT_NE(run.err.find("2 of 1201 places have no height"), std::string::npos) << run.err;
    const auto lines = lines_of(read_bytes(out));
    ASSERT_EQ(lines.size(), 1202U);
    EXPECT_EQ(lines[0], "x,y,height,bound,bound_kind");
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        double px = 0;
        double py = 0;
        double z = 0;
        double bound = 0;
        const std::string& line = lines[static_cast<std::size_t>(1 + 40 * y + x)];
        const int n = std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &px, &py, &z, &bound);
        if (x == 7 && y == 9) {
          EXPECT_EQ(n, 2);
          EXPECT_TRUE(line.ends_with(",,,")) << line;
          continue;
        }
        ASSERT_EQ(n, 4) << line;
        EXPECT_LE(std::abs(z - dem_height(x, y)), bound);
        EXPECT_TRUE(line.ends_with(",at samples"));
      }
  }
}

TEST_F(cli_terrain_query, gives_heights_at_places_as_typed) {
  const auto json = run_lode({"height", dem_, "--at", place_of(3, 4), "--at", place_of(7, 9),
                              "--at", "0,0", "--max-error", "0", "--json"})
                        .json();
  ASSERT_EQ(json.at("points").size(), 3U);
  EXPECT_EQ(json.at("points")[0].at("height"), dem_height(3, 4));
  EXPECT_EQ(json.at("points")[1].at("status"), "gap");
  EXPECT_TRUE(json.at("points")[1].at("height").is_null());
  EXPECT_EQ(json.at("points")[2].at("status"), "outside");
  const Finished text = run_lode({"height", dem_, "--at", place_of(3, 4)});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_NE(text.out.find("at samples"), std::string::npos) << text.out;
}

TEST_F(cli_terrain_query, takes_places_with_headings_of_many_kinds) {
  const std::string at = place_of(3, 4);
  const std::size_t comma = at.find(',');
  const std::string x = at.substr(0, comma);
  const std::string y = at.substr(comma + 1);
  for (const std::string& text :
       {x + "," + y + "\n", x + " " + y + "\r\n", "x,y\n" + x + "," + y + "\n",
        "\xEF\xBB\xBF\"Lat\";\"Lon\"\n" + y + ";" + x, "# note\n\n" + x + "\t" + y,
        "id,northing,easting,z\n7," + y + "," + x + ",\n", "a,b,c\n" + x + ", " + y + ",text\n"}) {
    write_bytes(scratch_ / "places.csv", text);
    const auto json =
        run_lode({"height", dem_, scratch_ / "places.csv", "--max-error", "0", "--json"}).json();
    ASSERT_EQ(json.at("points").size(), 1U) << text;
    EXPECT_EQ(json.at("points")[0].at("height"), dem_height(3, 4)) << text;
  }
}

TEST_F(cli_terrain_query, refuses_places_that_are_none) {
  const std::string places = scratch_ / "places.csv";
  const auto expect_line = [&](const std::string& text, const std::vector<std::string>& words) {
    write_bytes(places, text);
    std::vector<std::string> all = words;
    all.push_back("places.csv");
    expect_refusal(run_lode({"height", dem_, places}), 1, all);
  };
  expect_line("", {"got none"});
  expect_line("x,y\n", {"got none"});
  expect_line("1,2\n3\n", {"line 2"});
  expect_line("1,2,3\n", {"line 1"});
  expect_line("nan,1\n", {"line 1"});
  expect_line("x,y\n1,inf\n", {"line 2"});
  expect_line("x,y\n1,1e999\n", {"line 2"});
  expect_line("x,y\n1,2\nthree,four\n", {"line 3", "three,four"});
  expect_line("1,,2\n", {"line 1"});
  expect_line(std::string("\0\1\2\xFF", 4), {"line 1"});
  expect_refusal(run_lode({"height", dem_, scratch_ / "absent.csv"}), 1, {"absent.csv"});
  expect_refusal(run_lode({"height", dem_, scratch_.path()}), 1, {});
}

TEST_F(cli_terrain_query, refuses_what_cannot_be_meant) {
  write_ball(scratch_ / "ball.nrrd");
  for (const std::string command : {"height", "profile"}) {
    Words words{command, scratch_ / "ball.nrrd"};
    const Words more =
        command == "height" ? Words{"--at", "1,2"} : Words{"--from", "1,2", "--to", "3,4"};
    words.insert(words.end(), more.begin(), more.end());
    expect_refusal(run_lode(words), 2, {"ball.nrrd", "raster of heights", "lode probe"});
    words[1] = dem_;
    const auto with = [&](Words options) {
      options.insert(options.begin(), words.begin(), words.end());
      return run_lode(options);
    };
    expect_refusal(with({"--max-error", "-1"}), 2, {"--max-error"});
    expect_refusal(with({"--insertion", "odd"}), 2, {"--insertion"});
    expect_refusal(with({"--nodata", "x"}), 2, {"--nodata"});
    expect_refusal(with({"--out", scratch_ / "out.txt"}), 2, {"out.txt", ".csv"});
    expect_refusal(with({"--out", "/none/such/out.csv"}), 1, {"out.csv"});
    words[1] = scratch_ / "absent.tif";
    expect_refusal(with({}), 1, {"absent.tif"});
  }
  expect_refusal(run_lode({"height", dem_}), 2, {"--at", "neither"});
  expect_refusal(run_lode({"height", dem_, "--at", "1,2,3"}), 2, {"--at", "X,Y"});
  expect_refusal(run_lode({"height", dem_, dem_, "-o", dem_}), 2, {".csv"});
  expect_refusal(run_lode({"profile", dem_, "--from", "1,2"}), 2, {"--to"});
  expect_refusal(run_lode({"profile", dem_, "--from", "1,2", "--to", "1,2"}), 2, {"--to"});
  expect_refusal(run_lode({"profile", dem_, "--from", "1,nan", "--to", "1,2"}), 2, {"--from"});
  write_dem(scratch_ / "row.asc", 40, 1);
  expect_refusal(run_lode({"height", scratch_ / "row.asc", "--at", "1,2"}), 1,
                 {"row.asc", "40 x 1"});
}

TEST_F(cli_terrain_query, names_rasters_that_have_no_terrain) {
  write_bytes(scratch_ / "one.asc", "ncols 1\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n7\n");
  write_bytes(scratch_ / "void.asc",
              "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value -1\n"
              "-1 -1 -1\n-1 -1 -1\n");
  write_bytes(scratch_ / "text.asc", "once upon a time\n");
  for (const std::string name : {"one.asc", "void.asc", "text.asc"})
    for (const std::string max_error : {"0", "1"})
      for (const Words& words :
           {Words{"height", "--at", "1,1"}, Words{"profile", "--from", "0,0", "--to", "1,1"},
            Words{"sight", "--from", "0,0", "--to", "1,1"},
            Words{"contours", scratch_ / "out.gpkg", "--interval", "1"}}) {
        if (!oracles::trials(true, (max_error == "0") == (words[0] == "height"))) continue;
        Words all{words[0], scratch_ / name, "--max-error", max_error};
        all.insert(all.end(), words.begin() + 1, words.end());
        expect_refusal(run_lode(all), 1, {name});
      }
  EXPECT_EQ(scratch_.files(),
            (std::vector<std::string>{"dem.asc", "one.asc", "text.asc", "void.asc"}));
}

TEST_F(cli_terrain_query, follows_segments_and_tells_gaps) {
  const std::string out = scratch_ / "profile.csv";
  const auto json = run_lode({"profile", dem_, "--from", place_of(-2, 9), "--to", place_of(39, 9),
                              "--max-error", "0", "--out", out, "--json"})
                        .json();
  EXPECT_NEAR(json.at("length").get<double>(), 41 * 30, 1e-6);
  EXPECT_EQ(json.at("parts"), 2);
  ASSERT_EQ(json.at("gaps").size(), 2U);
  EXPECT_NEAR(json.at("gaps")[0].at("end").get<double>(), 60, 1e-6);
  EXPECT_NEAR(json.at("gaps")[1].at("begin").get<double>(), 8 * 30, 1e-6);
  EXPECT_NEAR(json.at("gaps")[1].at("end").get<double>(), 10 * 30, 1e-6);
  EXPECT_TRUE(json.at("distance_unit").is_null());
  const auto lines = lines_of(read_bytes(out));
  EXPECT_EQ(lines[0], "part,distance,x,y,height,bound");
  EXPECT_EQ(json.at("profile_rows"), lines.size() - 1);
  EXPECT_EQ(json.at("rows"), 30);
  // At full resolution rows of the raster are met at every sample that is a vertex.
  for (std::size_t i = 1; i < lines.size(); ++i) {
    double distance = 0;
    double height = 0;
    ASSERT_EQ(std::sscanf(lines[i].c_str(), "%*d,%lf,%*f,%*f,%lf", &distance, &height), 2);
    const double column = distance / 30 - 2;
    if (std::abs(column - std::round(column)) < 1e-6)
      EXPECT_NEAR(height, dem_height(static_cast<int>(std::lround(column)), 9), 1e-6);
  }
  const Finished off = run_lode({"profile", dem_, "--from", "0,0", "--to", "5,5", "--json"});
  EXPECT_EQ(off.json().at("profile_rows"), 0);
  EXPECT_NE(off.err.find("meets no terrain"), std::string::npos);
}

/// A thousand million and some centimetres: seven digits would show the same everywhere.
TEST_F(cli_terrain_query, shows_as_many_digits_as_the_relief_takes) {
  const std::string high = scratch_ / "high.xyz";
  std::string text;
  for (int i = 0; i < 6; ++i)
    text += fmt::format("{} {} {}\n", i % 3, i / 3, 1000000000.25 + 0.25 * (i % 3));
  write_bytes(high, text);
  for (const Words& words : {Words{"info", high}, Words{"profile", high, "--from", "0,0.5", "--to",
                                                        "2,0.5", "--max-error", "0"}}) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.out.find("1000000000.2500 to 1000000000.7500"), std::string::npos)
        << run.out << run.err;
  }
  const Finished at = run_lode({"height", high, "--at", "1,0.5", "--max-error", "0"});
  EXPECT_NE(at.out.find("1000000000.5000"), std::string::npos) << at.out;
  const Finished lines = run_lode({"contours", high, scratch_ / "high.vtp", "--isovalue",
                                   "1000000000.375", "--isovalue", "1000000000.625"});
  EXPECT_NE(lines.out.find("2 from 1000000000.3750 to 1000000000.6250"), std::string::npos)
      << lines.out << lines.err;
}

TEST_F(cli_terrain_query, bounds_hold_everywhere_where_all_heights_are_at_hand) {
  const std::string model = scratch_ / "dem.lode";
  const auto bound = [&](const std::string& of, const Words& more) {
    Words words{"height", of, "--at", place_of(7.3, 11.4), "--max-error", "60", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const auto json = run_lode(words).json();
    EXPECT_EQ(json.at("bound_kind"), more.empty() ? "at samples" : "everywhere");
    EXPECT_EQ(json.at("error_kind"), json.at("bound_kind"));
    return json.at("achieved_error").get<double>();
  };
  EXPECT_GT(bound(dem_, {"--everywhere"}), bound(dem_, {}));
  for (const char* name : {"right_triangle_bisection", "restricted_quadtree"}) {
    ASSERT_EQ(run_lode({"build", dem_, model, "--model", name}).exit_code, 0);
    EXPECT_GE(bound(model, {"--everywhere"}), bound(model, {}));
  }
  ASSERT_EQ(run_lode({"build", dem_, model, "--levels", "60"}).exit_code, 0);
  expect_refusal(run_lode({"height", model, "--at", place_of(7, 11), "--everywhere"}), 1,
                 {"--everywhere", "all heights", "quadtrees"});
  // Its file has all heights, but not at hand; features are found in it all the same.
  ASSERT_EQ(run_lode({"build", dem_, model, "--model", "implicit_delaunay_pyramid"}).exit_code, 0);
  expect_refusal(run_lode({"height", model, "--at", place_of(7, 11), "--everywhere"}), 1,
                 {"all heights at hand", "implicit_delaunay_pyramid"});
  EXPECT_EQ(run_lode({"features", model, scratch_ / "features.gpkg"}).exit_code, 0);
  const Words way{"--from", place_of(3, 11), "--to", place_of(30, 12)};
  const auto sight = [&](const std::string& of) {
    Words words{"sight",           of,    "--max-error", "60", "--observer-height", "900",
                "--target-height", "900", "--json"};
    words.insert(words.end(), way.begin(), way.end());
    return run_lode(words);
  };
  EXPECT_EQ(sight(dem_).json().at("error_kind"), "everywhere");
  const Finished of_file = sight(model);
  EXPECT_EQ(of_file.json().at("error_kind"), "at samples");
  EXPECT_NE(of_file.err.find("hold at its samples alone"), std::string::npos) << of_file.err;
  const auto profile = run_lode({"profile", dem_, way[0], way[1], way[2], way[3], "--max-error",
                                 "60", "--everywhere", "--json"});
  EXPECT_EQ(profile.json().at("bound_kind"), "everywhere");
}

}  // namespace
}  // namespace lode::test
