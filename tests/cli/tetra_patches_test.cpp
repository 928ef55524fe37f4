// Named patches of the boundary, through files and answers of the program.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <string>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// [0, 1]^3 with an inlet on the floor, round but for its cells, and an outlet, all of the top.
class cli_patches : public testing::Test {
 protected:
  void SetUp() override {
    const TetraMesh noise = oracles::noise_mesh(13, oracles::Cut::in_six, 5);
    SimplexMesh mesh;
    mesh.positions = noise.positions;
    mesh.values = noise.fields[0].values;
    mesh.tetrahedra = noise.tetrahedra;
    mesh.errors.assign(mesh.tetrahedra.size(), 0);
    mesh.patches = {{4, "inlet"}, {11, "outlet"}};
    for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell)
      for (std::uint32_t corner = 0; corner < 4; ++corner) add_side(cell, corner, mesh);
    Progress progress;
    ASSERT_TRUE(write_mesh(input_, mesh, {.value_name = "noise"}, progress));
  }
  void add_side(std::uint32_t cell, std::uint32_t corner, SimplexMesh& mesh) {
    const auto [a, b, c] = face_across(mesh.tetrahedra[cell], corner);
    const auto& p = mesh.positions;
    const Vec3d centre = (1.0 / 3) * (p[a] + p[b] + p[c]);
    const auto is_at = [&](double z) { return p[a][2] == z && p[b][2] == z && p[c][2] == z; };
    if (is_at(0) && std::hypot(centre[0] - 0.5, centre[1] - 0.5) < 0.3) {
      mesh.patch_sides.push_back({cell, corner, 0});
      inlet_area_ += length(cross(p[b] - p[a], p[c] - p[a])) / 2;
    } else if (is_at(1)) {
      mesh.patch_sides.push_back({cell, corner, 1});
    }
  }
  [[nodiscard]] nlohmann::json report(Words words) const {
    words.emplace_back("--json");
    const Finished run = run_lode(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.json();
  }
  /// VTK's, of a file of triangles or tetrahedra.
  [[nodiscard]] nlohmann::json measured(const std::string& path) const {
    return nlohmann::json::parse(run_oracle(LODE_MESH_ORACLE, path), nullptr, false);
  }

  Scratch scratch_;
  std::string input_ = scratch_ / "room.vtu";
  std::string model_ = scratch_ / "room.lode";
  double inlet_area_ = 0;
};

TEST_F(cli_patches, are_told_kept_and_cut_out) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  const nlohmann::json expected = {{{"id", 4}, {"name", "inlet"}},
                                   {{"id", 11}, {"name", "outlet"}}};
  EXPECT_EQ(report({"info", input_}).at("patches"), expected);
  EXPECT_EQ(report({"build", input_, model_}).at("patches"), expected);
  EXPECT_EQ(report({"info", model_}).at("patches"), expected);
  const std::string output = scratch_ / "out.vtp";
  for (const char* const error :
       oracles::trials<std::vector<const char*>>({"0", "0.1", "10"}, {"0", "10"})) {
    const auto area_of = [&](const Words& patches) {
      Words words{"extract", model_, output, "--boundary", "--max-error", error};
      words.insert(words.end(), patches.begin(), patches.end());
      static_cast<void>(report(words));
      return measured(output).at("size").get<double>();
    };
    EXPECT_NEAR(area_of({"--patch", "inlet"}), inlet_area_, 1e-5);
    EXPECT_NEAR(area_of({"--patch", "11"}), 1, 1e-5);
    EXPECT_NEAR(area_of({"--patch", "outlet", "--patch", "4"}), 1 + inlet_area_, 1e-5);
    EXPECT_NEAR(area_of({}), 6, 1e-5);
    EXPECT_EQ(measured(output).at("cell_data").at("PatchId").at("range"),
              nlohmann::json({0.0, 11.0}));
  }
}

TEST_F(cli_patches, come_with_meshes_of_either_placement) {
  for (const char* const placement : {"half-edge", "midpoint"}) {
    const std::string output = scratch_ / "out.msh";
    static_cast<void>(report(
        {"extract", input_, output, "--mesh", "--max-error", "0.2", "--placement", placement}));
    auto cells = read_cell_mesh(output, {});
    ASSERT_TRUE(cells) << cells.error().message;
    const auto made = to_tetrahedra(std::move(*cells), {});
    ASSERT_TRUE(made);
    ASSERT_EQ(made->mesh.patches.size(), 2U);
    EXPECT_EQ(made->mesh.patches[0], (BoundaryPatch{4, "inlet"}));
    double area = 0;
    for (const PatchFace& face : made->mesh.patch_faces) {
      const auto& p = made->mesh.positions;
      const auto& [a, b, c] = face.corners;
      if (face.patch == 0) area += length(cross(p[b] - p[a], p[c] - p[a])) / 2;
      EXPECT_NEAR(p[a][2], face.patch == 0 ? 0 : 1, 1e-6);
    }
    EXPECT_NEAR(area, inlet_area_, 1e-4);
  }
}

TEST_F(cli_patches, of_a_threshold_are_those_of_its_cells) {
  const std::string output = scratch_ / "out.vtu";
  const nlohmann::json made = report({"extract", input_, output, "--mesh", "--threshold", "0:10"});
  auto cells = read_cell_mesh(output, {});
  ASSERT_TRUE(cells);
  const auto read = to_tetrahedra(std::move(*cells), {});
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mesh.tetrahedra.size(), made.at("cells").get<std::size_t>());
  EXPECT_GT(read->mesh.patch_faces.size(), 0U);
  EXPECT_EQ(read->report.n_inner_faces, 0U);
  for (const PatchFace& face : read->mesh.patch_faces)
    for (const std::uint32_t v : face.corners)
      EXPECT_EQ(read->mesh.positions[v][2], face.patch == 0 ? 0 : 1);
}

TEST_F(cli_patches, without_faces_in_a_threshold_are_told_apart_from_thresholds_without_cells) {
  const auto warnings = [&](const Words& more) {
    Words words{"extract", input_, scratch_ / "out.vtp", "--boundary", "--quiet"};
    words.insert(words.end(), more.begin(), more.end());
    return report(words).at("warnings").dump();
  };
  EXPECT_NE(warnings({"--patch", "inlet", "--threshold", "100:101"}).find("no face of the patches"),
            std::string::npos);
  EXPECT_NE(warnings({"--threshold", "100:101"}).find("no cell of the cut lies in the threshold"),
            std::string::npos);
}

TEST_F(cli_patches, that_are_not_there_are_refused) {
  const std::string output = scratch_ / "out.vtp";
  expect_refusal(run_lode({"extract", input_, output, "--boundary", "--patch", "wall", "--quiet"}),
                 1, {"expected one of inlet, outlet, got wall"});
  expect_refusal(run_lode({"extract", input_, output, "--isovalue", "0", "--patch", "inlet"}), 2,
                 {"--patch", "--boundary"});
  EXPECT_FALSE(std::filesystem::exists(output));
}

}  // namespace
}  // namespace lode::test
