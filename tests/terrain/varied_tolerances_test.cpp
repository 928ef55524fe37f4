// Vertical errors at all samples where the tolerance varies, of models on squares, by brute force:
// in a box, outside of it, and with the distance from a place.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "lode/api/built_terrain.h"
#include "lode/api/terrain_selection.h"
#include "lode/api/terrain_source.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/terrain/nodes_in_triangle.h"

namespace lode {
namespace {

/// What is asked for at a place of the world.
using Asked = std::function<double(const Vec<double, 2>&)>;

struct Variation {
  const char* name;
  double max_error;
  TerrainFocus focus;
  Asked asked;
};

HeightGrid rugged() {
  HeightGrid grid = delaunay::test::make_grid<float>(90, 61, [](int x, int y) {
    return 100 * std::sin(0.13 * x) * std::cos(0.09 * y) + 20 * std::sin(1.7 * x + y * y);
  });
  grid.to_world = {1000.5, 10, 0, 9e5, 0, -10};
  for (std::int32_t x = 40; x < 44; ++x) delaunay::test::set_missing(grid, x, 20);
  return grid;
}

std::vector<Variation> variations() {
  const PlaceBox box{{{1300, 899600}}, {{1605, 899810}}};
  TerrainFocus in_box;
  in_box.boxes = {box};
  in_box.max_error_outside = 50;
  TerrainFocus alone = in_box;
  alone.max_error_outside.reset();
  TerrainFocus at_point;
  at_point.point = Vec<double, 2>{{1400, 899700}};
  at_point.growth = 0.1;
  const auto is_inside = [box](const Vec<double, 2>& p) {
    return p[0] >= box.lower[0] && p[0] <= box.upper[0] && p[1] >= box.lower[1] &&
           p[1] <= box.upper[1];
  };
  return {{"a box", 5, in_box, [=](const auto& p) { return is_inside(p) ? 5 : 50; }},
          {"a box alone", 5, alone, [=](const auto& p) { return is_inside(p) ? 5 : HUGE_VAL; }},
          {"a place", 2, at_point,
           [](const auto& p) { return 2 + 0.1 * std::hypot(p[0] - 1400, p[1] - 899700); }}};
}

/// The samples that err by more than is asked in a triangle that holds them, and by how much.
std::map<std::pair<std::int32_t, std::int32_t>, double> beyond(const delaunay::Tin& tin,
                                                               const HeightGrid& grid,
                                                               const Asked& asked) {
  std::map<std::pair<std::int32_t, std::int32_t>, double> found;
  for (const auto& t : tin.triangles) {
    const LatticePoint a = tin.vertices[t[0]];
    const LatticePoint b = tin.vertices[t[1]];
    const LatticePoint c = tin.vertices[t[2]];
    const auto area = static_cast<long double>(delaunay::doubled_area(a, b, c));
    test::for_each_node_in(
        a, b, c, [&](LatticePoint p, std::int64_t wa, std::int64_t wb, std::int64_t wc) {
          const long double plane = (static_cast<long double>(wa) * tin.heights[t[0]] +
                                     static_cast<long double>(wb) * tin.heights[t[1]] +
                                     static_cast<long double>(wc) * tin.heights[t[2]]) /
                                    area;
          const auto error = static_cast<double>(std::abs(grid.height(p.x, p.y) - plane));
          if (error <= asked(grid.world(p.x, p.y))) return;
          double& worst = found[{p.x, p.y}];
          worst = std::max(worst, error);
        });
  }
  return found;
}

class varied_tolerances : public testing::TestWithParam<TerrainModel> {
 protected:
  varied_tolerances() {
    Progress progress;
    auto made = BuiltTerrain::build(grid_, {.model = GetParam(), .levels = {1}}, progress);
    EXPECT_TRUE(made) << made.error().message;
    terrain_ = std::make_unique<Terrain>(made->terrain());
  }
  [[nodiscard]] SelectedTerrain select(const Variation& variation) const {
    Progress progress;
    auto made =
        terrain_->origin().select({.max_error = variation.max_error, .focus = variation.focus},
                                  delaunay::TinLinks::left_out, progress);
    EXPECT_TRUE(made) << made.error().message;
    return *std::move(made);
  }

  HeightGrid grid_ = rugged();
  std::unique_ptr<Terrain> terrain_;
};

TEST_P(varied_tolerances, hold_at_every_sample_or_are_said_not_to) {
  std::size_t n_beyond = 0;
  for (const Variation& variation : variations()) {
    SCOPED_TRACE(variation.name);
    const SelectedTerrain selected = select(variation);
    const TerrainReport& report = selected.report;
    const auto all = beyond(selected.tin, grid_, variation.asked);
    if (GetParam() != TerrainModel::surface_quadtree) EXPECT_TRUE(all.empty());
    EXPECT_EQ(report.is_within_error, all.empty());
    EXPECT_EQ(report.n_beyond, all.size());
    double worst = 0;
    for (const auto& [at, error] : all) worst = std::max(worst, error);
    EXPECT_NEAR(report.worst_beyond, worst, 1e-9);
    EXPECT_FALSE(report.is_uniform);
    n_beyond += all.size();
    // It varies: fewer triangles than the finest tolerance has everywhere.
    Progress progress;
    const auto uniform = terrain_->origin().select({.max_error = variation.max_error},
                                                   delaunay::TinLinks::left_out, progress);
    ASSERT_TRUE(uniform);
    EXPECT_LT(5 * selected.tin.triangles.size(), 4 * uniform->tin.triangles.size());
  }
  EXPECT_EQ(n_beyond > 0, GetParam() == TerrainModel::surface_quadtree);
}

/// What answers `height`, bilinear of squares, keeps them in any case.
TEST_P(varied_tolerances, hold_of_heights_at_every_sample) {
  for (const Variation& variation : variations()) {
    SCOPED_TRACE(variation.name);
    Progress progress;
    const auto patches = terrain_->origin().patches(
        {.max_error = variation.max_error, .focus = variation.focus}, progress);
    ASSERT_TRUE(patches);
    if (!*patches) continue;  // Its triangles are what it has.
    EXPECT_TRUE((*patches)->report().is_within_error);
    for (std::int32_t y = 0; y < grid_.n_rows; ++y)
      for (std::int32_t x = 0; x < grid_.n_columns; ++x) {
        const auto height =
            (*patches)->height_at({{static_cast<double>(x), static_cast<double>(y)}});
        if (!height) continue;
        const double error = std::abs(height->height - grid_.height(x, y));
        EXPECT_LE(error, variation.asked(grid_.world(x, y)) + height->rounding);
        EXPECT_LE(error, height->error + height->rounding);
      }
  }
}

INSTANTIATE_TEST_SUITE_P(models, varied_tolerances,
                         testing::Values(TerrainModel::surface_quadtree,
                                         TerrainModel::quaternary_triangulation,
                                         TerrainModel::right_triangle_bisection),
                         [](const auto& model) { return name_of(model.param); });

}  // namespace
}  // namespace lode
