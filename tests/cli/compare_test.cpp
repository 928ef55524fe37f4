// Comparisons of models of terrain, through the program.
#include <gtest/gtest.h>

#include <cmath>

#include "lode/api/terrain_model.h"
#include "tests/cli/ball_fixture.h"
#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

TEST(cli_compare, writes_a_page_with_all_numbers_in_it) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const std::string page = scratch / "report.html";
  const auto made =
      run_lode({"compare", dem, page, "--tolerances", "50,10", "--runs", "1", "--json"}).json();
  const auto& models = made.at("models");
  ASSERT_EQ(models.size(), 16U);
  EXPECT_EQ(models[0].at("name"), "delaunay_selector");
  EXPECT_EQ(models[0].at("meshes")[1].at("tolerance"), 10);
  EXPECT_EQ(models[0].at("meshes")[1].at("is_met"), true);
  EXPECT_EQ(models[2].at("name"), "delaunay_pyramid");
  EXPECT_EQ(models[2].at("links"), nullptr);
  EXPECT_EQ(models[0].at("file_bytes"), nullptr);
  EXPECT_EQ(models[0].at("is_made_anew"), true);
  EXPECT_GT(made.at("memory_limit"), 0);
  for (const auto& model : models) {
    if (!model.at("refusal").is_null()) continue;
    EXPECT_TRUE(model.at("build_seconds").is_number()) << model.at("name");
    // All but lists, and squares of several sizes.
    const std::string name = model.at("name");
    const bool has_none = name.ends_with("lists") || name.starts_with("surface_quadtree") ||
                          name == "quaternary_triangulation";
    EXPECT_EQ(model.at("meshes")[1].at("crossed_per_second").is_null(), has_none) << name;
    EXPECT_NE(model.at("neighbours"), "");
  }
  for (const auto& model : models)
    EXPECT_EQ(model.at("file_bytes").is_number(),
              built_model_of(model.at("name").get<std::string>()).has_value());
  const std::string file = scratch / "same.lode";
  ASSERT_EQ(run_lode({"build", dem, file, "--levels", "50,10"}).exit_code, 0);
  // But for what the raster's file says of it.
  EXPECT_NEAR(models[2].at("file_bytes").get<double>(),
              static_cast<double>(read_bytes(file).size()), 200);
  EXPECT_GT(models[5].at("links"), 0);
  EXPECT_EQ(models[6].at("name"), "ternary_triangulation");
  EXPECT_EQ(models[6].at("meshes")[1].at("hanging_vertices"), 0);
  EXPECT_EQ(models[6].at("meshes")[1].at("is_met"), true);
  EXPECT_EQ(models[7].at("name"), "implicit_delaunay_pyramid");
  EXPECT_EQ(models[7].at("meshes")[1].at("is_met"), true);
  EXPECT_EQ(models[8].at("name"), "adaptive_triangulation");
  EXPECT_EQ(models[9].at("name"), "hierarchical_delaunay");
  for (const std::size_t i : {8U, 9U}) {
    EXPECT_GT(models[i].at("meshes")[1].at("variable_triangles"), 0);
    EXPECT_EQ(models[i].at("meshes")[1].at("is_met"), true);
  }
  EXPECT_EQ(models[10].at("name"), "surface_quadtree");
  EXPECT_GT(models[10].at("meshes")[1].at("hanging_vertices"), 0);
  EXPECT_EQ(models[13].at("name"), "restricted_quadtree");
  EXPECT_EQ(models[13].at("meshes")[1].at("hanging_vertices"), 0);
  EXPECT_EQ(models[14].at("name"), "right_triangle_bisection");
  EXPECT_NE(models[15].at("refusal").get<std::string>().find("1 missing"), std::string::npos);
  for (const auto& model : models) {
    if (!model.at("refusal").is_null()) continue;
    EXPECT_TRUE(model.at("peak_build_bytes").is_number()) << model.at("name");
    EXPECT_EQ(model.at("memory_bytes").is_null(), model.at("missing").contains("memory"));
    EXPECT_EQ(model.at("levels").is_null(), model.at("missing").contains("levels"));
    EXPECT_NE(model.at("levels_are"), "");
  }
  EXPECT_NE(models[0].at("missing").at("memory").get<std::string>().find("nothing is kept"),
            std::string::npos);
  const std::string html = read_bytes(page);
  EXPECT_TRUE(html.starts_with("<!doctype html>"));
  EXPECT_EQ(html.find("http"), std::string::npos) << "nothing outside the page";
  for (const char* part :
       {"<svg", "Tolerance 50", "right_triangle_bisection", "not run: ", "M steps/s",
        "from 3/8 to 5/8 of columns and rows, a sixteenth", "making the finest mesh took",
        "memory (nothing is kept", "levels: triangles nested in each other"})
    EXPECT_NE(html.find(part), std::string::npos) << part;
  EXPECT_EQ(html.find("middle quarter"), std::string::npos);
  // A model with a dash in a table has its reasons in the list.
  EXPECT_NE(html.find("<td>–</td>"), std::string::npos);
  std::size_t n_reasons = 0;
  for (std::size_t at = html.find(">–: "); at != std::string::npos; at = html.find(">–: ", at + 1))
    ++n_reasons;
  EXPECT_EQ(n_reasons, 15U) << "no model has all, and one is not run";
  const std::size_t begin = html.find("id=\"comparison\">") + 16;
  const auto kept = nlohmann::json::parse(html.substr(begin, html.find("</script>") - begin));
  EXPECT_EQ(kept.at("models"), models);
}

