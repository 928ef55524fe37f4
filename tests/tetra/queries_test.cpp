// Queries of TetraDataset: what a camera shows, and what is ready in time.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <string>

#include "lode/api/tetra_dataset.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

/// A cell by its corners' positions, in order.
using CellKey = std::array<std::array<double, 3>, 4>;

CellKey key_of(const std::vector<Vec3d>& positions, const std::array<std::uint32_t, 4>& cell) {
  CellKey key;
  for (std::size_t i = 0; i < 4; ++i) key[i] = positions[cell[i]].v;
  std::ranges::sort(key);
  return key;
}

class tetra_queries : public testing::Test {
 protected:
  static TetraDataset build(const TetraMesh& mesh) {
    Progress progress;
    auto dataset = TetraDataset::build(mesh, {.threads = {2}}, progress);
    EXPECT_TRUE(dataset);
    return std::move(*dataset);
  }
  [[nodiscard]] MeshReport extract(const TetraMeshOptions& options) {
    Progress progress;
    const auto report = dataset_.extract_mesh(options, cut_, progress);
    EXPECT_TRUE(report) << report.error().message;
    return report ? *report : MeshReport{};
  }

  TetraMesh mesh_ = oracles::noise_mesh(17, oracles::Cut::in_five, 3);
  TetraDataset dataset_ = build(mesh_);
  SimplexMesh cut_;
};

/// From outside into a corner of the cube.
View corner_view() {
  View view;
  view.camera.eye = {{-1, -1, -1}};
  view.camera.target = {{0.1, 0.1, 0.3}};
  view.camera.field_of_view_deg = 10;
  view.width = view.height = 100;
  return view;
}

TEST_F(tetra_queries, all_that_a_camera_shows_is_the_reference) {
  TetraMeshOptions options;
  options.query.view = corner_view();
  options.query.max_error = 0;
  const MeshReport report = extract(options);
  EXPECT_EQ(report.achieved_error, 0);
  EXPECT_LT(cut_.n_cells(), mesh_.tetrahedra.size());
  std::set<CellKey> cells;
  for (const auto& cell : cut_.tetrahedra) cells.insert(key_of(cut_.positions, cell));
  const ViewFocus seen = to_view_focus(corner_view());
  std::size_t n_seen = 0;
  for (const auto& cell : mesh_.tetrahedra) {
    const bool is_seen = std::ranges::any_of(cell, [&](std::uint32_t v) {
      return seen.shows({mesh_.positions[v], 0});
    });
    if (!is_seen) continue;
    ++n_seen;
    ASSERT_TRUE(cells.contains(key_of(mesh_.positions, cell)));
  }
  EXPECT_GT(n_seen, 100);
}

TEST_F(tetra_queries, what_is_out_of_sight_has_its_own_tolerance) {
  TetraMeshOptions options;
  options.query.view = corner_view();
  options.query.max_error = 0.01;
  const MeshReport any = extract(options);
  EXPECT_LE(any.achieved_error, 0.01);
  EXPECT_GT(any.largest_error, 0.2);
  options.query.max_error_outside = 0.2;
  const MeshReport some = extract(options);
  EXPECT_LE(some.achieved_error, 0.01);
  EXPECT_LE(some.largest_error, 0.2);
  EXPECT_GT(some.n_cells, any.n_cells);
}

TEST_F(tetra_queries, what_is_out_of_focus_has_its_own_tolerance) {
  TetraMeshOptions options;
  options.query.boxes = {{{{0.1, 0.1, 0.1}}, {{0.3, 0.3, 0.3}}}};
  options.query.max_error = 0.01;
  options.query.max_error_outside = 0.2;
  const MeshReport report = extract(options);
  EXPECT_LE(report.achieved_error, 0.01);
  EXPECT_GT(report.largest_error, 0.01);
  EXPECT_LE(report.largest_error, 0.2);
  // Cells that meet the box state no more than is achieved.
  for (std::size_t i = 0; i < cut_.n_cells(); ++i) {
    const auto is_in = [&](std::uint32_t v) {
      return std::ranges::all_of(cut_.positions[v].v,
                                 [](double x) { return 0.1 <= x && x <= 0.3; });
    };
    if (std::ranges::any_of(cut_.tetrahedra[i], is_in))
      EXPECT_LE(static_cast<double>(cut_.errors[i]), report.achieved_error);
  }
}

