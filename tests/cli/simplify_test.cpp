#include <gtest/gtest.h>

#include <cmath>

#include "lode/api/files.h"
#include "tests/cli/ball_fixture.h"

namespace lode::test {
namespace {

class cli_simplify : public BallFixture {};

TEST_F(cli_simplify, leaves_fewer_triangles_and_says_how_far) {
  const Finished full = extract("full.ply", {"--isovalue", "100", "--max-error", "0", "--json"});
  ASSERT_EQ(full.exit_code, 0) << full.err;
  const Finished run =
      extract("s.ply", {"--isovalue", "100", "--simplify", "--max-distance", "0.5", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = run.json();
  const nlohmann::json& simplified = report.at("simplified");
  EXPECT_EQ(report.at("max_error"), 0);
  EXPECT_EQ(simplified.at("max_distance"), 0.5);
  EXPECT_LE(simplified.at("proven_distance").get<double>(), 0.5);
  EXPECT_GT(simplified.at("proven_distance").get<double>(), 0);
  EXPECT_EQ(simplified.at("triangles_before"), full.json().at("triangles"));
  EXPECT_EQ(simplified.at("triangles"), report.at("triangles"));
  EXPECT_EQ(simplified.at("components_dropped"), 0);
  EXPECT_EQ(simplified.at("input_crossings"), 0);
  EXPECT_LT(report.at("triangles").get<int>(), full.json().at("triangles").get<int>() / 3);
  const auto surface = read_surface(file("s.ply"));
  ASSERT_TRUE(surface) << surface.error().message;
  EXPECT_EQ(report.at("triangles"), surface->triangles.size());
  EXPECT_EQ(report.at("vertices"), surface->positions.size());
  EXPECT_EQ(surface->normals.size(), surface->positions.size());
}

TEST_F(cli_simplify, prints_what_it_did) {
  const Finished run =
      extract("s.ply", {"--isovalue", "100", "--simplify", "--max-distance", "0.5"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("from the surface before and back (asked for: 0.5)"), std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("simplified"), std::string::npos) << run.out;
}

TEST_F(cli_simplify, gives_the_same_file_for_any_number_of_threads_and_memory_limit) {
  const std::vector<std::string> options = {
      "--isovalue", "100", "--max-error", "4", "--simplify", "--max-distance", "0.3"};
  std::string first;
  for (const char* threads : {"1", "2", "5"}) {
    std::vector<std::string> with = options;
    with.insert(with.end(), {"--threads", threads});
    ASSERT_EQ(extract("s.ply", with).exit_code, 0);
    const std::string bytes = read_bytes(file("s.ply"));
    if (first.empty()) first = bytes;
    EXPECT_EQ(bytes, first);
  }
}

TEST_F(cli_simplify, refuses_what_it_cannot_do) {
  const auto refuses = [&](std::vector<std::string> options, const char* why) {
    const Finished run = extract("s.ply", options);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(file("s.ply")));
  };
  refuses({"--isovalue", "100", "--simplify", "--max-error", "0"},
          "expected --max-error > 0 or --max-distance");
  refuses({"--isovalue", "100", "--remove-slivers"}, "expected --max-distance");
  refuses({"--isovalue", "100", "--simplify", "--clip", "0,5,0,5,0,5"}, "expected no --clip");
  refuses({"--isovalue", "100", "--simplify", "--max-distance", "0"}, "expected a number > 0");
  refuses({"--isovalue", "100", "--simplify", "--max-distance", "1", "--close-border"},
          "expected no --close-border");
  refuses({"--isovalue", "100", "--simplify", "--max-distance", "1", "--section", "0,0,0:0,0,1"},
          "expected no --mesh");
}

TEST_F(cli_simplify, is_verified_against_the_surface_before) {
  const std::vector<std::string> simplify = {"--isovalue", "100", "--simplify", "--max-distance"};
  const auto with_distance = [&](const char* distance) {
    std::vector<std::string> options = simplify;
    options.emplace_back(distance);
    return options;
  };
  const auto verify = [&](const std::string& surface, const char* distance) {
    std::vector<std::string> arguments = {"verify", volume(), "--surface", file(surface)};
    for (const std::string& option : with_distance(distance)) arguments.push_back(option);
    return run_lode(arguments);
  };
  const Finished run = extract("s.ply", with_distance("0.7"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Finished good = verify("s.ply", "0.7");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_NE(good.out.find("before simplification"), std::string::npos) << good.out;
  const Finished strict = verify("s.ply", "0.05");
  EXPECT_EQ(strict.exit_code, 1) << strict.out;
  EXPECT_NE(strict.err.find("distance from that before simplification"), std::string::npos)
      << strict.err;
  const Finished part =
      extract("c.ply", {"--isovalue", "100", "--max-error", "0", "--clip", "0,8,0,16,0,16"});
  ASSERT_EQ(part.exit_code, 0) << part.err;
  const Finished lacking = verify("c.ply", "0.7");
  EXPECT_EQ(lacking.exit_code, 1) << lacking.out;
  EXPECT_NE(lacking.err.find("components, tunnels and boundaries as before"), std::string::npos);
}

TEST_F(cli_simplify, is_verified_to_face_the_way_it_did) {
  for (const Words& how :
       {Words{"--simplify", "--max-distance", "0.7"}, Words{"--simplify", "--max-error", "4"},
        Words{"--remove-slivers", "--max-error", "4", "--max-distance", "0.7"}})
    for (const bool is_flipped : {false, true}) {
      Words words{"--isovalue", "100"};
      words.insert(words.end(), how.begin(), how.end());
      Words flipped = words;
      flipped.emplace_back("--flip");
      ASSERT_EQ(extract("s.ply", is_flipped ? flipped : words).exit_code, 0);
      for (const bool is_expected : {false, true}) {
        Words verify{"verify", volume(), "--surface", file("s.ply")};
        const Words& rest = is_expected ? flipped : words;
        verify.insert(verify.end(), rest.begin(), rest.end());
        const Finished run = run_lode(verify);
        EXPECT_EQ(run.exit_code, is_expected == is_flipped ? 0 : 1) << run.out << run.err;
        if (is_expected != is_flipped)
          EXPECT_NE(run.err.find("pieces face the way they did"), std::string::npos) << run.err;
      }
    }
}

/// One piece outward and one inward, as they are again when all is turned.
TEST_F(cli_simplify, of_a_shell_is_verified_to_face_the_way_it_did) {
  const std::string shell = file("shell.nrrd");
  write_nrrd(shell, {{20, 20, 20}}, [](int x, int y, int z) {
    const double r = std::hypot(x - 9.6, y - 9.3, z - 9.8);
    return static_cast<int>(std::lround(200 - 40 * std::abs(r - 6)));
  });
  for (const Words& how : {Words{"--max-distance", "0.5"}, Words{"--max-error", "4"}}) {
    Words extract{"extract", shell, file("s.ply"), "--isovalue", "120.5", "--simplify", "--flip"};
    Words verify{"verify", shell, "--surface", file("s.ply"), "--isovalue", "120.5", "--simplify"};
    extract.insert(extract.end(), how.begin(), how.end());
    verify.insert(verify.end(), how.begin(), how.end());
    ASSERT_EQ(run_lode(extract).exit_code, 0);
    const Finished run = run_lode(verify);
    EXPECT_EQ(run.exit_code, 1) << run.out;
    EXPECT_NE(run.err.find("pieces face the way they did"), std::string::npos) << run.err;
    verify.emplace_back("--flip");
    EXPECT_EQ(run_lode(verify).exit_code, 0);
  }
}

TEST_F(cli_simplify, within_an_error_leaves_fewer_triangles_and_is_verified) {
  const std::vector<std::string> query = {"--isovalue", "100", "--max-error", "4"};
  std::vector<std::string> with_json = query;
  with_json.emplace_back("--json");
  const Finished plain = extract("p.ply", with_json);
  ASSERT_EQ(plain.exit_code, 0) << plain.err;
  with_json.emplace_back("--simplify");
  const Finished run = extract("s.ply", with_json);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = run.json();
  const nlohmann::json& simplified = report.at("simplified");
  EXPECT_EQ(report.at("max_error"), 4);
  EXPECT_EQ(simplified.at("max_error"), 4);
  EXPECT_GT(simplified.at("proven_error").get<double>(), 0);
  EXPECT_LE(simplified.at("proven_error").get<double>(), 4);
  EXPECT_TRUE(simplified.at("max_distance").is_null());
  EXPECT_EQ(simplified.at("components_dropped"), 0);
  EXPECT_LT(report.at("triangles").get<int>(), plain.json().at("triangles").get<int>() / 2);
  const auto verify = [&](const char* error) {
    return run_lode({"verify", volume(), "--surface", file("s.ply"), "--isovalue", "100",
                     "--simplify", "--max-error", error});
  };
  const Finished good = verify("4");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_NE(good.out.find("samples beyond the tolerance on their sides"), std::string::npos);
  const Finished strict = verify("0.5");
  EXPECT_EQ(strict.exit_code, 1) << strict.out;
  EXPECT_NE(strict.err.find("|F - isovalue| <= tolerance"), std::string::npos) << strict.err;
}

/// A long slab, of which the surface takes a small part beside the border.
TEST_F(cli_simplify, stays_in_the_volume_which_is_verified) {
  const std::string slab = file("slab.nrrd");
  write_nrrd(slab, {{300, 4, 12}},
             [](int x, int y, int z) { return 100 + 40 * y - 3 * ((x * 7 + z * 5) % 11); });
  const std::vector<std::string> query{"--isovalue", "101", "--simplify", "--max-distance", "0.3"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), query.begin(), query.end());
    return run_lode(words);
  };
  const Finished run = with({"extract", slab, file("s.ply"), "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ASSERT_GT(run.json().at("triangles"), 100);
  const Finished good = with({"verify", slab, "--surface", file("s.ply")});
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_NE(good.out.find("vertices in the volume"), std::string::npos) << good.out;
  auto surface = read_surface(file("s.ply"));
  ASSERT_TRUE(surface);
  for (const Vec3f& p : surface->positions) ASSERT_GE(p[1], 0);
  const auto lowest =
      std::ranges::min_element(surface->positions, {}, [](const Vec3f& p) { return p[1]; });
  (*lowest)[1] = -0.01F;
  Progress progress;
  ASSERT_TRUE(write_surface(file("out.ply"), *surface, {}, progress));
  const Finished bad = with({"verify", slab, "--surface", file("out.ply")});
  EXPECT_NE(bad.out.find("1 outside"), std::string::npos) << bad.out << bad.err;
}

TEST_F(cli_simplify, several_within_an_error_are_verified_one_by_one) {
  const std::vector<std::string> query = {"--isovalue", "90",          "--isovalue", "120",
                                          "--simplify", "--max-error", "4"};
  ASSERT_EQ(extract("q.obj", query).exit_code, 0);
  std::vector<std::string> verify{"verify",         volume(),    "--surface",
                                  file("q-90.obj"), "--surface", file("q-120.obj")};
  verify.insert(verify.end(), query.begin(), query.end());
  const Finished good = run_lode(verify);
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_NE(good.out.find("120: samples beyond the tolerance"), std::string::npos) << good.out;
  std::swap(verify[3], verify[5]);
  EXPECT_EQ(run_lode(verify).exit_code, 1);
}

TEST_F(cli_simplify, by_itself_is_within_the_default_error_and_says_so) {
  const Finished run = extract("s.ply", {"--isovalue", "100", "--simplify"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("where edges collapsed (asked for: "), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("pieces in the band"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("inf"), std::string::npos) << run.out;
  const Finished both = extract("b.ply", {"--isovalue", "100", "--simplify", "--max-error", "4",
                                          "--max-distance", "0.3", "--json"});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_LE(both.json().at("simplified").at("proven_error").get<double>(), 4);
  EXPECT_LE(both.json().at("simplified").at("proven_distance").get<double>(), 0.3);
}

TEST_F(cli_simplify, a_distance_alone_is_one_from_full_resolution) {
  const Finished run = extract("d.ply", {"--isovalue", "100", "--max-distance", "0.5", "--json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json report = run.json();
  EXPECT_TRUE(report.at("max_error").is_null());
  EXPECT_FALSE(report.at("max_error_is_default"));
  EXPECT_EQ(report.at("distance").at("max_distance"), 0.5);
  EXPECT_LE(report.at("distance").at("proven_distance").get<double>(), 0.5);
  EXPECT_EQ(report.at("distance").at("lost_triangles"), 0);
  const Finished verified = run_lode({"verify", volume(), "--surface", file("d.ply"), "--isovalue",
                                      "100", "--max-distance", "0.5"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  EXPECT_NE(verified.out.find("distance from that at full resolution and back"), std::string::npos);
  const Finished both = extract(
      "b.ply", {"--isovalue", "100", "--max-distance", "0.5", "--max-error", "1", "--json"});
  ASSERT_EQ(both.exit_code, 0) << both.err;
  EXPECT_LE(both.json().at("achieved_error").get<double>(), 1);
  EXPECT_LE(both.json().at("distance").at("proven_distance").get<double>(), 0.5);
  const Finished text = extract("d.ply", {"--isovalue", "100", "--max-distance", "0.5"});
  EXPECT_NE(text.out.find("(asked for: 0.5)"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("lost"), std::string::npos) << text.out;
}

TEST_F(cli_simplify, a_distance_alone_refuses_what_it_cannot_keep) {
  const auto refuses = [&](std::vector<std::string> options, const char* why) {
    options.insert(options.begin(), {"--isovalue", "100", "--max-distance"});
    const Finished run = extract("s.ply", options);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  };
  refuses({"0"}, "expected a number > 0, got '0'");
  refuses({"1", "--close-border"}, "expected no --close-border");
  refuses({"1", "--min-component", "9"}, "expected no --min-component");
  refuses({"1", "--clip", "0,1,0,1,0,1"}, "expected no --clip");
  refuses({"1", "--style", "cubes", "--max-error", "0"}, "expected no --style cubes");
  refuses({"1", "--mesh"}, "--max-distance: expected no --mesh");
  refuses({"1", "--max-cells", "100"}, "--max-distance: expected no --mesh");
}

}  // namespace
}  // namespace lode::test
