// Tolerances as shares of the range of a field's values: --max-error 2%.
#include <gtest/gtest.h>

#include "tests/cli/ball_fixture.h"
#include "tests/cli/tetra_fixture.h"

namespace lode::test {
namespace {

/// The tolerance that a run reports.
double max_error_of(Words words) {
  words.emplace_back("--json");
  const Finished run = run_lode(words);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.exit_code == 0 ? run.json().at("max_error").get<double>() : -1;
}

class cli_share : public BallFixture {};

/// The ball's values are from 0 to 200.
TEST_F(cli_share, of_a_volume_s_range_is_what_all_its_commands_take) {
  const std::string lode = lode_file();
  const std::string ply = file("s.ply");
  const Words share = {"--isovalue", "100", "--max-error", "2%"};
  const auto with = [&](Words words) {
    words.insert(words.end(), share.begin(), share.end());
    return words;
  };
  for (const Words& words : {Words{"extract", lode, ply},
                             {"extract", volume(), ply},
                             {"extract", lode, ply, "--keep-topology"},
                             {"extract", lode, ply, "--simplify"},
                             {"extract", lode, ply, "--box", "2,9,2,9,2,9"},
                             {"extract", lode, file("m.vtu"), "--mesh"},
                             {"extract", lode, file("s.vtp"), "--section", "0,0,7:0,0,1"},
                             {"count", lode},
                             {"render", lode, file("p.png"), "--size", "40x30"}})
    EXPECT_DOUBLE_EQ(max_error_of(with(words)), 4) << words[0] << " " << words.back();
  EXPECT_DOUBLE_EQ(max_error_of({"extract", lode, ply, "--isovalue", "9", "--max-error", "0.25%"}),
                   0.5);
}

TEST_F(cli_share, makes_the_surface_of_its_number) {
  ASSERT_EQ(extract("share.ply", {"--isovalue", "100", "--max-error", "2%"}).exit_code, 0);
  ASSERT_EQ(extract("number.ply", {"--isovalue", "100", "--max-error", "4"}).exit_code, 0);
  EXPECT_EQ(read_bytes(file("share.ply")), read_bytes(file("number.ply")));
  const auto verify = [&](const char* share) {
    return run_lode({"verify", lode_file(), "--surface", file("share.ply"), "--isovalue", "100",
                     "--max-error", share});
  };
  EXPECT_EQ(verify("2%").exit_code, 0);
  EXPECT_NE(verify("1%").exit_code, 0) << "another surface";
}

TEST_F(cli_share, is_a_number_with_one_sign) {
  for (const char* text : {"%", "-1%", "1%%", "1 %", "nan%", "one%", "1e999%"})
    expect_refusal(extract("s.ply", {"--isovalue", "100", "--max-error", text}), 2,
                   {"--max-error"});
}

TEST_F(cli_share, is_of_values_and_not_of_heights) {
  write_bytes(file("dem.asc"),
              "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2\n3 4\n");
  expect_refusal(run_lode({"extract", file("dem.asc"), file("t.ply"), "--max-error", "1%"}), 2,
                 {"--max-error", "units of the heights"});
}

using cli_tetra_share = cli_tetra;

TEST_F(cli_tetra_share, of_a_mesh_s_range_is_what_all_its_commands_take) {
  Finished info = run_lode({"build", input_, scratch_ / "waves.lode", "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  const std::string lode = scratch_ / "waves.lode";
  const SimplexMesh mesh = waves(13);
  const auto [low, high] = std::ranges::minmax(mesh.values);
  const double expected = 0.05 * (high - low);
  for (const Words& words :
       {Words{"extract", lode, output_, "--mesh"},
        {"extract", lode, scratch_ / "b.vtp", "--boundary"},
        {"extract", lode, scratch_ / "s.vtp", "--section", "0,0,6:0,0,1"},
        {"extract", lode, scratch_ / "i.ply", "--isovalue", "5"},
        {"probe", lode, "--point", "3.5,4,5"},
        {"probe", lode, "--integral"},
        {"render", lode, scratch_ / "p.png", "--isovalue", "5", "--size", "40x30"}}) {
    Words all = words;
    all.insert(all.end(), {"--max-error", "5%"});
    EXPECT_NEAR(max_error_of(all), expected, 1e-6 * expected) << words[0] << " " << words.back();
  }
}

}  // namespace
}  // namespace lode::test
