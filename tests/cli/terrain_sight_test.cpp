// lode sight: whether two places of a terrain see each other.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// A plain at 100 with a wall across it in column 20, 60 columns of 100 m.
void write_wall(const std::string& path, int height) {
  std::ofstream file(path);
  file << "ncols 60\nnrows 9\nxllcorner 0\nyllcorner 0\ncellsize 100\nnodata_value -9999\n";
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 60; ++x)
      file << (x == 50 && y == 0 ? -9999 : (x == 20 ? 100 + height : 100)) << ' ';
}

class cli_terrain_sight : public testing::Test {
 protected:
  cli_terrain_sight() : dem_(scratch_ / "wall.asc") { write_wall(dem_, 30); }

  [[nodiscard]] nlohmann::json sight(Words options) const {
    options.insert(options.begin(), {"sight", dem_, "--json"});
    return run_lode(options).json();
  }

  Scratch scratch_;
  std::string dem_;
};

TEST_F(cli_terrain_sight, sees_over_a_wall_or_not) {
  const Words way{"--from", "550,450", "--to", "4550,450", "--refraction", "1", "--max-error", "0"};
  const auto with = [&](const Words& more) {
    Words all = way;
    all.insert(all.end(), more.begin(), more.end());
    return sight(all);
  };
  const auto blocked = with({"--target-height", "10", "--observer-height", "10"});
  EXPECT_EQ(blocked.at("verdict"), "blocked");
  // The middle of column 20; the ray is at 110 there.
  EXPECT_NEAR(blocked.at("obstruction").at("x").get<double>(), 2050, 1e-6);
  EXPECT_NEAR(blocked.at("obstruction").at("distance").get<double>(), 1500, 1e-6);
  EXPECT_NEAR(blocked.at("obstruction").at("above_ray_low").get<double>(), 20, 1e-6);
  EXPECT_EQ(with({"--target-height", "31", "--observer-height", "31"}).at("verdict"), "visible");
  EXPECT_EQ(with({"--target-height", "31", "--observer-height", "29"}).at("verdict"), "blocked");
  const auto visible = with({"--target-height", "40", "--observer-height", "40"});
  EXPECT_NEAR(visible.at("nearest").at("above_ray_high").get<double>(), -10, 1e-6);
}

TEST_F(cli_terrain_sight, is_decided_exactly_where_the_error_leaves_it_open) {
  // At 40 of error the wall is no wall.
  const Words way{"--from", "550,450",           "--to", "4550,450",        "--max-error",
                  "40",     "--observer-height", "10",   "--target-height", "10"};
  EXPECT_EQ(sight(way).at("verdict"), "undecided");
  Words exact = way;
  exact.emplace_back("--exact");
  const auto decided = sight(exact);
  EXPECT_EQ(decided.at("verdict"), "blocked");
  EXPECT_GT(decided.at("rounds").get<int>(), 1);
  EXPECT_LT(decided.at("max_error").get<double>(), 40);
}

