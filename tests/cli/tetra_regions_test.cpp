// Regions by their names, through files and answers of the program.
#include <gtest/gtest.h>

#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

/// [0, 1]^3, of which x < 0.5 is the rotor, 7, and what is left of it air, 12, and another, -3.
class cli_regions : public testing::Test {
 protected:
  void SetUp() override {
    const TetraMesh noise = oracles::noise_mesh(9, oracles::Cut::in_six, 5);
    mesh_.positions = noise.positions;
    mesh_.values = noise.fields[0].values;
    mesh_.tetrahedra = noise.tetrahedra;
    mesh_.errors.assign(mesh_.tetrahedra.size(), 0);
    for (const auto& t : mesh_.tetrahedra) {
      Vec3d centre;
      for (const std::uint32_t v : t) centre = centre + mesh_.positions[v] * 0.25;
      mesh_.regions.push_back(centre[0] < 0.5 ? 7 : centre[1] < 0.5 ? 12 : -3);
    }
    mesh_.region_names = {{7, "rotor"}, {12, "the air"}};
    write(input_);
  }
  void write(const std::string& path) const {
    Progress progress;
    ASSERT_TRUE(write_mesh(path, mesh_, {.value_name = "noise"}, progress));
  }
  nlohmann::json report(Words words) const {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  [[nodiscard]] double volume_of(const std::string& input, const Words& options) const {
    Words words{"probe", input, "--integral", "--max-error", "0"};
    words.insert(words.end(), options.begin(), options.end());
    return report(words).at("volume").at("value");
  }

  SimplexMesh mesh_;
  Scratch scratch_;
  std::string input_ = scratch_ / "in.vtu";
  std::string model_ = scratch_ / "x.lode";
};

TEST_F(cli_regions, are_told_by_name_and_number) {
  const nlohmann::json ids{-3, 7, 12};
  const nlohmann::json names{"", "rotor", "the air"};
  for (const char* const placement : {"half-edge", "midpoint"}) {
    const nlohmann::json built = report({"build", input_, model_, "--placement", placement});
    EXPECT_EQ(built.at("regions"), ids);
    EXPECT_EQ(built.at("region_names"), names);
    for (const std::string& file : {input_, model_}) {
      EXPECT_EQ(report({"info", file}).at("regions"), ids);
      EXPECT_EQ(report({"info", file}).at("region_names"), names);
    }
    const std::string table = run_lode({"info", model_}).out;
    EXPECT_NE(table.find("rotor (7)"), std::string::npos) << table;
    EXPECT_NE(table.find("the air (12)"), std::string::npos) << table;
  }
  EXPECT_NEAR(volume_of(model_, {"--region", "rotor"}), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(model_, {"--region", "7"}), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(model_, {"--region", "the air", "--region", "-3"}), 0.5, 1e-9);
  EXPECT_NEAR(volume_of(input_, {"--region", "the air"}), 0.25, 1e-9);
  // Two of one name are meant both.
  mesh_.region_names[1].name = "rotor";
  write(input_);
  EXPECT_NEAR(volume_of(input_, {"--region", "rotor"}), 0.75, 1e-9);
}

TEST_F(cli_regions, are_cut_out_by_name_and_keep_it) {
  ASSERT_EQ(run_lode({"build", input_, model_}).exit_code, 0);
  for (const char* const name : {"out.vtu", "out.msh"}) {
    const std::string output = scratch_ / name;
    report({"extract", model_, output, "--mesh", "--max-error", "0.1", "--region", "the air"});
    EXPECT_NEAR(volume_of(output, {"--field", "noise"}), 0.25, 1e-6);
    const nlohmann::json info = report({"info", output});
    EXPECT_EQ(info.at("regions"), nlohmann::json({12}));
    EXPECT_EQ(info.at("region_names"), nlohmann::json({"the air"}));
    // The one region that is left has its name in what is made of it.
    const std::string again = scratch_ / "again.lode";
    const std::string last = scratch_ / (std::string("last_") + name);
    report({"build", output, again, "--field", "noise"});
    report({"extract", again, last, "--mesh", "--max-error", "0"});
    EXPECT_EQ(report({"info", last}).at("region_names"), nlohmann::json({"the air"}));
  }
  for (const Words& of :
       {Words{"--boundary"}, {"--isovalue", "0"}, {"--section", "0.6,0.2,0.5:1,2,3"}}) {
    const std::string output = scratch_ / "out.vtp";
    Words words{"extract", model_, output, "--max-error", "0", "--region", "rotor"};
    words.insert(words.end(), of.begin(), of.end());
    report(words);
    EXPECT_NE(read_bytes(output).find("Name=\"RegionNames\" NumberOfTuples=\"2\""),
              std::string::npos);
  }
  report({"render", model_, scratch_ / "out.png", "--boundary", "--region", "rotor", "--size",
          "32x32"});
}

TEST_F(cli_regions, that_are_not_there_are_answered_with_those_that_are) {
  ASSERT_EQ(run_lode({"build", input_, model_}).exit_code, 0);
  const std::string expected = "expected one of -3, rotor (7), the air (12), got stator";
  for (const Words& words : {Words{"extract", model_, scratch_ / "out.vtu", "--mesh"},
                             {"extract", model_, scratch_ / "out.vtp", "--boundary"},
                             {"extract", model_, scratch_ / "out.vtp", "--isovalue", "0"},
                             {"extract", model_, scratch_ / "out.vtp", "--section", "0,0,0:1,0,0"},
                             {"probe", model_, "--integral"},
                             {"render", model_, scratch_ / "out.png", "--boundary"}}) {
    Words wanted = words;
    wanted.insert(wanted.end(), {"--region", "stator"});
    expect_refusal(run_lode(wanted), 1, {model_, expected});
  }
}

TEST_F(cli_regions, stay_where_fields_are_attached) {
  ASSERT_EQ(run_lode({"build", input_, model_}).exit_code, 0);
  const std::string more = scratch_ / "more.lode";
  report({"attach-field", model_, input_, more, "--field", "noise", "--at", "3"});
  EXPECT_EQ(report({"info", more}).at("region_names"), nlohmann::json({"", "rotor", "the air"}));
}

}  // namespace
}  // namespace lode::test
