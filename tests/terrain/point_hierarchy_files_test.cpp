// Hierarchies of triangulations of scattered points as terrains that are built, kept in files and
// asked.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_source.h"
#include "lode/models/terrain/hierarchy_file/hierarchy_file.h"
#include "tests/terrain/point_terrains.h"

namespace lode::test {
namespace {

using delaunay::Tin;

class point_hierarchy_files : public testing::TestWithParam<TerrainModel> {
 protected:
  ~point_hierarchy_files() override {
    std::filesystem::remove(path_);
    std::filesystem::remove(other_);
  }
  BuiltTerrain build(const PointTerrain& terrain, const std::vector<double>& levels) {
    auto made = BuiltTerrain::build(
        terrain, {.model = GetParam(), .levels = levels, .sample_type = "points"}, progress_);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }
  BuiltTerrain reopened(const BuiltTerrain& made) {
    EXPECT_TRUE(made.save(path_, progress_));
    auto opened = BuiltTerrain::open(path_, progress_);
    EXPECT_TRUE(opened) << opened.error().message;
    return *std::move(opened);
  }
  /// The first check that a file with a lie does not pass.
  template <typename Tell>
  std::string found_of(const PointTerrain& terrain, const Tell& tell) {
    auto model = hierarchy_file::open(path_, progress_);
    EXPECT_TRUE(model) << model.error().message;
    tell(model->hierarchy);
    EXPECT_TRUE(hierarchy_file::save(*model, other_, progress_));
    const auto opened = BuiltTerrain::open(other_, progress_);
    if (!opened) return opened.error().message;
    const auto report = opened->verify(terrain, {2}, progress_);
    if (!report) return report.error().message;
    for (const VerifyReport::Check& check : report->checks)
      if (!check.passed) return check.name;
    return "";
  }

  Progress progress_;
  const std::string path_ =
      testing::TempDir() + "lode_point_hierarchy_" + std::to_string(::getpid()) + ".lode";
  const std::string other_ =
      testing::TempDir() + "lode_point_hierarchy_lie_" + std::to_string(::getpid()) + ".lode";
};

void expect_all_passed(const Result<VerifyReport>& report) {
  ASSERT_TRUE(report) << report.error().message;
  for (const VerifyReport::Check& check : report->checks)
    EXPECT_TRUE(check.passed) << check.name << ": " << check.detail;
}

TEST_P(point_hierarchy_files, hold_against_their_points_and_come_back) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const BuiltTerrain made = build(c.terrain, {30, 10, 1.5});
    expect_all_passed(made.verify(c.terrain, {2}, progress_));
    const BuiltTerrain opened = reopened(made);
    expect_all_passed(opened.verify(c.terrain, {1}, progress_));
    expect_all_passed(opened.verify_alone({1}, progress_));
    EXPECT_TRUE(opened.describe_source().is_of_points);
    EXPECT_EQ(opened.describe_source().n_lines, c.terrain.domain.lines.size());
    for (const double tolerance : {100.0, 12.0, 1.5}) {
      const auto a = extract_terrain(made.terrain(), {.max_error = tolerance}, progress_);
      const auto b = extract_terrain(opened.terrain(), {.max_error = tolerance}, progress_);
      ASSERT_TRUE(a && b);
      EXPECT_EQ(a->surface.positions, b->surface.positions);
      EXPECT_EQ(a->surface.triangles, b->surface.triangles);
    }
    EXPECT_FALSE(extract_terrain(opened.terrain(), {.max_error = 1}, progress_));
  }
}

/// Of points that lie in a TIN's triangles on a lattice `scale` times as fine: by trying all.
/// `most(i)`: by how much the i-th may err.
template <typename Most>
void expect_stated(const Tin& tin, std::int32_t scale, const PointTerrain& terrain,
                   const Most& most) {
  const HeightRange range = height_range(terrain.points);
  const double rounding = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  for (std::size_t i = 0; i < terrain.points.nodes.size(); ++i) {
    const LatticePoint p{terrain.points.nodes[i].x * scale, terrain.points.nodes[i].y * scale};
    int n_holding = 0;
    for (std::size_t t = 0; t < tin.triangles.size(); ++t) {
      long double sum = 0;
      std::int64_t area = 0;
      bool is_in = true;
      for (std::size_t k = 0; k < 3 && is_in; ++k) {
        const std::int64_t weight =
            delaunay::doubled_area(p, tin.vertices[tin.triangles[t][(k + 1) % 3]],
                                   tin.vertices[tin.triangles[t][(k + 2) % 3]]);
        is_in = weight >= 0;
        area += weight;
        sum += static_cast<long double>(weight) *
               static_cast<long double>(tin.heights[tin.triangles[t][k]]);
      }
      if (!is_in) continue;
      ++n_holding;
      const auto error = static_cast<double>(
          std::abs(sum / static_cast<long double>(area) - terrain.points.heights[i]));
      EXPECT_LE(error, most(i) + rounding);
      EXPECT_LE(error, static_cast<double>(tin.errors[t]) + rounding);
    }
    EXPECT_EQ(n_holding > 0, terrain.domain.triangle_of[i] != delaunay::kNoHalfEdge);
  }
}