TEST_F(cli_terrain_sight, asks_a_file_no_finer_than_it_was_built) {
  const std::string file = scratch_ / "wall.lode";
  const auto build = [&](const char* model, const char* levels) {
    return run_lode({"build", dem_, file, "--model", model, "--levels", levels, "--json"})
        .json()
        .at("finest_error")
        .get<double>();
  };
  const auto ask = [&](const Words& more) {
    Words words{"sight",           file,          "--from", "550,450",           "--to",
                "4550,450",        "--max-error", "40",     "--observer-height", "10",
                "--target-height", "10"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  };
  for (const char* model : {"delaunay_pyramid", "hierarchical_delaunay"}) {
    SCOPED_TRACE(model);
    const double coarse = build(model, "40");
    ASSERT_GT(coarse, 20);
    const auto open = ask({"--exact", "--json"}).json();
    EXPECT_EQ(open.at("verdict"), "undecided");
    EXPECT_EQ(open.at("is_finest"), true);
    EXPECT_EQ(open.at("finest_error"), coarse);
    EXPECT_EQ(open.at("max_error"), coarse);
    const std::string text = ask({"--exact"}).out;
    EXPECT_NE(text.find("the file has no level finer than"), std::string::npos) << text;
    const double fine = build(model, "40,2");
    const auto decided = ask({"--exact", "--json"}).json();
    EXPECT_EQ(decided.at("verdict"), "blocked");
    EXPECT_EQ(decided.at("rounds"), 2);
    EXPECT_EQ(decided.at("max_error"), fine);
    EXPECT_EQ(ask({"--json"}).json().at("is_finest"), false);
    EXPECT_EQ(ask({}).out.find("no level finer"), std::string::npos);
  }
}

TEST_F(cli_terrain_sight, takes_the_curvature_of_the_earth_less_refraction) {
  // Over 2.4 km of plain the earth rises 2400^2 / (8 R) = 0.113 m in the middle.
  const auto over_plain = [&](const char* refraction, const char* height) {
    return sight({"--from", "2550,450", "--to", "4950,450", "--refraction", refraction,
                  "--observer-height", height, "--target-height", height, "--max-error", "0"})
        .at("verdict");
  };
  EXPECT_EQ(over_plain("0", "0.12"), "visible");
  EXPECT_EQ(over_plain("0", "0.105"), "blocked");
  EXPECT_EQ(over_plain("0.13", "0.105"), "visible");
  EXPECT_EQ(over_plain("0.13", "0.09"), "blocked");
  EXPECT_EQ(over_plain("1", "0.01"), "visible");
}

/// As .asc, every ten degrees from 175 degrees west on.
void write_globe(const std::string& path, int columns) {
  std::ofstream file(path);
  file << "ncols " << columns << "\nnrows 9\nxllcorner -180\nyllcorner -45\ncellsize 10\n";
  for (int i = 0; i < 9 * columns; ++i) file << i % 7 << ' ';
  std::ofstream(path.substr(0, path.size() - 4) + ".prj")
      << R"(GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],)"
         R"(PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]])";
}

TEST_F(cli_terrain_sight, wraps_surfaces_contours_and_models_on_request) {
  const std::string globe = scratch_ / "globe.asc";
  const std::string part = scratch_ / "part.asc";
  const std::string made = scratch_ / "globe.ply";
  const std::string model = scratch_ / "globe.lode";
  write_globe(globe, 36);
  write_globe(part, 30);
  const auto triangles = [&](const Words& more) {
    Words words{"extract", globe, made, "--max-error", "0", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = run_lode(words);
    EXPECT_EQ(run.err.find("--wrap closes it") == std::string::npos, !more.empty()) << run.err;
    return run.json().at("triangles").get<int>();
  };
  EXPECT_GT(triangles({"--wrap"}), triangles({}));
  triangles({"--wrap"});
  const auto verified = [&](const Words& more) {
    Words words{"verify", globe, "--surface", made, "--max-error", "0"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  };
  const Finished closed = verified({"--wrap"});
  EXPECT_EQ(closed.exit_code, 0) << closed.out;
  EXPECT_NE(closed.out.find("sides have the same vertices"), std::string::npos);
  EXPECT_NE(verified({}).exit_code, 0) << "a column of vertices is at no sample";
  const auto contours = run_lode({"contours", globe, scratch_ / "c.vtp", "--isovalue", "3",
                                  "--max-error", "0", "--wrap", "--json"});
  EXPECT_EQ(contours.exit_code, 0) << contours.err;
  EXPECT_TRUE(contours.json().at("warnings").empty());
  // What is built of it has heights all the way round.
  ASSERT_EQ(run_lode({"build", globe, model, "--levels", "0", "--wrap"}).exit_code, 0);
  EXPECT_EQ(run_lode({"verify", model, "--against", globe, "--wrap"}).exit_code, 0);
  // What they promise of their sides is nothing, and nothing is asked of them.
  for (const Words& kind :
       {Words{"--levels", "3,1,0"}, Words{"--model", "implicit_delaunay_pyramid"}}) {
    const std::string file = scratch_ / "m.lode";
    Words words{"build", globe, file, "--wrap"};
    words.insert(words.end(), kind.begin(), kind.end());
    ASSERT_EQ(run_lode(words).exit_code, 0);
    EXPECT_EQ(run_lode({"verify", file, "--against", globe, "--wrap"}).exit_code, 0) << kind[1];
  }
  // Extracted with a model, the vertices without a twin are counted, and told of where there are
  // some.
  for (const char* kind : {"delaunay_selector", "ternary_triangulation", "restricted_quadtree"}) {
    const Finished run =
        run_lode({"extract", globe, made, "--wrap", "--model", kind, "--max-error", "1", "--json"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto n = run.json().at("one_sided_vertices").get<int>();
    if (std::string_view(kind) == "delaunay_selector") EXPECT_EQ(n, 0);
    EXPECT_EQ(run.err.find("promises nothing") != std::string::npos, n > 0) << kind << run.err;
    if (n > 0) EXPECT_NE(run.err.find(std::to_string(n) + " vertices"), std::string::npos);
  }
  // A last column in the place of the first, with other heights.
  write_globe(scratch_ / "apart.asc", 37);
  const Finished apart = run_lode({"extract", scratch_ / "apart.asc", made, "--wrap"});
  EXPECT_NE(apart.exit_code, 0);
  EXPECT_NE(apart.err.find("got others, first in row 0"), std::string::npos) << apart.err;
  const auto seam = run_lode({"height", model, "--at", "180,0", "--json"}).json();
  EXPECT_EQ(seam.at("outside"), 0);
  for (const Words& refused : {Words{"extract", part, made, "--wrap"},
                               Words{"extract", globe, scratch_ / "o.tif", "--wrap"},
                               Words{"extract", globe, made, "--wrap", "--max-cells", "50"},
                               Words{"extract", globe, made, "--wrap", "--keep-features"},
                               Words{"extract", model, made, "--wrap"}}) {
    const Finished run = run_lode(refused);
    EXPECT_NE(run.exit_code, 0) << refused[1];
    EXPECT_NE(run.err.find("wrap"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("expected"), std::string::npos) << run.err;
  }
}

TEST_F(cli_terrain_sight, goes_the_short_way_round_the_earth_and_warns_where_it_cannot) {
  write_globe(scratch_ / "globe.asc", 36);
  write_globe(scratch_ / "part.asc", 30);
  const auto warned = [&](const char* command, const char* name, const char* from, const char* to) {
    const Finished run =
        run_lode({command, scratch_ / name, "--from", from, "--to", to, "--max-error", "0"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err.find("over 200 degrees of longitude; the other way round the earth, over 160") !=
           std::string::npos;
  };
  ASSERT_EQ(run_lode({"build", scratch_ / "globe.asc", scratch_ / "globe.lode", "--levels", "0"})
                .exit_code,
            0);
  for (const char* command :
       oracles::trials<std::vector<const char*>>({"sight", "profile"}, {"sight"})) {
    EXPECT_TRUE(warned(command, "globe.lode", "-100,0", "100,0"));
    EXPECT_TRUE(warned(command, "globe.lode", "100,20", "-100,0"));
    EXPECT_FALSE(warned(command, "globe.lode", "-80,0", "80,0"));
    EXPECT_FALSE(warned(command, "part.asc", "-100,0", "100,0")) << "no other way";
    EXPECT_FALSE(warned(command, "globe.asc", "-100,0", "100,0"));
  }
  const auto profile = [&](const char* from, const char* to) {
    return run_lode({"profile", scratch_ / "globe.asc", "--from", from, "--to", to, "--max-error",
                     "0", "--json"})
        .json();
  };
  const auto east = profile("100,0", "-100,0");
  EXPECT_TRUE(east.at("gaps").empty());
  EXPECT_NEAR(east.at("length").get<double>(), 6378137 * M_PI * 160 / 180, 1);
  EXPECT_EQ(east.at("points").back().at("x"), 260);
  // The same ground from the other end, and under other names.
  const auto west = profile("-100,0", "100,0");
  const auto again = profile("460,0", "260,0");
  ASSERT_EQ(west.at("points").size(), east.at("points").size());
  ASSERT_EQ(again.at("points").size(), east.at("points").size());
  for (std::size_t i = 0; i < east.at("points").size(); ++i) {
    const double z = east.at("points")[i].at("height");
    EXPECT_NEAR(west.at("points")[west.at("points").size() - 1 - i].at("height").get<double>(), z,
                1e-9);
    EXPECT_NEAR(again.at("points")[i].at("height").get<double>(), z, 1e-9);
  }
  // What is a turn apart is one place, and what is beyond a hundred turns is none.
  for (const char* command :
       oracles::trials<std::vector<const char*>>({"sight", "profile"}, {"profile"}))
    for (const char* far : {"370,0", "1e300,0", "-40000,0"}) {
      const Finished run =
          run_lode({command, scratch_ / "globe.asc", "--from", far, "--to", "10,0"});
      EXPECT_EQ(run.exit_code, 1) << run.err;
      EXPECT_NE(run.err.find("expected"), std::string::npos) << run.err;
      EXPECT_EQ(run.err.find("broken expectation"), std::string::npos) << run.err;
    }
  // Pixels' middles are at -175 and 175; between them is ground.
  const auto seam = run_lode({"height", scratch_ / "globe.asc", "--at", "180,0", "--at", "-180,0",
                              "--max-error", "0", "--json"})
                        .json();
  EXPECT_EQ(seam.at("outside"), 0);
  EXPECT_EQ(seam.at("points")[0].at("height"), seam.at("points")[1].at("height"));
}

TEST_F(cli_terrain_sight, goes_the_short_way_between_places_of_another_crs) {
  write_globe(scratch_ / "globe.asc", 36);
  const auto profile = [&](const Words& more) {
    Words words{"profile", scratch_ / "globe.asc", "--max-error", "0", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words).json();
  };
  // Mercator about 150 degrees east: 20 degrees on either side of 180 are 10 and 50 from there.
  const double degree = 6378137 * M_PI / 180;
  const auto own = profile({"--from", "160,0", "--to", "-160,0"});
  const auto there = profile({"--from", fmt::format("{},0", 10 * degree), "--to",
                              fmt::format("{},0", 50 * degree), "--places-crs", "EPSG:3832"});
  EXPECT_NEAR(own.at("length").get<double>(), 40 * degree, 1);
  EXPECT_NEAR(there.at("length").get<double>(), 40 * degree, 1);
  ASSERT_EQ(there.at("points").size(), own.at("points").size());
  for (std::size_t i = 0; i < own.at("points").size(); ++i)
    EXPECT_NEAR(there.at("points")[i].at("height").get<double>(),
                own.at("points")[i].at("height").get<double>(), 1e-6);
}

TEST_F(cli_terrain_sight, leaves_gaps_undecided_and_warns_of_units) {
  const auto gap = sight({"--from", "2550,850", "--to", "5950,850", "--max-error", "0"});
  EXPECT_EQ(gap.at("verdict"), "undecided");
  EXPECT_EQ(gap.at("has_gap"), true);
  const Finished run = run_lode({"sight", dem_, "--from", "550,450", "--to", "950,450"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("no CRS"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("--height-unit"), std::string::npos) << run.err;
  // In feet the wall is 9.1 m high: over 4 km the earth does the rest.
  const Words feet{
      "--from", "550,450",           "--to", "4550,450",        "--max-error", "0", "--height-unit",
      "ft",     "--observer-height", "30.5", "--target-height", "30.5"};
  const auto in_feet = sight(feet);
  EXPECT_EQ(in_feet.at("verdict"), "blocked");
  // 1500 * 2500 m (1 - 0.13) / (2 R), less the half foot that the ray is above the wall.
  EXPECT_NEAR(in_feet.at("obstruction").at("above_ray_low").get<double>(),
              1500.0 * 2500 * 0.87 / (2 * 6371008.8) / 0.3048 - 0.5, 1e-4);
}

TEST_F(cli_terrain_sight, refuses_what_cannot_be_meant) {
  const auto refuse = [&](Words options, const std::vector<std::string>& words, int code = 2) {
    options.insert(options.begin(), {"sight", dem_, "--from", "550,450"});
    expect_refusal(run_lode(options), code, words);
  };
  refuse({}, {"--to"});
  refuse({"--to", "550,450"}, {"--to"});
  refuse({"--to", "1,2", "--observer-height", "-1"}, {"--observer-height", ">= 0"});
  refuse({"--to", "1,2", "--target-height", "x"}, {"--target-height"});
  refuse({"--to", "1,2", "--refraction", "1.5"}, {"--refraction", "<= 1"});
  refuse({"--to", "1,2", "--height-unit", "ell"}, {"--height-unit", "us-ft"});
  refuse({"--to", "-1000,450"}, {"wall.asc", "target on the terrain"}, 1);
  refuse({"--to", "5050,850"}, {"wall.asc", "target on the terrain"}, 1);
  write_ball(scratch_ / "ball.nrrd");
  expect_refusal(run_lode({"sight", scratch_ / "ball.nrrd", "--from", "1,2", "--to", "3,4"}), 2,
                 {"ball.nrrd", "raster of heights"});
}

}  // namespace
}  // namespace lode::test
