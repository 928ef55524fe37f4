// Queries with tolerances in space, and in pixels, of meshes that know their space errors.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>

#include "lode/api/tetra_attachment.h"
#include "lode/api/tetra_dataset.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// A field that changes by 1 in a length of 1, and a little noise.
TetraMesh sloped_mesh() {
  TetraMesh mesh = oracles::noise_mesh(oracles::trials(17, 11), oracles::Cut::in_six, 4);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d& p = mesh.positions[v];
    double& value = mesh.fields[0].values[v];
    value = p[0] + 0.05 * std::sin(17 * p[1]) * std::cos(13 * p[2]) + 1e-3 * value;
  }
  return mesh;
}

class tetra_space_errors : public testing::TestWithParam<Placement> {
 protected:
  static TetraDataset built(const TetraMesh& mesh, bool has_world_errors) {
    Progress progress;
    auto dataset = TetraDataset::build(
        mesh, {.has_world_errors = has_world_errors, .placement = GetParam(), .threads = {2}},
        progress);
    EXPECT_TRUE(dataset);
    return std::move(*dataset);
  }
  static MeshReport extract(const TetraDataset& dataset, const Query& query, SimplexMesh& mesh) {
    Progress progress;
    const auto report = dataset.extract_mesh({.query = query}, mesh, progress);
    EXPECT_TRUE(report) << report.error().message;
    return report ? *report : MeshReport{};
  }
  static std::string path_of(const char* name) {
    return std::filesystem::temp_directory_path() /
           (name + std::to_string(::getpid()) + "_" + std::to_string(static_cast<int>(GetParam())) +
            ".lode");
  }
};

TEST_P(tetra_space_errors, end_refinement_where_values_are_near_their_place) {
  const TetraMesh mesh = sloped_mesh();
  const TetraDataset dataset = built(mesh, true);
  const TetraFieldInfo& field = dataset.describe().fields[0];
  ASSERT_TRUE(field.base_world_error);
  EXPECT_GT(*field.base_world_error, 0);
  std::uint64_t last = 0;
  for (const double tolerance : {1.0, 0.03, 0.01, 0.003, 0.0}) {
    SimplexMesh answer;
    const MeshReport report = extract(dataset, {.max_world_error = tolerance}, answer);
    EXPECT_EQ(report.max_error, std::numeric_limits<double>::infinity());
    ASSERT_TRUE(report.achieved_world_error);
    EXPECT_LE(*report.achieved_world_error, tolerance);
    EXPECT_GE(report.n_cells, last);
    last = report.n_cells;
    // Where the field changes by about 1 in a length of 1 both errors are about the same.
    EXPECT_LE(report.achieved_error, 2 * tolerance);
  }
  EXPECT_EQ(last, mesh.tetrahedra.size());
  SimplexMesh base;
  EXPECT_EQ(extract(dataset, {.max_world_error = 10}, base).n_cells,
            dataset.describe().n_base_cells);
}

TEST_P(tetra_space_errors, hold_beside_errors_of_the_field_and_in_foci) {
  const TetraDataset dataset = built(sloped_mesh(), true);
  SimplexMesh answer;
  const MeshReport both = extract(dataset, {.max_error = 0.002, .max_world_error = 0.01}, answer);
  EXPECT_LE(both.achieved_error, 0.002);
  EXPECT_LE(*both.achieved_world_error, 0.01);
  const MeshReport everywhere = extract(dataset, {.max_world_error = 0.003}, answer);
  const Box3d corner{{{0, 0, 0}}, {{0.2, 0.2, 0.2}}};
  const MeshReport in_box = extract(dataset, {.boxes = {corner}, .max_world_error = 0.003}, answer);
  EXPECT_LE(*in_box.achieved_world_error, 0.003);
  EXPECT_LT(in_box.n_cells, everywhere.n_cells);
  // Outside of it in space, too.
  const MeshReport outside = extract(
      dataset, {.boxes = {corner}, .max_world_error = 0.003, .max_error_outside = 0.03}, answer);
  EXPECT_GE(outside.n_cells, in_box.n_cells);
  EXPECT_LT(outside.n_cells, everywhere.n_cells);
  const MeshReport isovalue =
      extract(dataset, {.isovalues = {0.5}, .max_world_error = 0.003}, answer);
  EXPECT_LE(*isovalue.achieved_world_error, 0.003);
  EXPECT_LT(isovalue.n_cells, everywhere.n_cells);
}

TEST_P(tetra_space_errors, of_views_are_pixels) {
  const TetraDataset dataset = built(sloped_mesh(), true);
  View view{.camera = {}, .width = 400, .height = 300};
  view.camera.eye = {{0.5, -2, 0.5}};
  view.camera.target = {{0.5, 0.5, 0.5}};
  view.camera.up = {{0, 0, 1}};
  SimplexMesh answer;
  std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  for (const double pixels : {0.5, 2.0, 10.0}) {
    const MeshReport report = extract(dataset, {.view = view, .max_error_px = pixels}, answer);
    ASSERT_TRUE(report.achieved_px);
    EXPECT_LE(*report.achieved_px, pixels);
    EXPECT_LE(report.n_cells, last);
    last = report.n_cells;
  }
  EXPECT_LT(last, dataset.describe().n_cells / 2);
}

