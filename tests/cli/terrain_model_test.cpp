#include <gtest/gtest.h>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// A raster, and a .lode file of it, of the model that the parameter names.
class cli_terrain_model : public testing::TestWithParam<std::string> {
 protected:
  cli_terrain_model() {
    write_dem(dem_);
    std::vector<std::string> words{"build", dem_, model_, "--model", GetParam(), "--json"};
    if (!is_implicit()) words.insert(words.end(), {"--levels", "2,50,10"});
    built_ = run_lode(words).json();
  }
  [[nodiscard]] static bool is_implicit() { return GetParam() == "implicit_delaunay_pyramid"; }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  nlohmann::json built_;
};

TEST_P(cli_terrain_model, is_built_told_of_and_verified) {
  EXPECT_EQ(built_.at("model"), GetParam());
  const auto info = run_lode({"info", model_, "--json"}).json();
  for (const char* key : {"columns", "rows", "type", "missing_samples", "to_world", "has_position",
                          "levels", "range", "insertions", "finest_error"})
    EXPECT_EQ(info.at(key), built_.at(key)) << key;
  EXPECT_EQ(info.at("missing_samples"), 1);
  EXPECT_EQ(info.at("format"), "LODE");
  if (is_implicit()) {
    EXPECT_GT(info.at("levels").size(), 5U);
    EXPECT_EQ(info.at("finest_error"), 0);
  } else {
    ASSERT_EQ(info.at("levels").size(), 3U);
    EXPECT_EQ(info.at("levels")[0].at("tolerance"), 50);
  }
  EXPECT_LT(info.at("levels").front().at("triangles"), info.at("levels").back().at("triangles"));
  EXPECT_EQ(run_lode({"verify", model_}).exit_code, 0);
  const Finished check = run_lode({"verify", model_, "--against", dem_});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  EXPECT_NE(check.out.find("triangles of all times state their errors"), std::string::npos);
  EXPECT_NE(check.out.find("vertices have the samples' heights"), std::string::npos);
}

TEST_P(cli_terrain_model, is_read_from_the_format_document_alone) {
  std::string levels;
  for (const auto& level : built_.at("levels"))
    levels += (levels.empty() ? "" : ", ") + std::to_string(level.at("triangles").get<int>());
  const std::string vertices = std::to_string(built_.at("levels").back().at("vertices").get<int>());
  const std::string triangles = std::to_string(built_.at("triangles_ever").get<int>());
  EXPECT_EQ(run_oracle(LODE_INSERTIONS_READER, "'" + model_ + "' '" + dem_ + "'"),
            "vertices " + vertices + " triangles " + triangles + " levels [" + levels + "]\n");
}

TEST_P(cli_terrain_model, is_found_out_where_the_raster_is_another) {
  const std::string other = scratch_ / "other.asc";
  write_dem(other, 40, 31);
  const Finished larger = run_lode({"verify", model_, "--against", other});
  EXPECT_NE(larger.exit_code, 0);
  EXPECT_NE(larger.err.find("40 x 30"), std::string::npos) << larger.err;
  std::string text = read_bytes(dem_);
  const std::size_t last = text.find_last_of("0123456789");
  text[last] = text[last] == '9' ? '8' : '9';
  text[last - 2] = text[last - 2] == '1' ? '2' : '1';
  write_bytes(other, text);
  const Finished changed = run_lode({"verify", model_, "--against", other});
  EXPECT_EQ(changed.exit_code, 1) << changed.out;
}

