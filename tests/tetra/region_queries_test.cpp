// Queries of TetraDataset for some regions alone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lode/api/tetra_dataset.h"
#include "tests/oracles/tetra_grids.h"
#include "tests/oracles/trials.h"

namespace lode::test {
namespace {

using Corners = std::array<std::array<double, 3>, 4>;

std::multiset<Corners> corners_of(const std::vector<Vec3d>& positions,
                                  const std::vector<std::array<std::uint32_t, 4>>& cells) {
  std::multiset<Corners> all;
  for (const auto& cell : cells) {
    Corners corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = positions[cell[i]].v;
    std::ranges::sort(corners);
    all.insert(corners);
  }
  return all;
}

double volume_of(const std::vector<Vec3d>& p, const std::array<std::uint32_t, 4>& t) {
  return dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[3]] - p[t[0]]) / 6;
}

/// Noise in [0, 1]^3; in a corner of it, a quarter wide, region 9, and beside that two more.
TetraMesh noise_with_corner() {
  TetraMesh mesh = oracles::noise_mesh(25, oracles::Cut::in_six, 11);
  for (const auto& t : mesh.tetrahedra) {
    Vec3d centre;
    for (const std::uint32_t v : t) centre = centre + mesh.positions[v] * 0.25;
    const bool is_corner = std::ranges::max(centre.v) < 0.25;
    mesh.regions.push_back(is_corner ? 2 : centre[2] < 0.5 ? 0 : 1);
  }
  mesh.region_ids = {1, 4, 9};
  return mesh;
}

class tetra_region_queries : public testing::TestWithParam<Placement> {
 protected:
  tetra_region_queries() {
    Progress progress;
    auto built = TetraDataset::build(mesh_, {.placement = GetParam(), .threads = {2}}, progress);
    EXPECT_TRUE(built);
    memory_.emplace(std::move(*built));
  }
  ~tetra_region_queries() override { std::filesystem::remove(path_); }

  static MeshReport extract(const TetraDataset& dataset, const TetraMeshOptions& options,
                            SimplexMesh& mesh) {
    Progress progress;
    const auto report = dataset.extract_mesh(options, mesh, progress);
    EXPECT_TRUE(report) << report.error().message;
    return report ? *report : MeshReport{};
  }
  static double share_of(std::uint64_t n, std::uint64_t all) {
    return static_cast<double>(n) / static_cast<double>(all);
  }
  /// Of the cells that are refined for a sixty-fourth of them: midpoints wait for all vertices
  /// beside them with larger labels.
  static double most_share() { return GetParam() == Placement::midpoint ? 0.65 : 0.5; }
  void save() const {
    Progress progress;
    const auto report =
        TetraDataset::build_file(mesh_, path_, {.placement = GetParam(), .threads = {2}}, progress);
    ASSERT_TRUE(report) << report.error().message;
  }
  [[nodiscard]] TetraDataset opened() const {
    auto dataset = TetraDataset::open(path_);
    EXPECT_TRUE(dataset);
    return std::move(*dataset);
  }
  /// Of the reference.
  [[nodiscard]] std::vector<std::array<std::uint32_t, 4>> cells_of(std::uint32_t region) const {
    std::vector<std::array<std::uint32_t, 4>> cells;
    for (std::size_t i = 0; i < mesh_.tetrahedra.size(); ++i)
      if (mesh_.regions[i] == region) cells.push_back(mesh_.tetrahedra[i]);
    return cells;
  }

  TetraMesh mesh_ = noise_with_corner();
  std::string path_ = std::filesystem::temp_directory_path() /
                      ("lode_region_queries_" + std::to_string(::getpid()) + "_" +
                       std::to_string(static_cast<int>(GetParam())) + ".lode");
  std::optional<TetraDataset> memory_;
};

/// Cells that fill a region, whose faces are of two at most.
void expect_mesh_of(const SimplexMesh& mesh, double volume) {
  double sum = 0;
  std::map<std::array<std::uint32_t, 3>, int> faces;
  for (const auto& t : mesh.tetrahedra) {
    const double of = volume_of(mesh.positions, t);
    EXPECT_GT(of, 0);
    sum += of;
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<std::uint32_t, 3> face{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
      std::ranges::sort(face);
      ++faces[face];
    }
  }
  EXPECT_NEAR(sum, volume, 1e-12);
  for (const auto& [face, n] : faces) EXPECT_LE(n, 2);
  // The rim is the region's: in planes at 0 and 0.25.
  for (const auto& [face, n] : faces) {
    if (n == 2) continue;
    const auto is_in_plane = [&](std::size_t axis, double at) {
      return std::ranges::all_of(
          face, [&](std::uint32_t v) { return std::abs(mesh.positions[v][axis] - at) < 1e-12; });
    };
    bool is_at_rim = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      is_at_rim = is_at_rim || is_in_plane(axis, 0) || is_in_plane(axis, 0.25);
    EXPECT_TRUE(is_at_rim);
  }
}

TEST_P(tetra_region_queries, keep_the_tolerance_in_the_region_with_less_beside_it) {
  for (const double tolerance :
       oracles::trials<std::vector<double>>({0.5, 0.1, 0.02, 0.0}, {0.5, 0.0})) {
    SimplexMesh all;
    SimplexMesh kept;
    const MeshReport whole = extract(*memory_, {.query = {.max_error = tolerance}}, all);
    const MeshReport report =
        extract(*memory_, {.query = {.max_error = tolerance}, .regions = {9}}, kept);
    EXPECT_LE(report.achieved_error, tolerance);
    EXPECT_LE(report.largest_error, report.achieved_error);
    for (const float error : kept.errors) EXPECT_LE(static_cast<double>(error), tolerance);
    for (const std::int64_t region : kept.regions) EXPECT_EQ(region, 9);
    expect_mesh_of(kept, 0x1p-6);
    if (tolerance < 0.3) {
      EXPECT_LT(share_of(report.n_cut_cells, whole.n_cut_cells), most_share()) << tolerance;
    }
    EXPECT_EQ(report.n_cells + report.n_left_out, report.n_cut_cells);
  }
}

