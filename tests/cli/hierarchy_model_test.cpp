// Files of hierarchical triangulations, through the program.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"

namespace lode::test {
namespace {

class cli_hierarchy_model : public testing::TestWithParam<std::string> {
 protected:
  cli_hierarchy_model() {
    write_dem(dem_);
    built_ = run_lode({"build", dem_, model_, "--model", GetParam(), "--levels", "10,50", "--json"})
                 .json();
  }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  const std::string out_ = scratch_ / "out.ply";
  nlohmann::json built_;
};

TEST_P(cli_hierarchy_model, is_built_told_of_and_verified) {
  EXPECT_EQ(built_.at("model"), GetParam());
  ASSERT_EQ(built_.at("levels").size(), 2U);
  EXPECT_EQ(built_.at("levels")[0].at("tolerance"), 50);
  EXPECT_EQ(built_.at("first_triangles"), built_.at("levels")[0].at("triangles"));
  EXPECT_EQ(built_.at("vertices"), built_.at("levels")[1].at("vertices"));
  EXPECT_EQ(built_.at("finest_error"), 10);
  EXPECT_FALSE(built_.contains("insertions"));
  const auto info = run_lode({"info", model_, "--json"}).json();
  for (const char* key : {"columns", "rows", "levels", "vertices", "triangles_ever", "range",
                          "missing_samples", "to_world"})
    EXPECT_EQ(info.at(key), built_.at(key)) << key;
  const Finished alone = run_lode({"verify", model_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  const Finished against = run_lode({"verify", model_, "--against", dem_});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  EXPECT_NE(against.out.find("within 10: samples are within the error"), std::string::npos);
  const std::string other = scratch_ / "other.asc";
  write_dem(other, 40, 31);
  EXPECT_NE(run_lode({"verify", model_, "--against", other}).exit_code, 0);
}

TEST(cli_adaptive_model, warns_of_levels_with_more_triangles_than_all_samples_have) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  std::ofstream file(dem);
  file << "ncols 40\nnrows 30\nxllcorner 0\nyllcorner 0\ncellsize 30\n";
  for (int i = 0; i < 40 * 30; ++i) file << (i * 7919) % 401 << ' ';
  file.close();
  const std::string model = scratch / "dem.lode";
  const auto built = run_lode({"build", dem, model, "--model", "adaptive_triangulation", "--levels",
                               "400,1", "--json"})
                         .json();
  const int full = 2 * 39 * 29;
  EXPECT_LT(built.at("levels")[0].at("triangles"), full);
  ASSERT_GT(built.at("levels")[1].at("triangles"), full);
  ASSERT_EQ(built.at("warnings").size(), 1U);
  EXPECT_NE(built.at("warnings")[0].get<std::string>().find("more than the 2,262 of all samples"),
            std::string::npos)
      << built.at("warnings");
  const auto warnings = [&](const char* max_error) {
    return run_lode({"extract", model, scratch / "out.ply", "--max-error", max_error, "--json"})
        .json()
        .at("warnings");
  };
  EXPECT_EQ(warnings("400").size(), 0U);
  ASSERT_EQ(warnings("1").size(), 1U);
  EXPECT_NE(warnings("1")[0].get<std::string>().find("of all samples"), std::string::npos);
}

TEST_P(cli_hierarchy_model, is_read_from_the_format_document_alone) {
  const auto& levels = built_.at("levels");
  EXPECT_EQ(run_oracle(LODE_HIERARCHY_READER, "'" + model_ + "' '" + dem_ + "'"),
            "vertices " + built_.at("vertices").dump() + " triangles " +
                built_.at("triangles_ever").dump() + " levels [" +
                levels[0].at("triangles").dump() + ", " + levels[1].at("triangles").dump() + "]\n");
}

TEST_P(cli_hierarchy_model, keeps_features_as_edges) {
  const auto lined = run_lode({"build", dem_, model_, "--model", GetParam(), "--levels", "10,50",
                               "--feature-relief", "20", "--json"})
                         .json();
  EXPECT_EQ(built_.at("fixed_edges"), 0);
  EXPECT_GT(lined.at("fixed_edges"), 10);
  EXPECT_EQ(lined.at("lines").at("features").at("relief"), 20);
  EXPECT_EQ(run_lode({"info", model_, "--json"}).json().at("fixed_edges"), lined.at("fixed_edges"));
  const Finished against =
      run_lode({"verify", model_, "--against", dem_, "--feature-relief", "20"});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  EXPECT_NE(against.out.find("lines are edges of all levels"), std::string::npos) << against.out;
  EXPECT_NE(against.out.find("lines are those of the features"), std::string::npos) << against.out;
  const Finished other =
      run_lode({"verify", model_, "--against", dem_, "--feature-relief", "1000"});
  EXPECT_NE(other.exit_code, 0) << other.out;
  EXPECT_EQ(run_oracle(LODE_HIERARCHY_READER, "'" + model_ + "' '" + dem_ + "'").find("vertices"),
            0U);
  const auto from_raster = run_lode({"extract", dem_, out_, "--model", GetParam(), "--max-error",
                                     "50", "--keep-features", "--json"});
  EXPECT_GT(from_raster.json().at("lines").at("features").at("kept").at("peaks"), 0);
}

TEST_P(cli_hierarchy_model, gives_the_mesh_of_a_level) {
  const auto extract = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words{"extract", model_, out_, "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  };
  const auto& levels = built_.at("levels");
  const auto fine = extract({"--max-error", "10"}).json();
  EXPECT_EQ(fine.at("triangles"), levels[1].at("triangles"));
  EXPECT_LE(fine.at("achieved_error"), 10 + 1e-9);
  EXPECT_EQ(fine.at("error_met"), true);
  EXPECT_FALSE(fine.contains("insertion"));
  const std::string n = levels[0].at("triangles").dump();
  EXPECT_EQ(extract({"--max-cells", n}).json().at("triangles"), levels[0].at("triangles"));
  const Finished few = extract({"--max-cells", "1"});
  EXPECT_EQ(few.json().at("budget_met"), false);
  EXPECT_NE(few.err.find("the coarsest level has " + n), std::string::npos) << few.err;
  const auto again =
      run_lode({"extract", dem_, out_, "--max-error", "50", "--model", GetParam(), "--json"});
  EXPECT_EQ(again.json().at("triangles"), levels[0].at("triangles"));
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--max-cells", "100"},
                                               {"--max-cells", "100", "--max-error", "1"}}) {
    std::vector<std::string> words{"extract", dem_, out_, "--model", GetParam(), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const auto chosen = run_lode(words).json();
    EXPECT_EQ(chosen.at("budget_met"), true);
    EXPECT_GT(chosen.at("triangles"), 2);
  }
  expect_refusal(
      run_lode({"verify", dem_, "--surface", out_, "--max-error", "50", "--model", GetParam()}), 2,
      {"vertices are samples", GetParam()});
}

TEST_P(cli_hierarchy_model, answers_what_rasters_answer) {
  write_bytes(scratch_ / "places.csv", "x,y\n500315,4000315\n500615,4000615\n");
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"height", model_, scratch_ / "places.csv", "--out",
                                 scratch_ / "out.csv"},
        {"profile", model_, "--from", "500100,4000100", "--to", "501000,4000700"},
        {"contours", model_, scratch_ / "out.vtp", "--interval", "50"},
        {"contours", model_, scratch_ / "out.gpkg", "--interval", "50", "--polygons"},
        {"sight", model_, "--from", "500100,4000100", "--to", "501000,4000700", "--height-unit",
         "m"},
        {"render", model_, scratch_ / "out.png", "--size", "64x48", "--contours", "100"},
        {"extract", model_, scratch_ / "out.tif", "--cell", "30"}}) {
    SCOPED_TRACE(question[0]);
    std::vector<std::string> words = question;
    words.insert(words.end(), {"--max-error", "10", "--json"});
    const Finished answer = run_lode(words);
    ASSERT_EQ(answer.exit_code, 0) << answer.err;
    EXPECT_EQ(answer.json().at("triangles"), built_.at("levels")[1].at("triangles"));
  }
}