TEST(cli_compare, takes_scattered_points_and_says_which_models_need_a_raster) {
  const Scratch scratch;
  const std::string points = scratch / "hills.xyz";
  std::string text = "x y z\n";
  for (int i = 0; i < 900; ++i) {
    const double x = i % 30 + 0.3 * std::sin(i);
    const double y = i / 30 + 0.3 * std::cos(7 * i);
    text += std::to_string(x) + ' ' + std::to_string(y) + ' ' +
            std::to_string(20 * std::sin(0.3 * x) * std::cos(0.2 * y)) + '\n';
  }
  write_bytes(points, text);
  const std::string page = scratch / "report.html";
  const auto made =
      run_lode({"compare", points, page, "--tolerances", "5,1", "--runs", "1", "--json"}).json();
  std::size_t n_run = 0;
  for (const auto& model : made.at("models")) {
    const std::string name = model.at("name");
    const bool needs_raster = name.starts_with("surface_quadtree") ||
                              name == "quaternary_triangulation" || name == "restricted_quadtree" ||
                              name == "regular grid" || name == "right_triangle_bisection";
    EXPECT_EQ(!model.at("refusal").is_null(), needs_raster) << name << model.at("refusal");
    if (needs_raster) {
      EXPECT_NE(model.at("refusal").get<std::string>().find("columns and rows"), std::string::npos);
      continue;
    }
    ++n_run;
    ASSERT_EQ(model.at("meshes").size(), 2U) << name;
    for (const auto& mesh : model.at("meshes")) {
      EXPECT_EQ(mesh.at("is_met"), true) << name << mesh;
      EXPECT_EQ(mesh.at("uncovered_samples"), 0) << name;
      EXPECT_EQ(mesh.at("hanging_vertices"), 0) << name;
      EXPECT_GT(mesh.at("true_error"), 0) << name;
      EXPECT_LE(mesh.at("true_error").get<double>(),
                mesh.at("stated_error").get<double>() * (1 + 1e-6))
          << name;
    }
    EXPECT_EQ(model.at("file_bytes").is_number(), built_model_of(name).has_value()) << name;
  }
  EXPECT_EQ(n_run, 10U);
  EXPECT_NE(read_bytes(page).find("900 scattered points"), std::string::npos);
  // The same meshes that extract makes.
  const auto mesh = run_lode({"extract", points, scratch / "o.ply", "--max-error", "1", "--json"});
  EXPECT_EQ(made.at("models")[0].at("meshes")[1].at("triangles"), mesh.json().at("triangles"));
}

TEST(cli_compare, keeps_its_page_whole_whatever_the_file_is_called) {
  const Scratch scratch;
  const std::string dem = scratch / "a\xff<!--<script>.asc";
  write_dem(dem);
  const std::string page = scratch / "report.html";
  ASSERT_EQ(run_lode({"compare", dem, page, "--tolerances", "50", "--runs", "1"}).exit_code, 0);
  const std::string html = read_bytes(page);
  EXPECT_EQ(html.find("<!--"), std::string::npos);
  EXPECT_EQ(html.find("<script>"), std::string::npos);
}

TEST(cli_compare, holds_links_against_a_memory_limit) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  write_dem(dem);
  const auto made = run_lode({"compare", dem, scratch / "report.html", "--tolerances", "50,10",
                              "--runs", "1", "--memory-limit", "64", "--json"})
                        .json();
  EXPECT_EQ(made.at("memory_limit"), 64);
  EXPECT_NE(made.at("models")[4].at("refusal").get<std::string>().find("up to 64 bytes"),
            std::string::npos);
  expect_refusal(
      run_lode({"compare", dem, scratch / "r.html", "--tolerances", "50", "--memory-limit", "x"}),
      2, {"--memory-limit"});
}

TEST(cli_compare, refuses_what_cannot_be_meant) {
  const Scratch scratch;
  const std::string dem = scratch / "dem.asc";
  const std::string page = scratch / "report.html";
  write_dem(dem);
  write_ball(scratch / "ball.nrrd");
  expect_refusal(run_lode({"compare", dem, page}), 2, {"--tolerances"});
  expect_refusal(run_lode({"compare", dem, page, "--tolerances", "-1"}), 2, {">= 0"});
  expect_refusal(run_lode({"compare", dem, page, "--tolerances", "x"}), 2, {"--tolerances"});
  expect_refusal(run_lode({"compare", dem, page, "--tolerances", "1", "--runs", "0"}), 2,
                 {"--runs"});
  expect_refusal(run_lode({"compare", dem, scratch / "report.pdf", "--tolerances", "1"}), 2,
                 {".html"});
  expect_refusal(run_lode({"compare", scratch / "ball.nrrd", page, "--tolerances", "1"}), 2,
                 {"ball.nrrd", "raster of heights", "scattered points"});
  expect_refusal(run_lode({"compare", dem, page, "--tolerances", "1", "--class", "2"}), 2,
                 {"dem.asc", "--class", "raster"});
  write_dem(scratch / "row.asc", 40, 1);
  expect_refusal(run_lode({"compare", scratch / "row.asc", page, "--tolerances", "1"}), 1,
                 {"row.asc", "40 x 1"});
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.nrrd", "dem.asc", "row.asc"}));
}

}  // namespace
}  // namespace lode::test