TEST_P(cli_terrain_model, gives_true_surfaces) {
  // The levels, and between two of them.
  for (const std::string& tolerance :
       oracles::trials(Words{"50", "10", "2", "7"}, Words{"2", "7"})) {
    const std::string surface = scratch_ / "of.ply";
    const auto made =
        run_lode({"extract", model_, surface, "--max-error", tolerance, "--json"}).json();
    EXPECT_EQ(made.at("model"), GetParam());
    EXPECT_EQ(made.at("is_uniform"), true);
    const auto expect_true = [&](const std::string& file) {
      const Finished check = run_lode(
          {"verify", dem_, "--surface", file, "--max-error", tolerance, "--model", GetParam()});
      EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
      EXPECT_EQ(check.out.find("Delaunay") != std::string::npos,
                GetParam() != "ternary_triangulation");
    };
    expect_true(surface);
    // The same of the raster, with a model made for this.
    const std::string again = scratch_ / "again.ply";
    ASSERT_EQ(run_lode({"extract", dem_, again, "--max-error", tolerance, "--model", GetParam()})
                  .exit_code,
              0);
    expect_true(again);
  }
}

TEST_P(cli_terrain_model, answers_what_rasters_answer) {
  write_bytes(scratch_ / "places.csv", "x,y\n500300,4000300\n500615,4000615\n");
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"height", "DEM", scratch_ / "places.csv", "--out",
                                 scratch_ / "out.csv"},
        {"profile", "DEM", "--from", "500100,4000100", "--to", "501000,4000700"},
        {"contours", "DEM", scratch_ / "out.vtp", "--interval", "50"},
        {"sight", "DEM", "--from", "500100,4000100", "--to", "501000,4000700", "--height-unit",
         "metre"},
        {"render", "DEM", scratch_ / "out.png", "--size", "64x48"}}) {
    SCOPED_TRACE(question[0]);
    const auto answer = [&](const std::string& input, const std::vector<std::string>& more) {
      std::vector<std::string> words = question;
      words[1] = input;
      words.insert(words.end(), {"--max-error", "10", "--json"});
      words.insert(words.end(), more.begin(), more.end());
      const Finished run = run_lode(words);
      EXPECT_EQ(run.exit_code, 0) << run.err;
      return run.json();
    };
    const auto of_model = answer(model_, {});
    const auto of_raster = answer(dem_, {"--model", GetParam()});
    EXPECT_EQ(of_model.at("model"), GetParam());
    EXPECT_EQ(of_model.at("columns"), of_raster.at("columns"));
    EXPECT_EQ(of_model.at("triangles"), of_raster.at("triangles"));
    if (GetParam() == "delaunay_pyramid")
      EXPECT_EQ(of_model.at("triangles"), answer(dem_, {"--insertion", "strict"}).at("triangles"));
  }
}

TEST_P(cli_terrain_model, varies_its_tolerance) {
  const auto count = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"extract", model_, scratch_ / "of.vtp", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json().at("triangles").get<int>();
  };
  const int fine = count({"--max-error", "2"});
  const int coarse = count({"--max-error", "50"});
  const int box = count(
      {"--max-error", "2", "--box", "500300,500500,4000300,4000500", "--max-error-outside", "50"});
  const int small = count(
      {"--max-error", "2", "--box", "500300,500310,4000300,4000310", "--max-error-outside", "50"});
  EXPECT_LT(coarse, small);
  EXPECT_LT(small, box);
  EXPECT_LT(box, fine);
  const int near =
      count({"--max-error", "2", "--focus-point", "500600,4000400", "--growth", "0.1"});
  const int nearer =
      count({"--max-error", "2", "--focus-point", "500600,4000400", "--growth", "1"});
  EXPECT_LT(nearer, near);
  EXPECT_LT(near, fine);
  const auto focus =
      run_lode({"extract", model_, scratch_ / "of.vtp", "--max-error", "2", "--json",
                "--focus-point", "500600,4000400", "--growth", "0.1", "--max-error-outside", "50"})
          .json()
          .at("focus");
  EXPECT_EQ(focus.at("point"), nlohmann::json({500600, 4000400}));
  EXPECT_EQ(focus.at("growth"), 0.1);
  EXPECT_EQ(focus.at("max_error_outside"), 50);
  EXPECT_TRUE(focus.at("boxes").empty());
  EXPECT_LE(count({"--max-cells", "300"}), 300);
  const Finished far =
      run_lode({"extract", model_, scratch_ / "far.ply", "--max-error", "2", "--box", "0,1,0,1"});
  EXPECT_NE(far.err.find("focus meets no triangle"), std::string::npos) << far.err;
  const auto all =
      run_lode({"extract", model_, scratch_ / "all.ply", "--max-cells", "1000000", "--json"});
  EXPECT_EQ(all.json().at("error_met"), is_implicit()) << "others have no error of 0";
  EXPECT_EQ(run_lode({"render", model_, scratch_ / "small.png", "--size", "400x300"}).exit_code, 0);
}