TEST_P(cli_hierarchy_model, refuses_what_it_cannot_by_its_nature) {
  expect_refusal(run_lode({"extract", model_, out_, "--max-error", "9"}), 1,
                 {"dem.lode", "10 or more", "got 9"});
  expect_refusal(run_lode({"extract", model_, scratch_ / "out.tif", "--max-error", "10"}), 1,
                 {"expected a cell", GetParam(), "between samples"});
}

/// Of the raster what is between levels is measured, of the file bounded.
TEST_P(cli_hierarchy_model, varies_of_the_raster_and_of_the_file) {
  for (const auto& [input, tolerance] : {std::pair(dem_, "2"), {model_, "10"}}) {
    SCOPED_TRACE(input);
    const auto run = [&](std::vector<std::string> words) {
      if (input == dem_) words.insert(words.end(), {"--model", GetParam()});
      words.emplace_back("--json");
      return run_lode(words).json();
    };
    const auto extract = [&](const std::vector<std::string>& more) {
      std::vector<std::string> words{"extract", input, out_, "--max-error", tolerance};
      words.insert(words.end(), more.begin(), more.end());
      return run(words);
    };
    const int everywhere = extract({}).at("triangles");
    const std::vector<std::string> place{"--box", "500300,500500,4000200,4000500"};
    const auto box = extract(place);
    // The file has two levels alone.
    EXPECT_LT(box.at("triangles"), input == dem_ ? everywhere / 2 : everywhere);
    EXPECT_EQ(box.at("focus").at("boxes").size(), 1U);
    std::vector<std::string> bounded = place;
    bounded.insert(bounded.end(), {"--max-error-outside", "60"});
    const auto outside = extract(bounded);
    EXPECT_GE(outside.at("triangles"), box.at("triangles"));
    EXPECT_LE(outside.at("achieved_error").get<double>(), 60);
    EXPECT_LT(extract({"--focus-point", "500400,4000300", "--growth", "0.2"}).at("triangles"),
              everywhere);
    const auto drawn =
        run({"render", input, scratch_ / "out.png", "--max-error-px", "20", "--size", "160x120"});
    EXPECT_LE(drawn.at("achieved_px").get<double>(), 20);
  }
}

