// Questions one after another, each answered from the cut of the last.

#include "lode/api/tetra_session.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/oracles/random.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

/// Bit for bit.
void expect_equal(const SimplexMesh& a, const SimplexMesh& b) {
  const auto places = [](const SimplexMesh& mesh) {
    std::vector<std::array<double, 3>> all;
    for (const Vec3d& p : mesh.positions) all.push_back(p.v);
    return all;
  };
  const auto sides = [](const SimplexMesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> all;
    for (const PatchSide& side : mesh.patch_sides)
      all.push_back({side.cell, side.corner, side.patch});
    return all;
  };
  EXPECT_EQ(places(a), places(b));
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.tetrahedra, b.tetrahedra);
  EXPECT_EQ(a.regions, b.regions);
  EXPECT_EQ(a.errors, b.errors);
  EXPECT_EQ(sides(a), sides(b));
  ASSERT_EQ(a.attributes.size(), b.attributes.size());
  for (std::size_t i = 0; i < a.attributes.size(); ++i) {
    EXPECT_EQ(a.attributes[i].values, b.attributes[i].values);
    EXPECT_EQ(a.attributes[i].errors, b.attributes[i].errors);
  }
}

void add_patch(TetraMesh& mesh) {
  mesh.patches = {{4, "front"}};
  for (const auto& t : mesh.tetrahedra)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto face = face_across(t, corner);
      if (std::ranges::all_of(face, [&](std::uint32_t v) { return mesh.positions[v][0] == 0; }))
        mesh.patch_faces.push_back({face, 0});
    }
}

TetraMesh two_fields() {
  TetraMesh mesh = oracles::noise_mesh(15, oracles::Cut::in_six, 8);
  mesh.fields.push_back(oracles::noise_mesh(15, oracles::Cut::in_six, 9).fields[0]);
  mesh.fields[1].name = "other";
  for (const auto& t : mesh.tetrahedra)
    mesh.regions.push_back(mesh.positions[t[0]][2] < 0.5 ? 0 : 1);
  mesh.region_ids = {3, 5};
  add_patch(mesh);
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
    expect_equal(mine, theirs);
    EXPECT_FALSE(mine.patch_sides.empty());
    EXPECT_EQ(report->achieved_error, expected->achieved_error);
    EXPECT_EQ(report->largest_error, expected->largest_error);
    EXPECT_EQ(report->achieved_world_error, expected->achieved_world_error);
    EXPECT_EQ(report->achieved_px, expected->achieved_px);
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
  for (int trial = 0; trial < oracles::trials(30, 12); ++trial) {
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

TEST_P(tetra_session, follows_a_camera) {
  TetraSession session(*dataset_);
  oracles::Random random(2);
  for (int trial = 0; trial < oracles::trials(24, 10); ++trial) {
    TetraMeshOptions options{.query = {.max_error = random.below(2) == 0 ? 0.0 : 0.1}};
    options.fields.along = {1};
    Query& query = options.query;
    const Vec3d eye{{random.uniform(-1, 2), random.uniform(-1, 2), random.uniform(-1, 2)}};
    query.view = View{{.eye = eye, .target = {{0.5, 0.5, 0.5}}, .field_of_view_deg = 25}, 64, 48};
    switch (random.below(5)) {
      case 0: query.isovalues = {random.uniform()}; break;
      case 1: query.budget.max_cells = 2000 + random.below(6000); break;
      case 2: query.max_error_outside = 0.5; break;
      case 3: query.opacity = {{0.0, 0.0}, {0.5, 2.0}}; break;
      default: query.max_error_px = 1 + static_cast<double>(random.below(5)); break;
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