TEST_P(cli_terrain_model, refuses_what_it_cannot_keep) {
  const std::string out = scratch_ / "out.ply";
  if (is_implicit())
    expect_refusal(run_lode({"build", dem_, model_, "--model", GetParam(), "--levels", "3"}), 2,
                   {"--levels", "finds its own"});
  else
    expect_refusal(run_lode({"extract", model_, out, "--max-error", "1"}), 1,
                   {"dem.lode", "or more", "got 1"});
  expect_refusal(run_lode({"extract", model_, out, "--model", "delaunay_pyramid"}), 2, {"--model"});
  expect_refusal(run_lode({"extract", model_, out, "--insertion", "strict"}), 2, {"--insertion"});
  expect_refusal(run_lode({"extract", model_, out, "--box", "1,2,3,4,5,6"}), 2, {"X0,X1,Y0,Y1"});
  expect_refusal(run_lode({"extract", model_, out, "--growth", "1"}), 2, {"--focus-point"});
  expect_refusal(run_lode({"extract", model_, out, "--focus-point", "1,2"}), 2, {"--growth"});
  expect_refusal(run_lode({"extract", model_, out, "--max-error-outside", "1"}), 2, {"--box"});
  expect_refusal(run_lode({"extract", dem_, out, "--box", "500300,500500,4000300,4000500"}), 2,
                 {"delaunay_pyramid"});
  expect_refusal(run_lode({"build", dem_, out}), 2, {".lode"});
  expect_refusal(run_lode({"build", dem_, model_, "--levels", "3,3"}), 2, {"--levels", "twice"});
  expect_refusal(run_lode({"build", dem_, model_, "--levels", "-3"}), 2, {"--levels", ">= 0"});
  expect_refusal(run_lode({"build", dem_, model_, "--model", "delaunay_selector"}), 2,
                 {"delaunay_pyramid"});
  expect_refusal(run_lode({"build", dem_, model_, "--model", "quaternary"}), 2,
                 {"delaunay_pyramid", "ternary_triangulation", "got 'quaternary'"});
  expect_refusal(run_lode({"verify", model_, "--surface", out}), 2, {"--surface"});
  expect_refusal(run_lode({"extract", model_, out, "--nodata", "5"}), 2, {"--nodata"});
  if (!is_implicit())
    expect_refusal(run_lode({"extract", model_, out, "--max-error", "10", "--box", "1,2,3,4",
                             "--max-error-outside", "0.1"}),
                   1, {"or more outside"});
  expect_refusal(run_lode({"height", scratch_ / "absent.lode", "--at", "1,2"}), 2,
                 {"absent.lode", "No such file"});
  expect_refusal(run_lode({"extract", scratch_ / "absent.lode", "out.ply", "--max-error", "1"}), 2,
                 {"absent.lode", "No such file"});
  expect_refusal(run_lode({"render", scratch_ / "absent.lode", "out.png"}), 2,
                 {"absent.lode", "No such file"});
  std::string bytes = read_bytes(model_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_bytes(model_, bytes);
  EXPECT_EQ(run_lode({"verify", model_}).exit_code, 1);
  expect_refusal(run_lode({"extract", model_, out, "--max-error", "10"}), 1, {"dem.lode"});
}

INSTANTIATE_TEST_SUITE_P(models, cli_terrain_model,
                         testing::Values("delaunay_pyramid", "ternary_triangulation",
                                         "implicit_delaunay_pyramid"),
                         [](const auto& model) { return model.param; });

}  // namespace
}  // namespace lode::test