/// With the points at hand what is between levels is measured, in a file bounded.
TEST_P(point_hierarchy_files, vary_and_keep_what_they_say) {
  for (const PointCase& c : point_cases()) {
    SCOPED_TRACE(c.name);
    const BuiltTerrain made = build(c.terrain, {60, 30, 10, 3, 1.5});
    const BuiltTerrain opened = reopened(made);
    const HeightFrame& frame = c.terrain.points;
    const Vec<double, 2> low = frame.world(0.3 * frame.n_columns, 0.3 * frame.n_rows);
    const Vec<double, 2> high = frame.world(0.5 * frame.n_columns, 0.6 * frame.n_rows);
    TerrainFocus focus;
    focus.boxes = {{low, high}};
    for (const double outside : {60.0, 7.0}) {
      focus.max_error_outside = outside;
      const TerrainOptions options{.max_error = 1.5, .focus = focus};
      std::size_t measured = 0;
      for (const BuiltTerrain* built : {&made, &opened}) {
        const auto selected =
            built->terrain().origin().select(options, delaunay::TinLinks::kept, progress_);
        ASSERT_TRUE(selected) << selected.error().message;
        const Tin& tin = selected->tin;
        const std::int32_t scale = (built->terrain().frame().n_columns - 1) / (frame.n_columns - 1);
        expect_fills_domain(tin, scale, c.terrain);
        expect_stated(tin, scale, c.terrain, [&](std::size_t i) {
          const LatticePoint p = c.terrain.points.nodes[i];
          const Vec<double, 2> at = frame.world(p.x, p.y);
          const bool is_inside = low[0] <= at[0] && at[0] <= high[0] &&
                                 std::min(low[1], high[1]) <= at[1] &&
                                 at[1] <= std::max(low[1], high[1]);
          return is_inside ? 1.5 : outside;
        });
        EXPECT_GE(tin.triangles.size(), measured);
        measured = tin.triangles.size();
      }
    }
  }
}

TEST_P(point_hierarchy_files, are_found_out_where_they_lie) {
  const PointTerrain terrain = scattered(400, 2000, 9, {.max_edge = 300});
  ASSERT_TRUE(build(terrain, {30, 10, 1.5}).save(path_, progress_));
  EXPECT_EQ(found_of(terrain, [](auto&) {}), "");
  const auto expect_found = [&](const char* check, const auto& tell) {
    const std::string found = found_of(terrain, tell);
    EXPECT_NE(found.find(check), std::string::npos) << found << " instead of " << check;
  };
  // A point's, and one between points.
  for (const bool is_point : {true, false})
    expect_found("vertices are on the triangulation of all points", [&](auto& h) {
      for (std::size_t v = h.vertices_until[0]; v < h.vertices.size(); ++v) {
        const LatticePoint p{h.vertices[v].x / h.scale(), h.vertices[v].y / h.scale()};
        const bool is_at_point =
            h.vertices[v].x % h.scale() == 0 && h.vertices[v].y % h.scale() == 0 &&
            std::ranges::find(terrain.points.nodes, p) != terrain.points.nodes.end();
        if (is_at_point != is_point) continue;
        h.heights[v] += h.heights[v] > 0 ? -1e-9 : 1e-9;
        return;
      }
      ADD_FAILURE() << "no such vertex";
    });
  expect_found("state their errors", [](auto& h) {
    for (auto& triangle : h.triangles) triangle.error /= 2;
  });
  expect_found("within 3: samples are within the error", [](auto& h) {
    h.tolerances = {3, 2, 1.5};
    for (auto& triangle : h.triangles) triangle.error = 0;
  });
  expect_found("points beside them to be refined", [](auto& h) {
    const auto last = static_cast<std::uint32_t>(h.triangles.size() - 1);
    h.crowded = {last};
  });
  const PointTerrain whole = scattered(400, 2000, 9);
  EXPECT_NE(found_of(whole, [](auto&) {}), "");
  PointTerrain other = terrain;
  other.points.heights[7] += 0.25;
  EXPECT_NE(found_of(other, [](auto&) {}), "");
}

/// Each point has another a node or two beside it.
TEST_P(point_hierarchy_files, know_triangles_with_points_close_beside_them) {
  std::vector<Vec3d> points;
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x) {
      const double z = rough_hills(7 * x, 7 * y);
      points.push_back({{2000.0 * x, 2000.0 * y + 300 * (x % 3), z}});
      points.push_back({{2000.0 * x + 1, 2000.0 * y + 300 * (x % 3) + 2, z + 1}});
    }
  auto terrain = make_point_terrain(points, {{0, 0}, 1}, {}, {}, progress_);
  ASSERT_TRUE(terrain);
  const BuiltTerrain made = build(*terrain, {60, 20, 5, 1.5});
  expect_all_passed(made.verify(*terrain, {2}, progress_));
  ASSERT_TRUE(made.save(path_, progress_));
  const auto model = hierarchy_file::open(path_, progress_);
  ASSERT_TRUE(model);
  EXPECT_GT(model->hierarchy.crowded.size(), 0U);
  EXPECT_LE(model->hierarchy.crowded.size(), model->hierarchy.refinements.size());
  EXPECT_NE(found_of(*terrain, [](auto& h) { h.crowded.clear(); }).find("close beside them"),
            std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(models, point_hierarchy_files,
                         testing::Values(TerrainModel::adaptive_triangulation,
                                         TerrainModel::hierarchical_delaunay),
                         [](const auto& tested) { return std::string(name_of(tested.param)); });

}  // namespace
}  // namespace lode::test
