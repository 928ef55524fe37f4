#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/cli/program.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

TEST(cli_whole_path, builds_extracts_verifies_and_renders) {
  const Scratch scratch;
  const std::string volume = scratch / "ball.nrrd";
  const std::string lode = scratch / "ball.lode";
  const std::string surface = scratch / "ball.ply";
  write_ball(volume);
  const std::string picture = scratch / "ball.png";
  for (const auto& arguments :
       {Words{"info", volume}, Words{"build", volume, lode}, Words{"info", lode},
        Words{"extract", lode, surface, "--isovalue", "100", "--max-error", "4"},
        Words{"verify", lode}, Words{"verify", lode, "--against", volume},
        Words{"verify", lode, "--surface", surface, "--isovalue", "100", "--max-error", "4"},
        Words{"render", lode, picture, "--isovalue", "100", "--max-error", "4", "--size", "64x48",
              "--samples", "2", "--save-camera", scratch / "camera.json"}}) {
    const Finished people = run_lode(arguments);
    EXPECT_EQ(people.exit_code, 0) << arguments[0] << people.err;
    EXPECT_EQ(people.err, "") << arguments[0];
    EXPECT_NE(people.out, "") << arguments[0];
    auto with_json = arguments;
    with_json.push_back("--json");
    const Finished machine = run_lode(with_json);
    EXPECT_EQ(machine.err, "") << arguments[0];
    EXPECT_EQ(machine.json().at("command"), arguments[0]);
  }
  EXPECT_TRUE(read_bytes(picture).starts_with("\x89PNG"));
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ball.lode", "ball.nrrd", "ball.ply",
                                                       "ball.png", "camera.json"}));
}

TEST(cli_verify, fails_on_a_flipped_byte_anywhere) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  const std::string bytes = read_bytes(scratch / "ball.lode");
  const std::size_t step = std::max<std::size_t>(1, bytes.size() / 23);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    write_bytes(scratch / "flipped.lode", flipped);
    const Finished run = run_lode({"verify", scratch / "flipped.lode"});
    EXPECT_EQ(run.exit_code, 1) << "byte " << at;
    EXPECT_NE(run.err.find("flipped.lode"), std::string::npos) << run.err;
  }
}