TEST_P(tetra_region_queries, at_no_tolerance_are_the_references_cells) {
  for (const std::uint32_t region :
       oracles::trials<std::vector<std::uint32_t>>({0, 1, 2}, {1, 2})) {
    SimplexMesh kept;
    const MeshReport report =
        extract(*memory_, {.query = {.max_error = 0}, .regions = {mesh_.region_ids[region]}}, kept);
    EXPECT_EQ(report.achieved_error, 0);
    EXPECT_EQ(corners_of(kept.positions, kept.tetrahedra),
              corners_of(mesh_.positions, cells_of(region)));
    EXPECT_LT(report.n_cut_cells, mesh_.tetrahedra.size());
  }
}

TEST_P(tetra_region_queries, spend_budgets_in_the_region) {
  const std::size_t n_full = cells_of(2).size();
  // With the last one all of the region is the reference's.
  for (const std::uint64_t max_cells :
       oracles::trials<std::vector<std::uint64_t>>({4'000, 8'000, 60'000}, {8'000, 60'000})) {
    SimplexMesh all;
    SimplexMesh kept;
    Query query{.max_error = 0};
    query.budget.max_cells = max_cells;
    extract(*memory_, {.query = query}, all);
    const auto n_before = static_cast<std::size_t>(std::ranges::count(all.regions, 9));
    const MeshReport report = extract(*memory_, {.query = query, .regions = {9}}, kept);
    EXPECT_LE(report.n_cut_cells, max_cells);
    EXPECT_GT(report.n_cells, n_before) << max_cells;
    EXPECT_LE(report.n_cells, n_full);
    if (max_cells == 60'000) {
      EXPECT_EQ(report.n_cells, n_full);
      EXPECT_EQ(report.achieved_error, 0);
    }
  }
}

TEST_P(tetra_region_queries, of_files_answer_as_memory_does_and_read_what_a_box_there_does) {
  save();
  for (const double tolerance : {0.1, 0.0}) {
    SimplexMesh memory;
    SimplexMesh file;
    SimplexMesh of_box;
    const TetraMeshOptions wanted{.query = {.max_error = tolerance}, .regions = {9}};
    extract(*memory_, wanted, memory);
    const TetraDataset some = opened();
    extract(some, wanted, file);
    EXPECT_EQ(file.positions, memory.positions);
    EXPECT_EQ(file.tetrahedra, memory.tetrahedra);
    EXPECT_EQ(file.values, memory.values);
    const TetraDataset boxed = opened();
    const Box3d corner{{{0, 0, 0}}, {{0.25, 0.25, 0.25}}};
    extract(boxed, {.query = {.boxes = {corner}, .max_error = tolerance}}, of_box);
    EXPECT_LE(some.reads().n_bytes, boxed.reads().n_bytes) << tolerance;
  }
}

TEST_P(tetra_region_queries, of_all_kinds_refine_the_region_alone) {
  Progress progress;
  const std::uint64_t n_all = mesh_.tetrahedra.size();
  Surface surface;
  TetraSurfaceOptions isosurface{.query = {.isovalues = {0.1}, .max_error = 0}};
  const auto everywhere = memory_->extract_surface(isosurface, surface, progress);
  isosurface.regions = {9};
  const auto of_region = memory_->extract_surface(isosurface, surface, progress);
  ASSERT_TRUE(everywhere && of_region);
  EXPECT_LT(share_of(of_region->n_cut_cells, everywhere->n_cut_cells), most_share());
  const auto boundary =
      memory_->extract_boundary({.query = {.max_error = 0}, .regions = {9}}, surface, progress);
  ASSERT_TRUE(boundary);
  EXPECT_LT(share_of(boundary->n_cut_cells, n_all), most_share());
  // The rest is no finer for it, and the sum is the region's.
  const auto integral = memory_->integrate({.regions = {9}, .max_error = 0}, progress);
  ASSERT_TRUE(integral);
  EXPECT_LT(share_of(integral->probe.n_cut_cells, n_all), most_share());
  EXPECT_EQ(integral->probe.achieved_error, 0);
  double sum = 0;
  for (const auto& t : cells_of(2)) {
    double value = 0;
    for (const std::uint32_t v : t) value += mesh_.fields[0].values[v] / 4;
    sum += value * volume_of(mesh_.positions, t);
  }
  EXPECT_NEAR(integral->integral.value, sum, 1e-12);
  EXPECT_LE(integral->integral.high - integral->integral.low, 1e-12);
}

TEST_P(tetra_region_queries, with_a_tolerance_outside_keep_to_the_region) {
  SimplexMesh kept;
  Query query{
      .boxes = {{{{0, 0, 0}}, {{0.1, 0.1, 0.1}}}}, .max_error = 0, .max_error_outside = 0.1};
  const MeshReport report = extract(*memory_, {.query = query, .regions = {9}}, kept);
  EXPECT_LT(share_of(report.n_cut_cells, mesh_.tetrahedra.size()), most_share());
  for (const float error : kept.errors) EXPECT_LE(error, 0.1F);
}

INSTANTIATE_TEST_SUITE_P(placements, tetra_region_queries,
                         testing::Values(Placement::half_edge, Placement::midpoint));

}  // namespace
}  // namespace lode::test