/// 700 scattered points of hills, with a hole that --max-edge leaves, and two of them at one place.
void write_points(const std::string& path) {
  std::ofstream file(path);
  std::uint32_t random = 5;
  const auto below = [&](double n) {
    random = random * 1664525 + 1013904223;
    return std::round((random >> 8) / 16777216.0 * n * 100) / 100;
  };
  for (int i = 0; i < 700; ++i) {
    const double x = below(200);
    const double y = below(150);
    const double z = 30 * std::sin(x / 23) * std::cos(y / 19) + 5 * std::sin(x * y / 90);
    if (std::hypot(x - 80, y - 70) < 25) continue;
    file << 1000 + x << ' ' << 2000 + y << ' ' << std::round(z * 1000) / 1000 << '\n';
  }
  file << "1150 2100 5\n1150 2100 7\n";
}

TEST_P(cli_hierarchy_model, is_built_of_scattered_points_and_asked) {
  const std::string points = scratch_ / "hills.xyz";
  write_points(points);
  const std::vector<std::string> domain{"--max-edge", "30", "--duplicates", "min"};
  const auto with = [](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  const auto built = run_lode(with({"build", points, model_, "--model", GetParam(), "--levels",
                                    "20,5,1", "--json"},
                                   domain))
                         .json();
  ASSERT_EQ(built.at("levels").size(), 3U);
  const auto info = run_lode({"info", model_, "--json"}).json();
  EXPECT_EQ(info.at("levels"), built.at("levels"));
  EXPECT_EQ(run_lode({"verify", model_}).exit_code, 0);
  const Finished against = run_lode(with({"verify", model_, "--against", points}, domain));
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  EXPECT_NE(against.out.find("within 1: samples are within the error"), std::string::npos);
  EXPECT_NE(against.out.find("vertices are on the triangulation of all points"), std::string::npos);
  const auto& levels = built.at("levels");
  EXPECT_EQ(run_oracle(LODE_HIERARCHY_READER, "'" + model_ + "' '" + points + "'"),
            "vertices " + built.at("vertices").dump() + " triangles " +
                built.at("triangles_ever").dump() + " levels [" + levels[0].at("triangles").dump() +
                ", " + levels[1].at("triangles").dump() + ", " + levels[2].at("triangles").dump() +
                "]\n");
  // Of another domain, and of another height at one place.
  EXPECT_NE(run_lode({"verify", model_, "--against", points, "--duplicates", "min"}).exit_code, 0);
  EXPECT_NE(
      run_lode({"verify", model_, "--against", points, "--duplicates", "max", "--max-edge", "30"})
          .exit_code,
      0);
  write_bytes(scratch_ / "places.csv", "x,y\n1031.5,2040\n1150,2100\n1080,2070\n");
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"height", model_, scratch_ / "places.csv", "--out",
                                 scratch_ / "out.csv"},
        {"profile", model_, "--from", "1010,2010", "--to", "1190,2120"},
        {"contours", model_, scratch_ / "out.gpkg", "--interval", "5"},
        {"render", model_, scratch_ / "out.png", "--size", "64x48"},
        {"extract", model_, scratch_ / "out.tif", "--cell", "3"},
        {"extract", model_, out_}}) {
    SCOPED_TRACE(question[0]);
    const Finished answer = run_lode(with(question, {"--max-error", "5", "--json"}));
    ASSERT_EQ(answer.exit_code, 0) << answer.err;
    EXPECT_EQ(answer.json().at("triangles"), built.at("levels")[1].at("triangles"));
  }
  const int everywhere = built.at("levels")[2].at("triangles");
  for (const std::vector<std::string>& input :
       {std::vector<std::string>{"extract", model_}, {"extract", points, "--model", GetParam()}}) {
    const Finished varied = run_lode(
        with(with(input, {out_, "--max-error", "1", "--box", "1100,1150,2020,2060", "--json"}),
             input.size() > 2 ? domain : std::vector<std::string>{}));
    ASSERT_EQ(varied.exit_code, 0) << varied.err;
    EXPECT_LT(varied.json().at("triangles"), everywhere);
  }
}

