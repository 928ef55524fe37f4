// Fields of meshes whose files have steps, or fields in files of their own, through the program.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

class cli_mesh_fields : public testing::Test {
 protected:
  static nlohmann::json done(Words words) {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  static void refused(const Words& words, const std::string& why) {
    const Finished run = run_lode(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  }

  Scratch scratch_;
};

/// A mesh without steps or a time.
std::string write_still(const std::string& path) {
  const TetraMesh noise = oracles::noise_mesh(5, oracles::Cut::in_six, 5);
  SimplexMesh mesh;
  mesh.positions = noise.positions;
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  Progress progress;
  EXPECT_TRUE(write_mesh(path, mesh, {.value_name = "noise"}, progress));
  return path;
}

TEST_F(cli_mesh_fields, of_medit_meshes_come_from_solutions) {
  const TetraMesh noise = oracles::noise_mesh(7, oracles::Cut::in_six, 5);
  std::string mesh = "MeshVersionFormatted 2\nDimension 3\nVertices\n";
  mesh += fmt::format("{}\n", noise.positions.size());
  for (const Vec3d& p : noise.positions) mesh += fmt::format("{} {} {} 0\n", p[0], p[1], p[2]);
  mesh += fmt::format("Tetrahedra\n{}\n", noise.tetrahedra.size());
  for (const auto& [a, b, c, d] : noise.tetrahedra)
    mesh += fmt::format("{} {} {} {} 4\n", a + 1, b + 1, c + 1, d + 1);
  const auto solution_of = [&](double factor) {
    std::string text = fmt::format(
        "MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{}\n2 1 2\n", noise.positions.size());
    for (std::size_t v = 0; v < noise.positions.size(); ++v) {
      const Vec3d& p = noise.positions[v];
      text += fmt::format("{} {} {} {}\n", factor * noise.fields[0].values[v], p[0], p[1], p[2]);
    }
    return text + "End\n";
  };
  const std::string medit = scratch_ / "room.mesh";
  std::ofstream(medit) << mesh;
  std::ofstream(scratch_ / "room.sol") << solution_of(1);
  std::ofstream(scratch_ / "later.sol") << solution_of(2);
  std::ofstream(scratch_ / "last.sol") << solution_of(3);
  const std::string model = scratch_ / "room.lode";
  const nlohmann::json built =
      done({"build", medit, model, "--field", "solution_1", "--with", "solution_2"});
  const double high = *std::ranges::max_element(noise.fields[0].values);
  EXPECT_EQ(built.at("fields")[0].at("range")[1], high);
  EXPECT_EQ(
      done({"build", medit, model, "--field", "solution_1", "--solution", scratch_ / "later.sol"})
          .at("range")[1],
      2 * high);
  done({"verify", model, "--against", medit, "--solution", scratch_ / "later.sol"});
  EXPECT_NE(run_lode({"verify", model, "--against", medit}).exit_code, 0);
  const std::string all = scratch_ / "all.lode";
  const nlohmann::json attached =
      done({"attach-field", model, medit, all, "--field", "solution_1", "--solution",
            (scratch_ / "room.sol") + "," + (scratch_ / "last.sol"), "--at", "1,3"});
  ASSERT_EQ(attached.at("fields").size(), 3U);
  EXPECT_EQ(attached.at("fields")[1].at("time"), 1);
  EXPECT_EQ(attached.at("fields")[2].at("range")[1], 3 * high);
  refused(
      {"build", write_still(scratch_ / "still.vtk"), model, "--solution", scratch_ / "room.sol"},
      "--solution: expected a MEDIT mesh");
  refused({"build", medit, model, "--field", "solution_1", "--solution", scratch_ / "absent.sol"},
          "absent.sol");
}

}  // namespace
}  // namespace lode::test
