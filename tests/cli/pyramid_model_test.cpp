// Files of Delaunay pyramids that are kept by levels, through the program.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

class cli_pyramid_model : public testing::TestWithParam<std::string> {
 protected:
  cli_pyramid_model() {
    write_dem(dem_);
    built_ =
        run_lode({"build", dem_, model_, "--model", GetParam(), "--levels", "2,50,10", "--json"})
            .json();
  }
  [[nodiscard]] static bool has_links() { return GetParam() != "triangle_lists"; }
  [[nodiscard]] Finished extract(const Words& more, const std::string& out = "out.ply") const {
    Words words{"extract", model_, scratch_ / out};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  }
  [[nodiscard]] nlohmann::json report(Words words) const {
    words.push_back("--json");
    const Finished run = extract(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  nlohmann::json built_;
};

/// Without comments, which name the model.
std::string without_comments(const std::string& path) {
  std::istringstream in(read_bytes(path));
  std::string kept;
  for (std::string line; std::getline(in, line);)
    if (!line.starts_with("#") && !line.starts_with("comment ") && !line.starts_with("<!-- "))
      kept += line + '\n';
  return kept;
}

TEST_P(cli_pyramid_model, is_built_told_of_and_verified) {
  EXPECT_EQ(built_.at("model"), GetParam());
  ASSERT_EQ(built_.at("levels").size(), 3U);
  EXPECT_EQ(built_.at("levels")[0].at("tolerance"), 50);
  EXPECT_EQ(built_.at("first_triangles"), built_.at("levels")[0].at("triangles"));
  EXPECT_EQ(built_.at("vertices"), built_.at("levels")[2].at("vertices"));
  EXPECT_EQ(built_.at("links") > 0, has_links());
  EXPECT_FALSE(built_.contains("insertions"));
  const auto info = run_lode({"info", model_, "--json"}).json();
  for (const char* key : {"columns", "rows", "levels", "vertices", "triangles_kept", "links",
                          "range", "missing_samples", "to_world", "memory_bytes", "finest_error"})
    EXPECT_EQ(info.at(key), built_.at(key)) << key;
  std::uint64_t memory = 0;
  for (const auto& part : info.at("parts")) {
    memory += part.at("memory_bytes").get<std::uint64_t>();
    EXPECT_GT(part.at("file_bytes"), 0) << part;
  }
  EXPECT_EQ(memory, info.at("memory_bytes"));
  const Finished alone = run_lode({"verify", model_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  EXPECT_EQ(alone.out.find("links are to all triangles") != std::string::npos, has_links());
  const Finished against = run_lode({"verify", model_, "--against", dem_});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  EXPECT_NE(against.out.find("within 10: samples are within the error"), std::string::npos);
  const std::string other = scratch_ / "other.asc";
  write_dem(other, 40, 31);
  EXPECT_NE(run_lode({"verify", model_, "--against", other}).exit_code, 0);
}

TEST_P(cli_pyramid_model, gives_the_meshes_of_the_delaunay_pyramid) {
  const std::string history = scratch_ / "history.lode";
  ASSERT_EQ(run_lode({"build", dem_, history, "--levels", "2,10,50"}).exit_code, 0);
  for (const std::string& tolerance : oracles::trials(Words{"50", "10", "2"}, Words{"10"}))
    for (const char* name : {"of.ply", "of.obj"}) {
      ASSERT_EQ(extract({"--max-error", tolerance}, name).exit_code, 0);
      const std::string own = without_comments(scratch_ / name);
      ASSERT_EQ(run_lode({"extract", history, scratch_ / name, "--max-error", tolerance}).exit_code,
                0);
      EXPECT_EQ(own, without_comments(scratch_ / name));
    }
  // Of a raster, the model is built for the question.
  const auto again = run_lode(
      {"extract", dem_, scratch_ / "of.ply", "--max-error", "10", "--model", GetParam(), "--json"});
  EXPECT_EQ(again.json().at("triangles"), built_.at("levels")[1].at("triangles"));
}

/// That makes the triangles round a window alone, this reads the level and leaves the others out.
TEST_P(cli_pyramid_model, has_the_windows_of_the_delaunay_pyramid) {
  const std::string history = scratch_ / "history.lode";
  ASSERT_EQ(run_lode({"build", dem_, history, "--levels", "2,10,50"}).exit_code, 0);
  for (const std::string& tolerance : oracles::trials(Words{"50", "10", "2"}, Words{"10"}))
    for (const char* window : {"500300,500500,4000300,4000500", "500612,500613,4000399,4000400",
                               "499000,500030,3999000,4000040", "500045,500045,4000045,4000045",
                               "499000,503000,3999000,4003000"}) {
      SCOPED_TRACE(tolerance + " in " + window);
      const auto own = report({"--max-error", tolerance, "--clip", window});
      const std::string lines = without_comments(scratch_ / "out.ply");
      const auto other = run_lode({"extract", history, scratch_ / "of.ply", "--max-error",
                                   tolerance, "--clip", window, "--json"})
                             .json();
      EXPECT_EQ(other.at("clip"), own.at("clip"));
      EXPECT_EQ(other.at("vertices"), own.at("vertices"));
      EXPECT_EQ(other.at("achieved_error"), own.at("achieved_error"));
      EXPECT_EQ(without_comments(scratch_ / "of.ply"), lines);
    }
}

TEST_P(cli_pyramid_model, takes_a_level_and_refuses_mixtures) {
  const auto& levels = built_.at("levels");
  EXPECT_EQ(report({"--max-error", "20"}).at("triangles"), levels[1].at("triangles"));
  const std::string box = "500300,500500,4000300,4000500";
  EXPECT_EQ(report({"--max-error", "10", "--box", box}).at("triangles"), levels[1].at("triangles"));
  EXPECT_LT(report({"--max-error", "10", "--clip", box}).at("clip").at("triangles"),
            levels[1].at("triangles"));
  const Words why{GetParam(), "delaunay_pyramid", "do not meet"};
  expect_refusal(extract({"--max-error", "2", "--box", box, "--max-error-outside", "50"}), 1, why);
  expect_refusal(
      extract({"--max-error", "2", "--focus-point", "500600,4000400", "--growth", "0.1"}), 1, why);
  const std::string camera = scratch_ / "camera.json";
  ASSERT_EQ(
      run_lode({"render", model_, scratch_ / "a.png", "--size", "40x30", "--save-camera", camera})
          .exit_code,
      0);
  expect_refusal(extract({"--view", camera, "--max-error-px", "1"}), 1, why);
  expect_refusal(extract({"--max-error", "1"}), 1, {"dem.lode", "or more", "got 1"});
}

TEST_P(cli_pyramid_model, answers_as_the_delaunay_pyramid_does) {
  const std::string history = scratch_ / "history.lode";
  ASSERT_EQ(run_lode({"build", dem_, history, "--levels", "2,10,50"}).exit_code, 0);
  std::ostringstream places;
  places << "x,y\n";
  for (int i = 0; i < 60; ++i)
    places << 500000 + i * 37 % 1170 << ',' << 4000000 + i * 53 % 870 << '\n';
  write_bytes(scratch_ / "places.csv", places.str());
  for (const Words& question :
       {Words{"height", "DEM", scratch_ / "places.csv", "--out", scratch_ / "out.csv"},
        {"profile", "DEM", "--from", "500100,4000100", "--to", "501000,4000700", "--out",
         scratch_ / "out.csv"},
        {"contours", "DEM", scratch_ / "out.csv.vtp", "--interval", "50"},
        {"contours", "DEM", scratch_ / "out.csv.vtp", "--isovalue", "250"},
        {"contours", "DEM", scratch_ / "out.csv.vtp", "--isovalue", "1e6"},
        {"sight", "DEM", "--from", "500100,4000100", "--to", "501000,4000700", "--height-unit",
         "metre"},
        {"render", "DEM", scratch_ / "out.csv.png", "--size", "64x48"}})
    for (const std::string& tolerance : oracles::trials(Words{"50", "10", "2"}, Words{"10"})) {
      SCOPED_TRACE(question[0] + " within " + tolerance);
      const auto answer = [&](const std::string& input) {
        Words words = question;
        words[1] = input;
        words.insert(words.end(), {"--max-error", tolerance, "--json"});
        const Finished run = run_lode(words);
        EXPECT_EQ(run.exit_code, 0) << run.err;
        auto json = run.json();
        for (const char* key : {"input", "file", "model", "seconds"}) json.erase(key);
        std::string written;
        for (const char* name : {"out.csv", "out.csv.vtp", "out.csv.png"})
          if (std::filesystem::exists(scratch_ / name)) {
            written += without_comments(scratch_ / name);
            std::filesystem::remove(scratch_ / name);
          }
        return std::pair(json, written);
      };
      const auto of_levels = answer(model_);
      const auto of_history = answer(history);
      EXPECT_EQ(of_levels.second, of_history.second);
      for (const char* key : {"triangles", "verdict", "points", "lines", "inside"})
        if (of_history.first.contains(key))
          EXPECT_EQ(of_levels.first.at(key), of_history.first.at(key)) << key;
    }
}

TEST_P(cli_pyramid_model, limits_links_to_a_memory) {
  const Finished run = run_lode({"build", dem_, scratch_ / "other.lode", "--model", GetParam(),
                                 "--memory-limit", "1000", "--levels", "50,2"});
  if (has_links())
    expect_refusal(run, 1, {"dem.asc", "interference links", "1000 bytes"});
  else
    expect_refusal(run, 2, {"--memory-limit", "complete_pyramid", "got triangle_lists"});
  EXPECT_FALSE(std::filesystem::exists(scratch_ / "other.lode"));
}

TEST_P(cli_pyramid_model, is_read_from_the_format_document_alone) {
  std::string levels;
  for (const auto& level : built_.at("levels"))
    levels += (levels.empty() ? "" : ", ") + level.at("triangles").dump();
  EXPECT_EQ(run_oracle(LODE_PYRAMID_READER, "'" + model_ + "' '" + dem_ + "'"),
            "vertices " + built_.at("vertices").dump() + " kept " +
                built_.at("triangles_kept").dump() + " links " + built_.at("links").dump() +
                " levels [" + levels + "]\n");
}

INSTANTIATE_TEST_SUITE_P(models, cli_pyramid_model,
                         testing::Values("complete_pyramid", "triangle_lists",
                                         "linked_triangle_lists"),
                         [](const auto& model) { return model.param; });

}  // namespace
}  // namespace lode::test