TEST_P(cli_hierarchy_model, keeps_breaklines_as_edges) {
  const std::string points = scratch_ / "hills.xyz";
  write_points(points);
  const std::string lines = scratch_ / "lines.geojson";
  // Across the hills with heights of its own, and one that is draped.
  const auto write_lines = [&](double x, double y) {
    std::ofstream(lines)
        << R"({"type":"FeatureCollection","crs":{"type":"name","properties":{"name":"EPSG:32611"}},)"
        << R"("features":[{"type":"Feature","properties":{},"geometry":{"type":"LineString",)"
        << R"("coordinates":[[)" << x + 20.5 << ',' << y + 30 << R"(,40],[)" << x + 160 << ','
        << y + 120.25 << R"(,50]]}},{"type":"Feature","properties":{},"geometry":{"type":)"
        << R"("LineString","coordinates":[[)" << x + 30 << ',' << y + 120 << "],[" << x + 170 << ','
        << y + 15 << "]]}}]}";
  };
  const auto expect_kept = [&](const std::string& input, const std::vector<std::string>& reading) {
    SCOPED_TRACE(input);
    const auto with_lines = [&](std::vector<std::string> words) {
      words.insert(words.end(), reading.begin(), reading.end());
      words.insert(words.end(), {"--breaklines", lines});
      return words;
    };
    const Finished built = run_lode(with_lines(
        {"build", input, model_, "--model", GetParam(), "--levels", "30,8,2", "--json"}));
    ASSERT_EQ(built.exit_code, 0) << built.err;
    EXPECT_GT(built.json().at("fixed_edges"), 3);
    EXPECT_EQ(run_lode({"verify", model_}).exit_code, 0);
    const Finished against = run_lode(with_lines({"verify", model_, "--against", input}));
    EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
    EXPECT_NE(against.out.find("lines are edges of all levels"), std::string::npos);
    const Finished without = run_lode({"verify", model_, "--against", input});
    EXPECT_NE(without.exit_code, 0) << without.out;
    const Finished extracted = run_lode({"extract", model_, out_, "--max-error", "8", "--json"});
    EXPECT_EQ(extracted.json().at("triangles"), built.json().at("levels")[1].at("triangles"));
  };
  write_lines(1000, 2000);
  expect_kept(points, {"--crs", "EPSG:32611"});
  write_dem_crs(scratch_ / "dem.prj");
  write_lines(500300, 4000300);
  expect_kept(dem_, {});
}

INSTANTIATE_TEST_SUITE_P(models, cli_hierarchy_model,
                         testing::Values("adaptive_triangulation", "hierarchical_delaunay"),
                         [](const auto& model) { return model.param; });

}  // namespace
}  // namespace lode::test
