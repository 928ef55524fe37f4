// `lode verify` of meshes of tetrahedra, and of files made from them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "lode/api/files.h"
#include "tests/cli/program.h"
#include "tests/io/vtk_oracle.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

class cli_verify_tetra : public testing::Test {
 protected:
  cli_verify_tetra() {
    write(mesh_, 3);
    write(other_, 4);
    const auto cells = read_cell_mesh(mesh_, {});
    EXPECT_TRUE(cells);
    const auto made = to_tetrahedra(CellMesh(*cells), {});
    EXPECT_TRUE(made);
    Progress progress;
    EXPECT_TRUE(TetraDataset::build_file(made->mesh, lode_, {}, progress));
  }
  static void write(const std::string& path, std::uint64_t seed) {
    const TetraMesh noise = oracles::noise_mesh(9, oracles::Cut::in_five, seed);
    SimplexMesh mesh;
    mesh.positions = noise.positions;
    mesh.values = noise.fields[0].values;
    mesh.tetrahedra = noise.tetrahedra;
    mesh.errors.assign(mesh.tetrahedra.size(), 0);
    Progress progress;
    EXPECT_TRUE(write_vtu(path, mesh, {.value_name = "noise"}, progress));
  }

  Scratch scratch_;
  std::string mesh_ = scratch_ / "noise.vtu";
  std::string other_ = scratch_ / "other.vtu";
  std::string lode_ = scratch_ / "noise.lode";
};

TEST_F(cli_verify_tetra, passes_what_was_made_from_the_original) {
  const Finished file = run_lode({"verify", lode_, "--against", mesh_});
  EXPECT_EQ(file.exit_code, 0) << file.err;
  EXPECT_EQ(file.err, "");
  const Finished built = run_lode({"verify", mesh_, "--json"});
  EXPECT_EQ(built.exit_code, 0) << built.err;
  EXPECT_NE(built.err.find("building its hierarchy in memory"), std::string::npos);
  const Finished machine = run_lode({"verify", lode_, "--original", mesh_, "--json"});
  EXPECT_EQ(machine.err, "");
  const nlohmann::json json = machine.json();
  EXPECT_EQ(json.at("passed"), true);
  EXPECT_EQ(json.at("against"), mesh_);
  // Every byte before, the original after what is checked of any hierarchy.
  EXPECT_EQ(json.at("checks").size(), built.json().at("checks").size() + 3);
  EXPECT_EQ(json.at("checks")[0].at("name"), "every byte of the file");
  for (const auto& check : json.at("checks")) EXPECT_EQ(check.at("passed"), true);
}

/// What the reader in Python, which was written from the document, says of a file and the mesh.
std::string read_in_python(const std::string& model, const std::string& mesh) {
  return run_oracle(LODE_TETRA_READER, "'" + model + "' '" + mesh + "'");
}