TEST_P(tetra_space_errors, of_files_are_those_of_memory_and_read_when_they_are_asked_for) {
  const TetraMesh mesh = sloped_mesh();
  const std::string path = path_of("lode_space_");
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(
      mesh, path, {.has_world_errors = true, .placement = GetParam(), .threads = {2}}, progress));
  const TetraDataset memory = built(mesh, true);
  const auto opened = TetraDataset::open(path);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->describe().fields[0].base_world_error,
            memory.describe().fields[0].base_world_error);
  SimplexMesh mine;
  SimplexMesh theirs;
  extract(*opened, {.max_error = 0}, mine);
  const std::uint64_t n_without = opened->reads().n_bytes;
  extract(*opened, {.max_world_error = 0.004}, mine);
  EXPECT_GT(opened->reads().n_bytes, n_without);
  extract(memory, {.max_world_error = 0.004}, theirs);
  EXPECT_EQ(mine.positions, theirs.positions);
  EXPECT_EQ(mine.tetrahedra, theirs.tetrahedra);
  // Checked as all else is.
  const auto verified = opened->verify({.n_random_cuts = 2}, progress);
  ASSERT_TRUE(verified);
  EXPECT_TRUE(verified->passed());
  EXPECT_EQ(std::ranges::count_if(
                verified->checks,
                [](const auto& check) { return check.name.starts_with("space errors there"); }),
            5);  // of the base, and at four shares of its error
  std::filesystem::remove(path);
}

TEST_P(tetra_space_errors, of_a_plateau_are_not_what_codes_round) {
  TetraMesh mesh = oracles::noise_mesh(13, oracles::Cut::in_six, 5);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    mesh.fields[0].values[v] = 0.1 + std::max(0.0, mesh.positions[v][0] - 0.5);
  const TetraDataset dataset = built(mesh, true);
  SimplexMesh answer;
  // Of a step of the grid half.
  const MeshReport report = extract(dataset, {.max_world_error = 0.04}, answer);
  EXPECT_LT(report.n_cells, mesh.tetrahedra.size() / 4);
}

TEST_P(tetra_space_errors, count_how_far_a_boundary_has_moved) {
  TetraMesh mesh = oracles::noise_mesh(11, oracles::Cut::in_six, 5);
  // Bent, so that no part of the boundary is flat; of one value.
  for (Vec3d& p : mesh.positions) p[2] += 0.3 * std::sin(3 * p[0]) * std::sin(3 * p[1]);
  std::ranges::fill(mesh.fields[0].values, 1.5);
  Progress progress;
  const auto dataset = TetraDataset::build(mesh,
                                           {.boundary_tolerance = 0.05,
                                            .has_world_errors = true,
                                            .placement = GetParam(),
                                            .threads = {2}},
                                           progress);
  ASSERT_TRUE(dataset);
  const TetraInfo& info = dataset->describe();
  EXPECT_GT(info.boundary_deviation, 0.005);
  ASSERT_TRUE(info.fields[0].base_world_error);
  EXPECT_GT(*info.fields[0].base_world_error, 0.002);
  // Of the tetrahedra that come, not of all there are: it may be more than the boundary moves.
  EXPECT_LT(*info.fields[0].base_world_error, 0.2);
}

TEST_P(tetra_space_errors, are_weighed_as_a_transfer_function_weighs_them) {
  const TetraDataset dataset = built(sloped_mesh(), true);
  SimplexMesh answer;
  const Query query{.opacity = {{0, 0.2}, {1, 1}}, .max_world_error = 0.02};
  const MeshReport report = extract(dataset, query, answer);
  ASSERT_TRUE(report.achieved_world_error);
  EXPECT_GT(*report.achieved_world_error, 0);
  EXPECT_LE(*report.achieved_world_error, 0.02);
}

TEST_P(tetra_space_errors, of_what_has_none_are_refused) {
  const TetraDataset dataset = built(sloped_mesh(), false);
  SimplexMesh answer;
  Progress progress;
  const auto report = dataset.extract_mesh({.query = {.max_world_error = 0.1}}, answer, progress);
  ASSERT_FALSE(report);
  EXPECT_TRUE(report.error().message.find("space errors") != std::string::npos);
  EXPECT_FALSE(dataset.extract_mesh({.query = {.max_world_error = -1}}, answer, progress));
}

INSTANTIATE_TEST_SUITE_P(placements, tetra_space_errors,
                         testing::Values(Placement::half_edge, Placement::midpoint));

}  // namespace
}  // namespace lode::test