TEST(cli_verify, fails_against_other_data_and_names_the_worst) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  write_nrrd(scratch / "noise.nrrd", {{17, 17, 17}},
             [](int x, int y, int z) { return (x * 7919 + y * 104729 + z * 1299709) % 251; });
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  const Finished run =
      run_lode({"verify", scratch / "ball.lode", "--against", scratch / "noise.nrrd", "--json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.err.starts_with("lode: ")) << run.err;
  EXPECT_NE(run.json(), nlohmann::json());
}

TEST(cli_verify, fails_on_a_surface_of_another_isovalue) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", scratch / "ball.lode"}).exit_code, 0);
  ASSERT_EQ(run_lode({"extract", scratch / "ball.lode", scratch / "s.ply", "--isovalue", "100",
                      "--max-error", "1"})
                .exit_code,
            0);
  const Finished run = run_lode({"verify", scratch / "ball.lode", "--surface", scratch / "s.ply",
                                 "--isovalue", "140", "--max-error", "1", "--json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.json().at("passed"), false);
}

TEST(cli_verify, refuses_options_of_a_surface_without_one) {
  const Scratch scratch;
  write_ball(scratch / "ball.nrrd");
  const std::string file = scratch / "ball.lode";
  ASSERT_EQ(run_lode({"build", scratch / "ball.nrrd", file}).exit_code, 0);
  for (const Words& options : {Words{"--simplify"},
                               {"--keep-topology"},
                               {"--flip"},
                               {"--style", "cubes"},
                               {"--max-error", "3"},
                               {"--isovalue", "9"},
                               {"--max-distance", "1"},
                               {"--close-border"},
                               {"--clip", "0,1,0,1,0,1"},
                               {"--min-component", "3"},
                               {"--normals", "off"}}) {
    Words words{"verify", file};
    words.insert(words.end(), options.begin(), options.end());
    expect_refusal(run_lode(words), 2, {options[0], "--surface"});
  }
}

TEST(cli_verify, every_format_comes_back_from_a_volume_with_holes) {
  // Where holes pinch the domain there are twins, which STL merges.
  const Scratch scratch;
  std::uint64_t state = 1;
  write_nrrd(scratch / "noise.nrrd", {{12, 12, 12}}, [&](int, int, int) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    const auto value = static_cast<int>(state >> 33U) % 100;
    return value < 6 ? 0 : value;
  });
  const Words query{"--isovalue", "50", "--max-error", "0", "--nodata", "0", "--quiet"};
  for (const char* name : {"s.ply", "s.stl", "s.obj", "s.vtp", "s.glb"}) {
    Words extract{"extract", scratch / "noise.nrrd", scratch / name};
    Words verify{"verify", scratch / "noise.nrrd", "--surface", scratch / name};
    extract.insert(extract.end(), query.begin(), query.end());
    verify.insert(verify.end(), query.begin(), query.end());
    ASSERT_EQ(run_lode(extract).exit_code, 0) << name;
    const Finished run = run_lode(verify);
    EXPECT_EQ(run.exit_code, 0) << name << ": " << run.err;
    EXPECT_EQ(run.out.find(" 0 hole or clip twins"), std::string::npos) << name;
  }
}

TEST(cli_verify, says_what_it_has_no_memory_to_look_at) {
  const Scratch scratch;
  const std::string volume = scratch / "waves.nrrd";
  const std::string lode = scratch / "waves.lode";
  write_nrrd(volume, {{60, 50, 40}}, [](int x, int y, int z) {
    return 100 + static_cast<int>(40 * std::sin(0.1 * x) + 20 * std::sin(0.4 * y + 0.1 * z));
  });
  ASSERT_EQ(run_lode({"build", volume, lode}).exit_code, 0);
  const Finished all = run_lode({"verify", lode, "--json"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_EQ(all.json().at("checks").size(), 4U);
  EXPECT_GT(all.json().at("checks").at(2).at("count"), 10'000);
  const Finished some = run_lode({"verify", lode, "--json", "--memory-limit", "200K"});
  EXPECT_EQ(some.exit_code, 0) << some.err;
  EXPECT_EQ(some.json().at("checks").size(), 2U);
  EXPECT_TRUE(some.json().at("checks").at(1).at("passed").is_null()) << some.out;
  EXPECT_NE(some.err.find("not looked at"), std::string::npos) << some.err;
  const Finished against =
      run_lode({"verify", lode, "--json", "--memory-limit", "200K", "--against", volume});
  EXPECT_EQ(against.exit_code, 0) << against.err;
  EXPECT_EQ(against.json().at("checks").size(), 5U);
  EXPECT_TRUE(against.json().at("checks").at(2).at("passed"));
  EXPECT_TRUE(against.json().at("checks").at(3).at("passed").is_null()) << against.out;
  EXPECT_TRUE(against.json().at("checks").at(4).at("passed").is_null()) << against.out;
}

/// Of a file larger than the memory limit other triangles keep the distance than of one in memory.
TEST(cli_verify, repeats_a_distance_in_the_windows_of_its_memory_limit) {
  const Scratch scratch;
  const std::string volume = scratch / "long.nrrd";
  const std::string lode = scratch / "long.lode";
  const std::string ply = scratch / "s.ply";
  write_nrrd(
      volume, oracles::trials<Index3>({{1100, 17, 14}}, {{600, 17, 14}}), [](int x, int y, int z) {
        return 100 + static_cast<int>(40 * std::sin(0.03 * x) + 10 * std::sin(0.4 * y + 0.1 * z));
      });
  ASSERT_EQ(run_lode({"build", volume, lode}).exit_code, 0);
  const Words query{"--isovalue", "100.5", "--max-distance", "2"};
  const auto run = [&](Words words, const Words& more) {
    words.insert(words.end(), query.begin(), query.end());
    words.insert(words.end(), more.begin(), more.end());
    return run_lode(words);
  };
  const Finished made = run({"extract", lode, ply}, {"--memory-limit", "1M", "--json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.json().at("distance").at("memory_limit"), 1 << 20);
  EXPECT_NE(read_bytes(ply).find("memory_limit 1048576"), std::string::npos);
  for (const Words& more :
       {Words{"--memory-limit", "1M"}, {"--memory-limit", "1M", "--against", volume}}) {
    const Finished verified = run({"verify", lode, "--surface", ply}, more);
    EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
  }
  EXPECT_EQ(run({"verify", lode, "--surface", ply}, {}).exit_code, 1) << "in memory it is another";
  expect_refusal(run({"verify", lode, "--surface", ply}, {"--simplify", "--memory-limit", "1M"}), 2,
                 {"--memory-limit", "without --simplify"});
}

}  // namespace
}  // namespace lode::test