TEST_F(tetra_queries, a_deadline_gives_what_is_ready) {
  TetraMeshOptions options;
  options.deadline_s = 0;
  const MeshReport base = extract(options);
  EXPECT_FALSE(base.is_settled);
  EXPECT_EQ(base.n_cells, dataset_.describe().n_base_cells);
  EXPECT_EQ(base.max_error, 0);
  options.deadline_s = 1e6;
  const MeshReport all = extract(options);
  EXPECT_TRUE(all.is_settled);
  EXPECT_EQ(all.n_cells, mesh_.tetrahedra.size());
  EXPECT_EQ(all.achieved_error, 0);
}

/// What nodes there are below the base is in pages, which take longer than a deadline may last.
TEST_F(tetra_queries, a_deadline_of_a_file_does_not_wait_for_pages_and_knows_the_base) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("lode_deadline_" + std::to_string(::getpid()) + ".lode");
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(mesh_, path, {.threads = {2}}, progress));
  const auto read_for = [&](const TetraMeshOptions& options, MeshReport& report) {
    const auto opened = TetraDataset::open(path);
    EXPECT_TRUE(opened);
    const auto made = opened->extract_mesh(options, cut_, progress);
    EXPECT_TRUE(made) << made.error().message;
    report = *made;
    return opened->reads().n_bytes;
  };
  MeshReport late;
  MeshReport base;
  const double base_error = dataset_.describe().fields.front().base_error;
  const std::uint64_t n_late = read_for({.deadline_s = 0}, late);
  const SimplexMesh late_mesh = std::move(cut_);
  const std::uint64_t n_base = read_for({.query = {.max_error = 2 * base_error}}, base);
  const SimplexMesh base_mesh = std::move(cut_);
  MeshReport fine;
  const std::uint64_t n_fine = read_for({.query = {.max_error = 0.5 * base_error}}, fine);
  std::filesystem::remove(path);
  EXPECT_FALSE(late.is_settled);
  EXPECT_EQ(late.n_cells, base.n_cells);
  EXPECT_EQ(late.achieved_error, base_error);
  // What its cells wait for is said with them.
  EXPECT_EQ(late_mesh.errors, base_mesh.errors);
  EXPECT_EQ(n_late, n_base);
  EXPECT_LT(n_base, n_fine);
}

/// Cells whose pages were not read state no more than what is known of all.
TEST_F(tetra_queries, a_deadline_of_a_file_states_of_no_cell_more_than_of_all) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("lode_deadlines_" + std::to_string(::getpid()) + ".lode");
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(mesh_, path, {.threads = {2}}, progress));
  for (const double deadline_ms : {0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 8.0, 20.0}) {
    const auto opened = TetraDataset::open(path);
    ASSERT_TRUE(opened);
    const auto report = opened->extract_mesh({.deadline_s = 1e-3 * deadline_ms}, cut_, progress);
    ASSERT_TRUE(report);
    // Those of nodes are stored rounded up.
    EXPECT_LE(report->largest_error, 1.01 * report->achieved_error) << deadline_ms;
  }
  std::filesystem::remove(path);
}

/// Errors of cells are in pages that nothing else has asked for: there is time to read them.
TEST_F(tetra_queries, a_deadline_of_a_file_that_leaves_time_changes_nothing) {
  const auto path = std::filesystem::temp_directory_path() /
                    ("lode_time_left_" + std::to_string(::getpid()) + ".lode");
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(mesh_, path, {.threads = {2}}, progress));
  const auto extract_new = [&](TetraMeshOptions options, std::optional<double> deadline_s) {
    options.deadline_s = deadline_s;
    const auto opened = TetraDataset::open(path);
    EXPECT_TRUE(opened);
    return opened->extract_mesh(options, cut_, progress).value();
  };
  const double base_error = dataset_.describe().fields.front().base_error;
  for (const double share : {0.8, 0.5, 0.2, 0.05}) {
    TetraMeshOptions options;
    options.query.max_error = share * base_error;
    const MeshReport expected = extract_new(options, {});
    const SimplexMesh mesh = std::move(cut_);
    const MeshReport report = extract_new(options, 1e6);
    EXPECT_EQ(report.achieved_error, expected.achieved_error);
    EXPECT_EQ(report.max_error, expected.max_error);
    EXPECT_EQ(cut_.errors, mesh.errors);
    EXPECT_LE(report.achieved_error, *options.query.max_error);
  }
  std::filesystem::remove(path);
}

TEST_F(tetra_queries, refuses_pixels_and_deadlines_that_are_none) {
  Progress progress;
  TetraMeshOptions options;
  options.query.view = corner_view();
  options.query.max_error_px = 1;
  EXPECT_FALSE(dataset_.extract_mesh(options, cut_, progress));
  options = {};
  options.deadline_s = -1;
  EXPECT_FALSE(dataset_.extract_mesh(options, cut_, progress));
}

}  // namespace
}  // namespace lode::test
