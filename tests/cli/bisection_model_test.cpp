// Files of bisected right triangles, through the program.
#include <gtest/gtest.h>

#include "tests/cli/dem_fixture.h"
#include "tests/cli/program.h"

namespace lode::test {
namespace {

class cli_bisection_model : public testing::Test {
 protected:
  cli_bisection_model() {
    write_dem(dem_);
    built_ = run_lode({"build", dem_, model_, "--model", "right_triangle_bisection", "--levels",
                       "50,10", "--json"})
                 .json();
  }

  const Scratch scratch_;
  const std::string dem_ = scratch_ / "dem.asc";
  const std::string model_ = scratch_ / "dem.lode";
  const std::string out_ = scratch_ / "out.ply";
  nlohmann::json built_;
};

TEST_F(cli_bisection_model, is_built_told_of_and_verified) {
  EXPECT_EQ(built_.at("model"), "right_triangle_bisection");
  EXPECT_GE(built_.at("first_triangles"), 2);
  ASSERT_EQ(built_.at("levels").size(), 2U);
  const auto info = run_lode({"info", model_, "--json"}).json();
  for (const char* key : {"levels", "first_triangles", "range", "missing_samples", "to_world"})
    EXPECT_EQ(info.at(key), built_.at(key)) << key;
  const Finished alone = run_lode({"verify", model_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  EXPECT_NE(alone.out.find("errors are nested"), std::string::npos) << alone.out;
  const Finished against = run_lode({"verify", model_, "--against", dem_});
  EXPECT_EQ(against.exit_code, 0) << against.out << against.err;
  const std::string other = scratch_ / "other.asc";
  write_dem(other, 40, 31);
  EXPECT_NE(run_lode({"verify", model_, "--against", other}).exit_code, 0);
}

TEST_F(cli_bisection_model, answers_all_questions) {
  const auto made = run_lode({"extract", model_, out_, "--max-error", "10", "--json"}).json();
  EXPECT_EQ(made.at("triangles"), built_.at("levels")[1].at("triangles"));
  EXPECT_LE(made.at("achieved_error"), 10);
  const Finished check = run_lode({"verify", dem_, "--surface", out_, "--max-error", "10",
                                   "--model", "right_triangle_bisection"});
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
  for (const std::vector<std::string>& question :
       {std::vector<std::string>{"height", model_, "--at", "500300,4000300"},
        {"height", dem_, "--at", "500300,4000300", "--model", "right_triangle_bisection"},
        {"profile", model_, "--from", "500100,4000100", "--to", "501000,4000700"},
        {"contours", model_, scratch_ / "out.vtp", "--interval", "50"},
        {"sight", model_, "--from", "500100,4000100", "--to", "501000,4000700"},
        {"render", model_, scratch_ / "out.png", "--size", "64x48"}}) {
    SCOPED_TRACE(question[0]);
    const Finished answer = run_lode(question);
    EXPECT_EQ(answer.exit_code, 0) << answer.err;
  }
}

TEST_F(cli_bisection_model, varies_and_keeps_a_number_of_triangles) {
  const auto uniform = run_lode({"extract", model_, out_, "--max-error", "1", "--json"}).json();
  const auto varied = run_lode({"extract", model_, out_, "--max-error", "1", "--focus-point",
                                "500600,4000400", "--growth", "0.1", "--json"})
                          .json();
  EXPECT_FALSE(varied.at("is_uniform"));
  EXPECT_LT(varied.at("triangles"), uniform.at("triangles"));
  const auto few = run_lode({"extract", model_, out_, "--max-cells", "300", "--json"}).json();
  EXPECT_LE(few.at("triangles"), 300);
  EXPECT_GT(few.at("triangles"), 150);
  EXPECT_TRUE(few.at("budget_met"));
  const auto none = run_lode({"extract", model_, out_, "--max-cells", "1", "--json"}).json();
  EXPECT_FALSE(none.at("budget_met"));
  // A tolerance that fewer triangles keep is enough.
  const auto enough =
      run_lode({"extract", model_, out_, "--max-error", "50", "--max-cells", "1000000", "--json"})
          .json();
  EXPECT_EQ(enough.at("triangles"), built_.at("levels")[0].at("triangles"));
}

TEST_F(cli_bisection_model, warns_of_a_focus_beside_the_terrain_alone) {
  const auto warning_of = [&](const char* box, const char* max_error) {
    const Finished made =
        run_lode({"extract", model_, out_, "--max-error", max_error, "--box", box});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return made.err;
  };
  EXPECT_NE(warning_of("0,10,0,10", "1").find("meets no triangle"), std::string::npos);
  EXPECT_EQ(warning_of("500300,500600,4000300,4000500", "1"), "");
  // Nothing has to be refined.
  EXPECT_EQ(warning_of("500300,500600,4000300,4000500", "100000"), "");
}

TEST_F(cli_bisection_model, keeps_features) {
  const auto made = run_lode({"build", dem_, model_, "--model", "right_triangle_bisection",
                              "--feature-relief", "20", "--levels", "50", "--json"})
                        .json();
  EXPECT_GT(made.at("kept_samples"), 3);
  const Finished alone = run_lode({"verify", model_});
  EXPECT_EQ(alone.exit_code, 0) << alone.out << alone.err;
  EXPECT_NE(alone.out.find("kept samples are vertices"), std::string::npos) << alone.out;
  expect_refusal(run_lode({"build", dem_, model_, "--model", "right_triangle_bisection",
                           "--breaklines", dem_}),
                 2, {"delaunay_selector"});
}

}  // namespace
}  // namespace lode::test
