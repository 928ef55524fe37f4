// Files of models on squares, through the program.
#include <gtest/gtest.h>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

class cli_quadtree_model : public testing::TestWithParam<std::string> {
 protected:
  cli_quadtree_model() {
    write_dem(dem_);
    built_ = run_lode({"build", dem_, model_, "--model", GetParam(), "--levels", "50,10", "--json"})
                 .json();
  }
  [[nodiscard]] static bool has_gaps() { return GetParam() != "restricted_quadtree"; }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  const std::string out_ = scratch_ / "out.ply";
  nlohmann::json built_;
};

TEST_P(cli_quadtree_model, is_built_told_of_and_verified) {
  EXPECT_EQ(built_.at("model"), GetParam());
  EXPECT_GT(built_.at("squares"), 100);
  ASSERT_EQ(built_.at("levels").size(), 2U);
  const auto info = run_lode({"info", model_, "--json"}).json();
  for (const char* key : {"levels", "squares", "range", "missing_samples", "to_world"})
    EXPECT_EQ(info.at(key), built_.at(key)) << key;
  const Finished alone = run_lode({"verify", model_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  const Finished against = run_lode({"verify", model_, "--against", dem_});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  const std::string other = scratch_ / "other.asc";
  write_dem(other, 40, 31);
  EXPECT_NE(run_lode({"verify", model_, "--against", other}).exit_code, 0);
}

TEST_P(cli_quadtree_model, gives_triangles) {
  const auto made = run_lode({"extract", model_, out_, "--max-error", "10", "--json"}).json();
  EXPECT_EQ(made.at("model"), GetParam());
  EXPECT_EQ(made.at("triangles"), built_.at("levels")[1].at("triangles"));
  EXPECT_EQ(made.at("error_met"), made.at("achieved_error").get<double>() <= 10);
  const Finished again =
      run_lode({"extract", dem_, out_, "--max-error", "10", "--model", GetParam(), "--json"});
  EXPECT_EQ(again.json().at("triangles"), made.at("triangles"));
  const Finished check =
      run_lode({"verify", dem_, "--surface", out_, "--max-error", "10", "--model", GetParam()});
  if (has_gaps())
    expect_refusal(check, 2, {"gaps"});
  else
    EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

TEST_P(cli_quadtree_model, answers_what_it_can_and_refuses_what_it_cannot_by_its_nature) {
  const auto profile = run_lode({"profile", model_, "--from", "500100,4000100", "--to",
                                 "501000,4000700", "--max-error", "50", "--json"})
                           .json();
  // At a step there are two rows at one place.
  EXPECT_EQ(profile.at("steps") > 0, has_gaps());
  EXPECT_EQ(profile.at("largest_step") > 0, has_gaps());
  const auto& points = profile.at("points");
  std::size_t n_steps = 0;
  for (std::size_t i = 1; i < points.size(); ++i)
    n_steps += points[i].at("part") == points[i - 1].at("part") &&
                       points[i].at("distance") == points[i - 1].at("distance")
                   ? 1
                   : 0;
  EXPECT_EQ(profile.at("steps"), n_steps);
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"height", model_, "--at", "500300,4000300", "--everywhere"},
        {"sight", model_, "--from", "500100,4000100", "--to", "501000,4000700", "--exact"},
        {"contours", model_, scratch_ / "out.vtp", "--interval", "50"}}) {
    SCOPED_TRACE(question[0]);
    const Finished answer = run_lode(question);
    if (has_gaps() && question[0] == "contours")
      expect_refusal(answer, 1, {"dem.lode", "without gaps", GetParam()});
    else
      EXPECT_EQ(answer.exit_code, 0) << answer.err;
  }
  const Finished varied = run_lode({"extract", model_, out_, "--max-error", "10", "--focus-point",
                                    "500600,4000400", "--growth", "0.1"});
  if (has_gaps())
    EXPECT_EQ(varied.exit_code, 0) << varied.err;
  else
    expect_refusal(varied, 1, {"one tolerance"});
  if (has_gaps()) {
    const Finished few = run_lode({"extract", model_, out_, "--max-cells", "500", "--json"});
    EXPECT_EQ(few.exit_code, 0) << few.err;
    EXPECT_LE(few.json().at("triangles"), 500);
    EXPECT_TRUE(few.json().at("budget_met"));
    EXPECT_TRUE(few.json().at("warnings").empty());
  } else {
    expect_refusal(run_lode({"extract", model_, out_, "--max-cells", "500"}), 1,
                   {"tolerance", "keeps no errors", "right_triangle_bisection"});
  }
}

/// Bilinear squares keep what is asked where it is, triangles of them do not: told of as with one
/// tolerance.
TEST_P(cli_quadtree_model, says_what_triangles_keep_where_the_tolerance_varies) {
  if (!has_gaps()) return;
  const bool is_bilinear = GetParam() == "surface_quadtree";
  for (const std::vector<std::string>& focus :
       {std::vector<std::string>{"--box", "500200,500700,4000200,4000600", "--max-error-outside",
                                 "80"},
        {"--focus-point", "500600,4000400", "--growth", "0.1"}}) {
    SCOPED_TRACE(focus[0]);
    std::vector<std::string> arguments{"extract", model_, out_, "--max-error", "10", "--json"};
    arguments.insert(arguments.end(), focus.begin(), focus.end());
    const Finished made = run_lode(arguments);
    EXPECT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(made.json().at("error_met"), !is_bilinear);
    EXPECT_EQ(made.json().at("warnings").size(), is_bilinear ? 1U : 0U);
    if (is_bilinear)
      EXPECT_NE(made.json().at("warnings").dump().find("more than is asked there"),
                std::string::npos);
  }
}

INSTANTIATE_TEST_SUITE_P(models, cli_quadtree_model,
                         testing::Values("surface_quadtree", "quaternary_triangulation",
                                         "restricted_quadtree"),
                         [](const auto& model) { return model.param; });

}  // namespace
}  // namespace lode::test