TEST_F(cli_verify_tetra, is_read_from_the_format_document_alone) {
  ASSERT_TRUE(has_vtk()) << kVtkMissing;
  const std::string said = read_in_python(lode_, mesh_);
  const nlohmann::json info = run_lode({"info", lode_, "--json"}).json();
  EXPECT_EQ(said, fmt::format("vertices 729 cells 2560 nodes {}\n", info.at("nodes").get<int>()));
  EXPECT_EQ(read_in_python(lode_, other_), "noise: other values\n");
  const std::string lean = lode_ + ".lean.lode";
  ASSERT_EQ(run_lode({"build", mesh_, lean, "--field", "noise", "--lean"}).exit_code, 0);
  EXPECT_EQ(run_oracle(LODE_TETRA_READER, "'" + lean + "'").find("lean vertices 729 cells 2560 "),
            0U);
  std::filesystem::remove(lean);
  // Regions, more pages, vertices of a base of more than a page, and an extent about zero.
  SimplexMesh mesh;
  TetraMesh noise = oracles::noise_mesh(12, oracles::Cut::in_six, 5);
  for (Vec3d& p : noise.positions) p = p - Vec3d{{0.5, 0.5, 0.5}};
  mesh.positions = noise.positions;
  mesh.values = noise.fields[0].values;
  mesh.tetrahedra = noise.tetrahedra;
  mesh.errors.assign(mesh.tetrahedra.size(), 0);
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i)
    mesh.regions.push_back(i < mesh.tetrahedra.size() / 2 ? -7 : 40);
  // Two patches of the floor.
  mesh.patches = {{-3, "inlet"}, {12, ""}};
  for (std::uint32_t cell = 0; cell < mesh.tetrahedra.size(); ++cell)
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const auto face = face_across(mesh.tetrahedra[cell], corner);
      const auto at = [&](std::size_t i, std::size_t axis) {
        return mesh.positions[face[i]][axis];
      };
      if (at(0, 2) == -0.5 && at(1, 2) == -0.5 && at(2, 2) == -0.5)
        mesh.patch_sides.push_back({cell, corner, at(0, 0) + at(1, 0) + at(2, 0) < 0 ? 0U : 1U});
    }
  Attribute waves{.name = "waves", .values = {}};
  for (const Vec3d& p : mesh.positions) waves.values.push_back(std::sin(9 * p[0] + p[1]) / 3);
  waves.errors.assign(mesh.tetrahedra.size(), 0);
  mesh.attributes = {waves};
  Progress progress;
  ASSERT_TRUE(write_vtu(mesh_, mesh, {.value_name = "noise"}, progress));
  const Words plain{"--field", "noise"};
  const Words full{"--field", "noise", "--with", "waves", "--space-errors"};
  const std::string half_edge = "half-edge";
  const std::string midpoint = "midpoint";
  using Builds = std::vector<std::tuple<std::string, std::string, Words>>;
  for (const auto& [n_base, placement, fields] :
       oracles::trials(Builds{{"100", half_edge, full},
                              {"100", half_edge, plain},
                              {"100", midpoint, plain},
                              {"100", midpoint, full},
                              {"4000", half_edge, full},
                              {"4000", half_edge, plain},
                              {"4000", midpoint, plain},
                              {"4000", midpoint, full}},
                       Builds{{"100", half_edge, full},
                              {"100", midpoint, plain},
                              {"4000", half_edge, plain},
                              {"4000", midpoint, full}})) {
    Words build{"build", mesh_, lode_, "--base-cells", n_base, "--placement", placement};
    build.insert(build.end(), fields.begin(), fields.end());
    ASSERT_EQ(run_lode(build).exit_code, 0);
    const std::string read =
        placement == midpoint ? run_oracle(LODE_MIDPOINT_READER, "'" + lode_ + "' '" + mesh_ + "'")
                              : read_in_python(lode_, mesh_);
    EXPECT_TRUE(read.starts_with("vertices 1728 cells 7986 nodes ")) << read;
  }
}

TEST_F(cli_verify_tetra, finds_errors_of_all_points_where_they_are_promised) {
  const std::string model = scratch_ / "everywhere.lode";
  const Finished build = run_lode({"build", mesh_, model, "--everywhere", "--json"});
  ASSERT_EQ(build.exit_code, 0) << build.err;
  EXPECT_EQ(build.json().at("error_kind"), "everywhere");
  const nlohmann::json at_samples = run_lode({"info", lode_, "--json"}).json();
  EXPECT_EQ(at_samples.at("error_kind"), "at samples");
  EXPECT_GE(build.json().at("base_error"), at_samples.at("base_error"));
  for (const std::string& file : {model, lode_}) {
    const Finished verify = run_lode({"verify", file, "--exact", "--json"});
    EXPECT_EQ(verify.exit_code, 0) << verify.err;
    const nlohmann::json checks = verify.json().at("checks");
    EXPECT_EQ(std::ranges::count_if(checks,
                                    [&](const auto& check) {
                                      return check.at("name") ==
                                             (file == model
                                                  ? "errors everywhere <= stored errors"
                                                  : "errors everywhere, which are not stored");
                                    }),
              1);
  }
  EXPECT_EQ(run_lode({"build", mesh_, scratch_ / "no.lode", "--everywhere", "--boundary-tolerance",
                      "0.1"})
                .exit_code,
            2);
  // What is proven of an integral is closer, by far.
  const auto width = [&](const std::string& file) {
    const auto integral = run_lode({"probe", file, "--integral", "--max-error", "0.3", "--json"})
                              .json()
                              .at("integral");
    return integral.at("high").get<double>() - integral.at("low").get<double>();
  };
  EXPECT_LT(width(model), 0.5 * width(lode_));
}

