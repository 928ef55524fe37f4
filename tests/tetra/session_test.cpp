// Questions one after another, each answered from the cut of the last.

#include "lode/api/tetra_session.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"

namespace lode::test {
namespace {

using Cell = std::array<std::array<double, 3>, 4>;

std::multiset<Cell> cells_of(const SimplexMesh& mesh) {
  std::multiset<Cell> all;
  for (const auto& corners : mesh.tetrahedra) {
    Cell cell;
    for (std::size_t k = 0; k < 4; ++k) cell[k] = mesh.positions[corners[k]].v;
    std::ranges::sort(cell);
    all.insert(cell);
  }
  return all;
}

TetraMesh two_fields() {
  TetraMesh mesh = oracles::noise_mesh(15, oracles::Cut::in_six, 8);
  mesh.fields.push_back(oracles::noise_mesh(15, oracles::Cut::in_six, 9).fields[0]);
  mesh.fields[1].name = "other";
  for (const auto& t : mesh.tetrahedra)
    mesh.regions.push_back(mesh.positions[t[0]][2] < 0.5 ? 0 : 1);
  mesh.region_ids = {3, 5};
  return mesh;
}

class tetra_session : public testing::TestWithParam<Placement> {
 protected:
  tetra_session() {
    Progress progress;
    auto built = TetraDataset::build(
        two_fields(), {.has_world_errors = true, .placement = GetParam(), .threads = {2}},
        progress);
    EXPECT_TRUE(built);
    dataset_.emplace(std::move(*built));
  }
  /// Held against the answer from the base.
  void expect_same(TetraSession& session, const TetraMeshOptions& options) const {
    Progress progress;
    SimplexMesh mine;
    SimplexMesh theirs;
    const auto report = session.extract_mesh(options, mine, progress);
    const auto expected = dataset_->extract_mesh(options, theirs, progress);
    ASSERT_TRUE(report) << report.error().message;
    ASSERT_TRUE(expected);
    EXPECT_EQ(cells_of(mine), cells_of(theirs));
    EXPECT_EQ(report->achieved_error, expected->achieved_error);
    EXPECT_EQ(report->achieved_world_error, expected->achieved_world_error);
    EXPECT_EQ(report->n_cut_cells, expected->n_cut_cells);
    EXPECT_EQ(report->n_left_out, expected->n_left_out);
  }
  static TetraMeshOptions in_box(double at, double max_error) {
    const Box3d box{{{at, at, at}}, {{at + 0.3, at + 0.3, at + 0.3}}};
    return {.query = {.boxes = {box}, .max_error = max_error}};
  }

  std::optional<TetraDataset> dataset_;
};

TEST_P(tetra_session, answers_as_from_the_base) {
  TetraSession session(*dataset_);
  oracles::Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    TetraMeshOptions options = in_box(0.7 * random.uniform(), random.below(2) == 0 ? 0.0 : 0.2);
    switch (random.below(6)) {
      case 0: options.query.isovalues = {random.uniform()}; break;
      case 1: options.regions = {5}; break;
      case 2: options.query.max_error_outside = 0.5; break;
      case 3: options.fields.measured = 1; break;
      case 4: options.query.max_world_error = 0.1; break;
      default: break;
    }
    expect_same(session, options);
  }
}

TEST_P(tetra_session, takes_few_updates_to_the_next_question) {
  TetraSession session(*dataset_);
  Progress progress;
  SimplexMesh mesh;
  ASSERT_TRUE(session.extract_mesh(in_box(0.2, 0.05), mesh, progress));
  const std::uint64_t first = session.n_updates();
  EXPECT_GT(first, 100U);
  ASSERT_TRUE(session.extract_mesh(in_box(0.2, 0.05), mesh, progress));
  EXPECT_EQ(session.n_updates(), first);
  ASSERT_TRUE(session.extract_mesh(in_box(0.22, 0.05), mesh, progress));
  EXPECT_LT(session.n_updates() - first, first / 2);
  // And back, with what other kinds of answers took in between.
  Surface surface;
  ASSERT_TRUE(session.extract_surface({.query = {.isovalues = {0.5}, .max_error = 0.1}}, surface,
                                      progress));
  EXPECT_FALSE(surface.is_empty());
  expect_same(session, in_box(0.2, 0.05));
}

TEST_P(tetra_session, goes_on_after_what_was_refused_or_cancelled) {
  TetraSession session(*dataset_);
  Progress progress;
  SimplexMesh mesh;
  EXPECT_FALSE(session.extract_mesh({.query = {.max_error = -1}}, mesh, progress));
  expect_same(session, in_box(0.1, 0.1));
  Progress cancelled;
  cancelled.cancel();
  EXPECT_FALSE(session.extract_mesh(in_box(0.5, 0.0), mesh, cancelled));
  expect_same(session, in_box(0.1, 0.1));
  EXPECT_TRUE(
      session.extract_mesh({.query = {.max_error = 0.0}, .deadline_s = 0.0}, mesh, progress));
  expect_same(session, in_box(0.3, 0.05));
}

TEST_P(tetra_session, of_a_file_reads_what_is_new) {
  const std::string path = std::filesystem::temp_directory_path() /
                           ("lode_session_" + std::to_string(::getpid()) + "_" +
                            std::to_string(static_cast<int>(GetParam())) + ".lode");
  Progress progress;
  ASSERT_TRUE(TetraDataset::build_file(two_fields(), path,
                                       {.placement = GetParam(), .threads = {2}}, progress));
  const auto opened = TetraDataset::open(path);
  ASSERT_TRUE(opened);
  TetraSession session(*opened);
  SimplexMesh mesh;
  ASSERT_TRUE(session.extract_mesh(in_box(0.2, 0.05), mesh, progress));
  const std::uint64_t n_read = opened->reads().n_bytes;
  ASSERT_TRUE(session.extract_mesh(in_box(0.2, 0.05), mesh, progress));
  EXPECT_EQ(opened->reads().n_bytes, n_read);
  std::filesystem::remove(path);
}

INSTANTIATE_TEST_SUITE_P(placements, tetra_session,
                         testing::Values(Placement::half_edge, Placement::midpoint));

}  // namespace
}  // namespace lode::test
