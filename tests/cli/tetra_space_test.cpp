// Tolerances in space of meshes of cells, through files and answers of the program.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

/// [0, 1]^3, with a field that changes by 1 along x, and with another.
class cli_space_errors : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    SimplexMesh mesh;
    const TetraMesh noise = oracles::noise_mesh(11, oracles::Cut::in_six, 5);
    mesh.positions = noise.positions;
    mesh.tetrahedra = noise.tetrahedra;
    mesh.errors.assign(mesh.tetrahedra.size(), 0);
    Attribute waves{.name = "waves", .values = {}};
    waves.errors = mesh.errors;
    for (std::size_t v = 0; v < noise.positions.size(); ++v) {
      const Vec3d& p = noise.positions[v];
      mesh.values.push_back(p[0] + 0.02 * noise.fields[0].values[v]);
      waves.values.push_back(std::sin(9 * p[1]) + p[2]);
    }
    mesh.attributes = {waves};
    Progress progress;
    ASSERT_TRUE(write_mesh(input_, mesh, {.value_name = "slope"}, progress));
  }
  nlohmann::json report(Words words) const {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  nlohmann::json build(const Words& more) const {
    Words words{"build", input_, model_, "--field", "slope", "--placement", GetParam()};
    words.insert(words.end(), more.begin(), more.end());
    return report(words);
  }
  nlohmann::json extract(const std::string& from, const Words& more) const {
    Words words{"extract", from, mesh_, "--field", "slope"};
    words.insert(words.end(), more.begin(), more.end());
    return report(words);
  }
  /// Whatever refuses it says these words.
  void expect_refused(Words words, const Words& said) const {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    for (const std::string& word : said)
      EXPECT_TRUE(run.err.find(word) != std::string::npos) << run.err;
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtu";
  std::string model_ = scratch_ / "x.lode";
  std::string mesh_ = scratch_ / "out.vtu";
};

TEST_P(cli_space_errors, are_built_told_and_kept_to) {
  const nlohmann::json built = build({"--space-errors"});
  const double base = built.at("fields")[0].at("base_space_error");
  EXPECT_GT(base, 0.02);
  EXPECT_EQ(report({"info", model_}).at("fields")[0].at("base_space_error"), base);
  const nlohmann::json coarse = extract(model_, {"--mesh", "--max-space-error", "0.05"});
  EXPECT_LE(coarse.at("achieved_space_error"), 0.05);
  EXPECT_TRUE(coarse.at("max_error").is_null());
  EXPECT_EQ(coarse.at("max_error_is_default"), false);
  const nlohmann::json fine = extract(model_, {"--mesh", "--max-space-error", "0.02"});
  EXPECT_LE(fine.at("achieved_space_error"), 0.02);
  EXPECT_GT(fine.at("cells"), coarse.at("cells"));
  // Beside one of the field.
  const nlohmann::json both =
      extract(model_, {"--mesh", "--max-space-error", "0.05", "--max-error", "0.005"});
  EXPECT_LE(both.at("achieved_error"), 0.005);
  EXPECT_LE(both.at("achieved_space_error"), 0.05);
  // Of surfaces, sections and boundaries, too.
  for (const Words& kind :
       {Words{"--isovalue", "0.5"}, Words{"--section", "0.5,0.5,0.5:0,0,1"}, Words{"--boundary"}}) {
    Words words{"extract", model_, scratch_ / "out.vtp", "--max-space-error", "0.02"};
    words.insert(words.end(), kind.begin(), kind.end());
    EXPECT_LE(report(words).at("achieved_space_error"), 0.02) << kind[0];
  }
}

TEST_P(cli_space_errors, are_found_of_meshes_that_are_built_for_the_question) {
  static_cast<void>(build({"--space-errors"}));
  const nlohmann::json stored = extract(model_, {"--mesh", "--max-space-error", "0.03"});
  const nlohmann::json built =
      extract(input_, {"--mesh", "--max-space-error", "0.03", "--placement", GetParam()});
  EXPECT_EQ(built.at("cells"), stored.at("cells"));
  EXPECT_EQ(built.at("achieved_space_error"), stored.at("achieved_space_error"));
}

TEST_P(cli_space_errors, are_pixels_in_a_view) {
  static_cast<void>(build({"--space-errors"}));
  const std::string camera = scratch_ / "camera.json";
  static_cast<void>(report({"render", model_, scratch_ / "out.png", "--boundary", "--size", "64x48",
                            "--save-camera", camera}));
  const Words view{"--mesh", "--view", camera, "--view-size", "640x480", "--max-error-px"};
  const auto of = [&](const char* pixels) {
    Words words = view;
    words.emplace_back(pixels);
    return extract(model_, words);
  };
  const nlohmann::json fine = of("5");
  EXPECT_LE(fine.at("achieved_px"), 5);
  EXPECT_GE(fine.at("cells"), of("50").at("cells"));
  expect_refused({"extract", model_, mesh_, "--mesh", "--max-error-px", "5"}, {"--view"});
}

TEST_P(cli_space_errors, of_fields_that_come_later_are_found_where_the_first_has_them) {
  const std::string both = scratch_ / "both.lode";
  const auto attach = [&] {
    const Finished run = run_lode({"attach-field", model_, input_, both, "--field", "waves"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return report({"info", both}).at("fields")[1];
  };
  static_cast<void>(build({}));
  EXPECT_FALSE(attach().contains("base_space_error"));
  static_cast<void>(build({"--space-errors"}));
  EXPECT_GT(attach().at("base_space_error"), 0.0);
  const nlohmann::json answer =
      report({"extract", both, mesh_, "--mesh", "--field", "waves", "--max-space-error", "0.05"});
  EXPECT_LE(answer.at("achieved_space_error"), 0.05);
  const nlohmann::json verified = report({"verify", both});
  EXPECT_EQ(verified.at("passed"), true);
}

TEST_P(cli_space_errors, are_refused_where_there_are_none) {
  static_cast<void>(build({}));
  expect_refused({"extract", model_, mesh_, "--mesh", "--max-space-error", "0.1"},
                 {"space errors", "slope"});
  expect_refused({"extract", model_, mesh_, "--mesh", "--max-space-error", "-1"},
                 {"--max-space-error"});
  expect_refused({"extract", model_, mesh_, "--mesh", "--max-space-error", "0.1", "--box",
                  "0,1,0,1,0,1", "--max-error-outside", "5%"},
                 {"--max-error-outside", "--max-space-error"});
  const std::string ball = scratch_ / "ball.nrrd";
  write_ball(ball);
  expect_refused({"extract", ball, mesh_, "--mesh", "--max-space-error", "0.1"},
                 {"--max-space-error", "mesh of cells"});
  expect_refused({"build", ball, model_, "--space-errors"}, {"--space-errors", "mesh of cells"});
}

INSTANTIATE_TEST_SUITE_P(placements, cli_space_errors, testing::Values("half-edge", "midpoint"));

}  // namespace
}  // namespace lode::test
