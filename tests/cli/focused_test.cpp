#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "lode/api/files.h"
#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

class cli_focused : public BallFixture {
 protected:
  [[nodiscard]] Finished extract(Words options) {
    options.insert(options.begin(), {"--isovalue", "100"});
    return BallFixture::extract("s.ply", options);
  }
  [[nodiscard]] nlohmann::json report(Words options) {
    options.emplace_back("--json");
    const Finished run = extract(options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  /// As many triangles as the report says are in the file.
  void expect_written(const nlohmann::json& json) {
    const auto surface = read_surface(scratch_ / "s.ply");
    ASSERT_TRUE(surface) << surface.error().message;
    EXPECT_EQ(surface->triangles.size(), json.at("triangles"));
  }
  void write_camera_file(double y) {
    write_bytes(scratch_ / "camera.json",
                R"({"eye": [8, )" + std::to_string(y) + R"(, 8], "target": [8, 8, 8]})");
  }
};

TEST_F(cli_focused, is_finer_in_a_box_than_outside) {
  const auto n = [&](const Words& options) -> std::size_t {
    const nlohmann::json json = report(options);
    expect_written(json);
    return json.at("triangles");
  };
  const std::size_t coarse = n({"--max-error", "20", "--max-cells", "1000000"});
  const std::size_t fine = n({"--max-error", "0", "--max-cells", "1000000"});
  const std::size_t mixed =
      n({"--max-error", "0", "--box", "0,3,0,3,0,3", "--max-error-outside", "20"});
  EXPECT_GT(mixed, coarse);
  EXPECT_LT(mixed, fine);
  EXPECT_EQ(n({"--max-error", "0", "--ball", "8,8,8,20"}), fine);
}

TEST_F(cli_focused, is_held_to_its_bound_by_verify_and_to_no_smaller_one) {
  const auto verified = [&](const std::string& bound, Words more) {
    Words words{"verify", lode_file(),     "--surface", scratch_ / "s.ply", "--isovalue",
                "100",    "--error-bound", bound,       "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words).exit_code;
  };
  const nlohmann::json budget = report({"--max-cells", "600"});
  const double bound = budget.at("error_bound");
  ASSERT_GT(bound, 1);
  EXPECT_LT(budget.at("coordinate_slack"), 0.1);
  EXPECT_EQ(verified(fmt::format("{}", bound), {}), 0);
  EXPECT_EQ(verified("0.1", {}), 1);
  EXPECT_EQ(verified("100%", {}), 0);
  // In a box it is finer than elsewhere.
  const std::string box = "0,8,0,8,0,8";
  EXPECT_GT(report({"--max-error", "1", "--box", box, "--max-error-outside", "25"}).at("triangles"),
            0);
  EXPECT_EQ(verified("1", {"--box", box}), 0);
  EXPECT_EQ(verified("1", {}), 1);
  EXPECT_EQ(verified("25", {}), 0);
}

/// Also where a box is smaller than a triangle; and where it has nothing nothing is said to hold.
TEST_F(cli_focused, is_held_to_its_bound_by_verify_in_the_smallest_box) {
  EXPECT_GT(report({"--max-cells", "600"}).at("triangles"), 0);
  const auto checks_in = [&](const std::string& box) {
    Words words{"verify",        lode_file(), "--surface", scratch_ / "s.ply", "--isovalue", "100",
                "--error-bound", "0.1",       "--json"};
    if (!box.empty()) words.insert(words.end(), {"--box", box});
    return run_lode(words).json().at("checks");
  };
  const auto of_values = [](const nlohmann::json& checks) -> nlohmann::json {
    for (const nlohmann::json& check : checks)
      if (check.at("name").get<std::string>().starts_with("|F - isovalue|")) return check;
    return {};
  };
  const std::string detail = of_values(checks_in("")).at("detail");
  std::array<double, 3> at{};
  const std::size_t place = detail.find("at (");
  ASSERT_NE(place, std::string::npos) << detail;
  ASSERT_EQ(std::sscanf(detail.c_str() + place, "at (%lf, %lf, %lf)", at.data(), at.data() + 1,
                        at.data() + 2),
            3);
  const auto box = [&](double off) {
    constexpr double kHalf = 0.01;
    return fmt::format("{},{},{},{},{},{}", at[0] + off - kHalf, at[0] + off + kHalf, at[1] - kHalf,
                       at[1] + kHalf, at[2] - kHalf, at[2] + kHalf);
  };
  EXPECT_EQ(of_values(checks_in(box(0))).at("passed"), false);
  EXPECT_TRUE(of_values(checks_in(box(100))).at("passed").is_null());
}

TEST_F(cli_focused, whose_triangles_are_not_all_there_is_refused_by_verify) {
  EXPECT_GT(report({"--max-error", "1", "--max-cells", "1000000"}).at("triangles"), 0);
  auto surface = read_surface(scratch_ / "s.ply");
  ASSERT_TRUE(surface);
  surface->triangles.erase(surface->triangles.begin() + 7);
  Progress progress;
  ASSERT_TRUE(write_surface(scratch_ / "s.ply", *surface, {}, progress));
  const Finished run = run_lode({"verify", lode_file(), "--surface", scratch_ / "s.ply",
                                 "--isovalue", "100", "--error-bound", "1"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("on their sides"), std::string::npos) << run.err;
}

TEST_F(cli_focused, says_what_goes_with_a_bound) {
  EXPECT_GT(report({"--max-error", "1"}).at("triangles"), 0);
  const auto refused = [&](Words words, const char* why) {
    words.insert(words.begin(), {"verify", lode_file()});
    expect_refusal(run_lode(words), 2, {why});
  };
  const std::string surface = scratch_ / "s.ply";
  refused({"--error-bound", "1"}, "--error-bound: expected one --surface");
  refused({"--surface", surface, "--isovalue", "100", "--error-bound", "1", "--max-error", "1"},
          "got --max-error");
  refused({"--surface", surface, "--isovalue", "100", "--box", "0,1,0,1,0,1"},
          "--box: expected --error-bound");
  refused({"--surface", surface, "--isovalue", "100", "--error-bound", "-1"}, "--error-bound");
}

TEST_F(cli_focused, keeps_budgets_and_says_when_it_cannot) {
  const nlohmann::json json = report({"--max-cells", "500"});
  EXPECT_LE(json.at("cells"), 500);
  EXPECT_TRUE(json.at("budget_met"));
  EXPECT_GT(json.at("error_bound"), 0);
  const nlohmann::json less = report({"--max-cells", "1"});
  EXPECT_FALSE(less.at("budget_met"));
  EXPECT_EQ(less.at("nodes"), 0);
  EXPECT_FALSE(less.at("warnings").empty());
}

TEST_F(cli_focused, names_the_memory_limit_where_that_ends_it) {
  const Words focus = {"--box", "0,16,0,16,0,16", "--max-error", "0", "--memory-limit", "1K"};
  const Finished run = extract(focus);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("the memory limit is too small"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("--max-cells"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("meets nothing"), std::string::npos) << run.err;
  Words mesh = focus;
  mesh.insert(mesh.end(), {"--mesh"});
  const Finished meshed = BallFixture::extract("m.vtu", mesh);
  EXPECT_EQ(meshed.exit_code, 0) << meshed.err;
  EXPECT_EQ(meshed.err.find("--max-cells"), std::string::npos) << meshed.err;
}

TEST_F(cli_focused, looks_through_a_camera) {
  write_camera_file(-60);
  const Words view{"--view", scratch_ / "camera.json", "--view-size", "400x300"};
  const auto with = [&](const char* pixels) {
    Words options = view;
    options.insert(options.end(), {"--max-error-px", pixels});
    const nlohmann::json json = report(options);
    EXPECT_LE(json.at("achieved_px").get<double>(), std::stod(pixels));
    expect_written(json);
    return json.at("triangles").get<std::size_t>();
  };
  EXPECT_GT(with("0.2"), with("8"));
  write_camera_file(8.5);  // inside the data
  EXPECT_GT(with("1"), 0U);
}

TEST_F(cli_focused, answers_at_once_at_a_deadline_of_zero) {
  const nlohmann::json json = report({"--deadline-ms", "0"});
  EXPECT_EQ(json.at("steps"), 0);
  EXPECT_FALSE(json.at("is_settled"));
  const nlohmann::json later = report({"--deadline-ms", "60000"});
  EXPECT_TRUE(later.at("is_settled"));
  EXPECT_EQ(later.at("error_bound"), 0);
}

TEST_F(cli_focused, names_the_camera_file_that_is_missing) {
  expect_refusal(extract({"--view", scratch_ / "none.json"}), 1, {"none.json"});
}

TEST(cli_focused_lines, need_a_format_that_holds_them) {
  const Scratch scratch;
  write_nrrd(scratch / "flat.nrrd", {{20, 20, 1}}, [](int x, int y, int) { return 7 * x + 3 * y; });
  const Words query{"--isovalue", "50", "--max-cells", "100"};
  const auto extract = [&](const char* output) {
    Words words{"extract", scratch / "flat.nrrd", scratch / output, "--quiet"};
    words.insert(words.end(), query.begin(), query.end());
    return run_lode(words);
  };
  expect_refusal(extract("s.stl"), 1, {"s.stl", "contour lines"});
  EXPECT_EQ(extract("s.ply").exit_code, 0);
}

TEST(cli_focused_usage, refuses_what_makes_no_sense) {
  const auto refused = [](Words options, const Words& words) {
    options.insert(options.begin(), {"extract", "a.lode", "s.ply"});
    expect_refusal(run_lode(options), 2, words);
  };
  refused({"--box", "0,1,0,1,0,1"}, {"--isovalue", "expected one"});
  refused({"--box", "0,1,0,1,0,1", "--isovalue", "1,2"}, {"--isovalue", "got 2"});
  refused({"--isovalue", "1", "--max-error-px", "1"}, {"--max-error-px", "--view"});
  refused({"--isovalue", "1", "--max-error-px", "-1", "--view", "c.json"}, {"--max-error-px"});
  refused({"--isovalue", "1", "--deadline-ms", "-1"}, {"--deadline-ms"});
  refused({"--isovalue", "1", "--deadline-ms", "x"}, {"--deadline-ms"});
  refused({"--isovalue", "1", "--max-error-outside", "1"}, {"--max-error-outside", "--box"});
  refused({"--isovalue", "1", "--view", "c.json", "--view-size", "3"}, {"--view-size"});
  refused({"--isovalue", "1", "--max-cells", "5", "--close-border"}, {"--close-border"});
}

}  // namespace
}  // namespace lode::test
