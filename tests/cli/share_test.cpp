// Tolerances as shares of the range of a field's values: --max-error 2%.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/tetra_fixture.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// The tolerance that a run reports.
double max_error_of(Words words) {
  words.emplace_back("--json");
  const Finished run = run_lode(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.exit_code == 0 ? run.json().at("max_error").get<double>() : -1;
}

class cli_share : public BallFixture {};

/// The ball's values are from 0 to 200.
TEST_F(cli_share, of_a_volume_s_range_is_what_all_its_commands_take) {
  const std::string lode = lode_file();
  const std::string ply = file("s.ply");
  const Words share = {"--isovalue", "100", "--max-error", "2%"};
  const auto with = [&](Words words) {
    words.insert(words.end(), share.begin(), share.end());
    return words;
  };
  for (const Words& words : {Words{"extract", lode, ply},
                             {"extract", volume(), ply},
                             {"extract", lode, ply, "--keep-topology"},
                             {"extract", lode, ply, "--simplify"},
                             {"extract", lode, ply, "--box", "2,9,2,9,2,9"},
                             {"extract", lode, file("m.vtu"), "--mesh"},
                             {"extract", lode, file("s.vtp"), "--section", "0,0,7:0,0,1"},
                             {"count", lode},
                             {"render", lode, file("p.png"), "--size", "40x30"}})
    EXPECT_DOUBLE_EQ(max_error_of(with(words)), 4) << words[0] << " " << words.back();
  EXPECT_DOUBLE_EQ(max_error_of({"extract", lode, ply, "--isovalue", "9", "--max-error", "0.25%"}),
                   0.5);
}

TEST_F(cli_share, makes_the_surface_of_its_number) {
  ASSERT_EQ(extract("share.ply", {"--isovalue", "100", "--max-error", "2%"}).exit_code, 0);
  ASSERT_EQ(extract("number.ply", {"--isovalue", "100", "--max-error", "4"}).exit_code, 0);
  EXPECT_EQ(read_bytes(file("share.ply")), read_bytes(file("number.ply")));
  const auto verify = [&](const char* share) {
    return run_lode({"verify", lode_file(), "--surface", file("share.ply"), "--isovalue", "100",
                     "--max-error", share});
  };
  EXPECT_EQ(verify("2%").exit_code, 0);
  EXPECT_NE(verify("1%").exit_code, 0) << "another surface";
}

TEST_F(cli_share, of_persistence_and_outside_a_focus_is_the_same) {
  const auto bytes_of = [&](const char* name, Words options) {
    options.insert(options.end(), {"--isovalue", "100"});
    EXPECT_EQ(extract(name, options).exit_code, 0);
    return read_bytes(file(name));
  };
  EXPECT_EQ(bytes_of("share.ply", {"--max-error", "20", "--keep-topology=5%"}),
            bytes_of("number.ply", {"--max-error", "20", "--keep-topology=10"}));
  const Words focus{"--max-error", "1", "--box", "2,5,2,5,2,5", "--max-error-outside"};
  const auto outside = [&](const char* tolerance) {
    Words words = focus;
    words.emplace_back(tolerance);
    return words;
  };
  EXPECT_EQ(bytes_of("s.ply", outside("10%")), bytes_of("n.ply", outside("20")));
  EXPECT_NE(bytes_of("s.ply", outside("10%")), bytes_of("n.ply", outside("2")));
  EXPECT_EQ(run_lode({"verify", lode_file(), "--surface", file("share.ply"), "--isovalue", "100",
                      "--max-error", "20", "--keep-topology=5%"})
                .exit_code,
            0);
  const std::string mesh = file("m.vtu");
  const auto mesh_of = [&](const char* tolerance) {
    Words words{"extract", lode_file(), mesh, "--mesh"};
    const Words more = outside(tolerance);
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(run_lode(words).exit_code, 0);
    return read_bytes(mesh);
  };
  EXPECT_EQ(mesh_of("10%"), mesh_of("20"));
  expect_refusal(extract("s.ply", {"--isovalue", "100", "--keep-topology=-5%"}), 2,
                 {"--keep-topology", "'-5%'"});
}

TEST_F(cli_share, is_a_number_with_one_sign) {
  for (const char* text : {"%", "-1%", "1%%", "1 %", "nan%", "one%", "1e999%"})
    expect_refusal(extract("s.ply", {"--isovalue", "100", "--max-error", text}), 2,
                   {"--max-error"});
}

/// Of heights from 604 to 1197, in all models, built or not.
class TerrainShare : public ::testing::Test {
 protected:
  void SetUp() override {
    write_dem(dem_);
    const auto info = run_lode({"info", dem_, "--json"}).json();
    height_ = info.at("range").at(1).get<double>() - info.at("range").at(0).get<double>();
    ASSERT_GT(height_, 500);
  }
  [[nodiscard]] std::string file(const std::string& name) const { return scratch_ / name; }

  Scratch scratch_;
  std::string dem_ = scratch_ / "dem.asc";
  double height_ = 0;
};
using terrain_share = TerrainShare;

TEST_F(terrain_share, of_the_range_of_heights_is_what_all_its_commands_take) {
  write_bytes(file("points.xyz"), "0 0 1\n9 0 2\n9 7 3\n0 7 4\n4 4 11\n");
  EXPECT_DOUBLE_EQ(
      max_error_of({"extract", file("points.xyz"), file("p.ply"), "--max-error", "10%"}), 1);
  ASSERT_EQ(run_lode({"build", dem_, file("dem.lode"), "--levels", "2%"}).exit_code, 0);
  const std::string lode = file("dem.lode");
  for (const std::string& input : {dem_, lode})
    for (const Words& words :
         {Words{"extract", input, file("t.ply")},
          {"extract", input, file("t.tif")},
          {"contours", input, file("c.vtp"), "--interval", "100"},
          {"height", input, "--at", "500100,4000100"},
          {"profile", input, "--from", "500100,4000100", "--to", "500500,4000500"},
          {"render", input, file("p.png"), "--size", "40x30"}}) {
      Words all = words;
      all.insert(all.end(), {"--max-error", "2%"});
      EXPECT_DOUBLE_EQ(max_error_of(all), 0.02 * height_) << words[0] << " " << input;
    }
}

TEST_F(terrain_share, builds_any_model_for_what_is_asked_of_it) {
  const std::string number = fmt::format("{}", 2.0 / 100 * height_);
  for (const std::string& model :
       oracles::trials(Words{"delaunay_selector", "delaunay_pyramid", "ternary_triangulation",
                             "implicit_delaunay_pyramid", "surface_quadtree", "restricted_quadtree",
                             "quaternary_triangulation", "right_triangle_bisection",
                             "adaptive_triangulation", "hierarchical_delaunay"},
                       // Of each kind of file one.
                       Words{"delaunay_selector", "ternary_triangulation", "surface_quadtree",
                             "right_triangle_bisection", "hierarchical_delaunay"})) {
    for (const char* name : {"share.ply", "number.ply"}) {
      const Finished run = run_lode({"extract", dem_, file(name), "--model", model, "--max-error",
                                     name[0] == 's' ? "2%" : number});
      ASSERT_EQ(run.exit_code, 0) << model << " " << run.err;
    }
    EXPECT_EQ(read_bytes(file("share.ply")), read_bytes(file("number.ply"))) << model;
  }
  const auto verify = [&](const char* share) {
    return run_lode({"verify", dem_, "--surface", file("s.ply"), "--max-error", share}).exit_code;
  };
  ASSERT_EQ(run_lode({"extract", dem_, file("s.ply"), "--max-error", "2%"}).exit_code, 0);
  EXPECT_EQ(verify("2%"), 0);
  EXPECT_EQ(verify("0.5%"), 1);
}

TEST_F(terrain_share, of_lists_and_foci_is_the_same) {
  const auto built =
      run_lode({"build", dem_, file("dem.lode"), "--levels", "1%,10%,5%", "--json"}).json();
  std::vector<double> levels;
  for (const auto& level : built.at("levels")) levels.push_back(level.at("tolerance"));
  EXPECT_EQ(levels, (std::vector{0.1 * height_, 0.05 * height_, 0.01 * height_}));
  const Words box{"extract",
                  file("dem.lode"),
                  file("b.ply"),
                  "--box",
                  "500300,500400,4000300,4000400",
                  "--max-error",
                  "1%"};
  const auto count = [&](const std::string& outside) {
    Words words = box;
    words.insert(words.end(), {"--max-error-outside", outside, "--json"});
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json().at("triangles").get<std::uint64_t>();
  };
  EXPECT_LT(count("10%"), count("2%"));
  Words mixed = box;
  mixed.insert(mixed.end(), {"--max-error-outside", "5"});
  expect_refusal(run_lode(mixed), 2, {"--max-error-outside", "%"});
  // Of 0 it does not matter whether it is a share: what the other one is counts.
  Words built_for{"extract",
                  dem_,
                  file("o.obj"),
                  "--model",
                  "hierarchical_delaunay",
                  "--box",
                  "500300,500400,4000300,4000400",
                  "--max-error",
                  "10",
                  "--max-error-outside"};
  for (const char* nothing : {"0", "0%"}) {
    Words words = built_for;
    words.emplace_back(nothing);
    EXPECT_DOUBLE_EQ(max_error_of(words), 10) << nothing;
  }
  const Finished compared = run_lode(
      {"compare", dem_, file("c.html"), "--tolerances", "10%,5%", "--runs", "1", "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_DOUBLE_EQ(
      compared.json().at("models").at(0).at("meshes").at(1).at("tolerance").get<double>(),
      0.05 * height_);
  for (const char* text : {"5%,3", "5%,", "-5%", "5%,5%"})
    expect_refusal(run_lode({"build", dem_, file("no.lode"), "--levels", text}), 2, {"--levels"});
}

/// Of a plain there is no share but 0.
TEST_F(terrain_share, of_no_range_is_nothing) {
  write_bytes(file("flat.asc"),
              "ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n5 5 5\n5 5 5\n5 5 5\n");
  ASSERT_EQ(run_lode({"build", file("flat.asc"), file("flat.lode"), "--levels", "9%,1%"}).exit_code,
            0);
  for (const char* name : {"flat.asc", "flat.lode"})
    EXPECT_EQ(max_error_of({"extract", file(name), file("f.ply"), "--max-error", "1%"}), 0);
}

using cli_tetra_share = cli_tetra;

TEST_F(cli_tetra_share, of_a_mesh_s_range_is_what_all_its_commands_take) {
  Finished info = run_lode({"build", input_, scratch_ / "waves.lode", "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const std::string lode = scratch_ / "waves.lode";
  const SimplexMesh mesh = waves(13);
  const auto [low, high] = std::ranges::minmax(mesh.values);
  const double expected = 0.05 * (high - low);
  for (const Words& words :
       {Words{"extract", lode, output_, "--mesh"},
        {"extract", lode, scratch_ / "b.vtp", "--boundary"},
        {"extract", lode, scratch_ / "s.vtp", "--section", "0,0,6:0,0,1"},
        {"extract", lode, scratch_ / "i.ply", "--isovalue", "5"},
        {"probe", lode, "--point", "3.5,4,5"},
        {"probe", lode, "--integral"},
        {"render", lode, scratch_ / "p.png", "--isovalue", "5", "--size", "40x30"}}) {
    Words all = words;
    all.insert(all.end(), {"--max-error", "5%"});
    EXPECT_NEAR(max_error_of(all), expected, 1e-6 * expected) << words[0] << " " << words.back();
  }
}

}  // namespace
}  // namespace lode::test