/// Errors, volumes and boundaries are held against what the model says that its boundary may do.
TEST_F(cli_verify_tetra, passes_boundaries_that_move_as_far_as_the_model_says) {
  SimplexMesh ball;
  TetraMesh noise = oracles::noise_mesh(12, oracles::Cut::in_six, 7);
  for (Vec3d& p : noise.positions) {
    const Vec3d d = p - Vec3d{{0.5, 0.5, 0.5}};
    const double most = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    p = length(d) > 0 ? d * (most / length(d)) : d;
  }
  ball.positions = noise.positions;
  ball.values = noise.fields[0].values;
  ball.tetrahedra = noise.tetrahedra;
  ball.errors.assign(ball.tetrahedra.size(), 0);
  const std::string mesh = scratch_ / "ball.vtu";
  Progress progress;
  ASSERT_TRUE(write_vtu(mesh, ball, {.value_name = "noise"}, progress));
  for (const char* const tolerance : {"0.004", "0.03"}) {
    const std::string model = scratch_ / "ball.lode";
    const Finished build =
        run_lode({"build", mesh, model, "--boundary-tolerance", tolerance, "--json"});
    ASSERT_EQ(build.exit_code, 0) << build.err;
    EXPECT_GT(build.json().at("boundary_deviation"), 0.001);
    const Finished verify = run_lode({"verify", model, "--against", mesh});
    EXPECT_EQ(verify.exit_code, 0) << verify.out << verify.err;
  }
}

TEST_F(cli_verify_tetra, fails_against_other_data) {
  const Finished run = run_lode({"verify", lode_, "--against", other_});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("vertices and values equal the original's"), std::string::npos) << run.err;
}

TEST_F(cli_verify_tetra, fails_on_flipped_bytes) {
  const std::string bytes = read_bytes(lode_);
  for (std::size_t at = 16; at < bytes.size(); at += bytes.size() / 11) {
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x10);
    write_bytes(scratch_ / "flipped.lode", flipped);
    const Finished run = run_lode({"verify", scratch_ / "flipped.lode"});
    EXPECT_EQ(run.exit_code, 1) << "byte " << at;
    EXPECT_NE(run.err.find("flipped.lode"), std::string::npos) << run.err;
  }
}

/// A tetrahedron with three edges of that length along the axes.
SimplexMesh corner_of(double width) {
  SimplexMesh mesh;
  mesh.positions = {{{0, 0, 0}}, {{width, 0, 0}}, {{0, width, 0}}, {{0, 0, width}}};
  mesh.values = {0, 1, 2, 3};
  mesh.tetrahedra = {{{0, 1, 2, 3}}};
  mesh.errors = {0};
  return mesh;
}

TEST_F(cli_verify_tetra, passes_meshes_that_are_a_point_or_nearly_one) {
  for (const double width : {0.0, 1e-100}) {
    Progress progress;
    ASSERT_TRUE(write_vtu(mesh_, corner_of(width), {.value_name = "noise"}, progress));
    const Finished run = run_lode({"verify", mesh_});
    EXPECT_EQ(run.exit_code, 0) << run.err;
  }
}

TEST_F(cli_verify_tetra, refuses_meshes_so_small_that_volumes_vanish) {
  Progress progress;
  ASSERT_TRUE(write_vtu(mesh_, corner_of(1e-300), {.value_name = "noise"}, progress));
  const std::string model = scratch_ / "small.lode";
  expect_refusal(run_lode({"build", mesh_, model}), 1, {mesh_, "1e-101 across or more", "1e-300"});
  EXPECT_NE(run_lode({"verify", mesh_}).exit_code, 0);
}

TEST_F(cli_verify_tetra, refuses_what_does_not_go_with_meshes) {
  EXPECT_EQ(run_lode({"verify", lode_, "--surface", "a.ply", "--isovalue", "0"}).exit_code, 2);
  EXPECT_EQ(run_lode({"verify", lode_, "--against", lode_}).exit_code, 2);
  EXPECT_EQ(run_lode({"verify", lode_, "--field", "noise"}).exit_code, 2);
  expect_refusal(run_lode({"verify", lode_, "--memory-limit", "1M"}), 2,
                 {"--memory-limit", "expected a volume, got a mesh of cells", lode_});
  expect_refusal(run_lode({"extract", lode_, scratch_ / "out.vtu", "--mesh", "--salvage"}), 2,
                 {"--salvage", "mesh of cells"});
  EXPECT_EQ(run_lode({"verify", mesh_, "--nodata", "1"}).exit_code, 2);
}

}  // namespace
}  // namespace lode::test
