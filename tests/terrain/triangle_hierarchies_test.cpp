// What hierarchies of triangulations over rasters have in common.
#include <algorithm>
#include <functional>

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/adaptive_triangulation/adaptive_triangulation.h"
#include "lode/models/terrain/hierarchical_delaunay/hierarchical_delaunay.h"
#include "lode/models/terrain/triangle_hierarchy/locator.h"
#include "tests/terrain/hierarchy_fixtures.h"

namespace lode::test {
namespace {

using delaunay::TinLinks;
using triangle_hierarchy::Locator;

struct Model {
  const char* name;
  std::function<Result<Hierarchy>(const HeightGrid&, std::span<const double>, Threads)> build;
};

class triangle_hierarchies : public testing::TestWithParam<Model> {
 protected:
  static Hierarchy build(const HeightGrid& grid, std::span<const double> levels = kLevels,
                         Threads threads = {2}) {
    auto made = GetParam().build(grid, levels, threads);
    EXPECT_TRUE(made);
    return *std::move(made);
  }
};

TEST_P(triangle_hierarchies, have_meshes_that_match_and_keep_their_tolerances) {
  for (const TerrainCase& c : terrain_cases()) {
    const Hierarchy h = build(c.grid);
    ASSERT_EQ(h.n_levels(), static_cast<int>(kLevels.size()));
    for (int level = 0; level < h.n_levels(); ++level) {
      SCOPED_TRACE(testing::Message() << c.name << ", level " << level);
      const delaunay::Tin tin = tin_of_level(h, level, TinLinks::kept);
      delaunay::test::expect_fills(tin, c.grid, h.scale());
      expect_within(tin, h.scale(), c.grid, kLevels[static_cast<std::size_t>(level)]);
    }
  }
}

TEST_P(triangle_hierarchies, are_hierarchies_as_the_survey_defines_them) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    expect_hierarchy(build(c.grid), &c.grid);
  }
}

TEST_P(triangle_hierarchies, refine_only_what_errs) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const std::string_view name = c.name;
    const Hierarchy h = build(c.grid);
    // Nothing to refine in planes.
    if (name == "flat" || name == "a plane" || name == "a cell")
      EXPECT_EQ(h.triangles.size(), 2U);
    else
      EXPECT_GT(h.refinements.size(), 0U);
  }
}

TEST_P(triangle_hierarchies, know_the_neighbours_in_every_level) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy h = build(c.grid);
    for (int level = 0; level < h.n_levels(); ++level) {
      std::vector<std::uint32_t> members;
      std::vector<std::array<std::uint32_t, 3>> corners;
      for (std::uint32_t t = 0; t < h.triangles_until[static_cast<std::size_t>(level)]; ++t)
        if (h.is_in_level(t, level)) {
          members.push_back(t);
          corners.push_back(h.triangles[t].corner);
        }
      const auto twins = delaunay::find_twins(corners);
      for (std::size_t i = 0; i < members.size(); ++i)
        for (unsigned edge = 0; edge < 3; ++edge) {
          const std::uint32_t twin = twins[i][edge];
          const std::uint32_t expected =
              twin == delaunay::kNoHalfEdge ? twin : 4 * members[twin >> 2] + (twin & 3);
          ASSERT_EQ(h.neighbour(level, members[i], edge), expected);
        }
    }
  }
}

bool holds(const Hierarchy& h, std::uint32_t t, const delaunay::Point& place) {
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = h.vertices[h.triangles[t].corner[i]];
    const LatticePoint b = h.vertices[h.triangles[t].corner[(i + 1) % 3]];
    // Exactly: coordinates of at most 30 bits and 30 more beyond the point.
    const long double side = static_cast<long double>(b.x - a.x) * (place[1] * h.scale() - a.y) -
                             static_cast<long double>(b.y - a.y) * (place[0] * h.scale() - a.x);
    if (side < 0) return false;
  }
  return true;
}

TEST_P(triangle_hierarchies, find_the_triangles_of_places_by_descent) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy h = build(c.grid);
    const Locator locator(h);
    oracles::Random random(9);
    for (int n = 0; n < 300; ++n) {
      // Samples, middles of cells' sides, and any places of 2^-20.
      const double unit = n % 3 == 0 ? 1 : n % 3 == 1 ? 0.5 : 0x1p-20;
      delaunay::Point place;
      place[0] = std::floor(random.uniform(-1, c.grid.n_columns) / unit) * unit;
      place[1] = std::floor(random.uniform(-1, c.grid.n_rows) / unit) * unit;
      for (int level = 0; level < h.n_levels(); ++level) {
        const auto found = locator.find(level, place);
        if (found) {
          EXPECT_TRUE(h.is_in_level(*found, level));
          EXPECT_LT(*found, h.triangles_until[static_cast<std::size_t>(level)]);
          EXPECT_TRUE(holds(h, *found, place));
          continue;
        }
        for (std::uint32_t t = 0; t < h.triangles_until[static_cast<std::size_t>(level)]; ++t)
          EXPECT_FALSE(h.is_in_level(t, level) && holds(h, t, place))
              << place[0] << ", " << place[1] << " in " << t;
      }
    }
  }
}

/// Whether some place of a triangle is in a window: a corner of either in the other, or sides that
/// cross; in long doubles, exact here.
bool meets(const Hierarchy& h, std::uint32_t t, const triangle_hierarchy::Window& window) {
  std::array<LatticePoint, 3> a;
  for (std::size_t i = 0; i < 3; ++i) a[i] = h.vertices[h.triangles[t].corner[i]];
  const std::int32_t s = h.scale();
  const std::array<LatticePoint, 4> b{{{window.lower.x * s, window.lower.y * s},
                                       {window.upper.x * s, window.lower.y * s},
                                       {window.upper.x * s, window.upper.y * s},
                                       {window.lower.x * s, window.upper.y * s}}};
  const auto is_in_window = [&](LatticePoint p) {
    return p.x >= b[0].x && p.x <= b[2].x && p.y >= b[0].y && p.y <= b[2].y;
  };
  const auto sign = [](LatticePoint p, LatticePoint q, LatticePoint r) {
    const std::int64_t area = delaunay::doubled_area(p, q, r);
    return (area > 0) - (area < 0);
  };
  const auto is_in_triangle = [&](LatticePoint p) {
    return sign(a[0], a[1], p) >= 0 && sign(a[1], a[2], p) >= 0 && sign(a[2], a[0], p) >= 0;
  };
  if (std::ranges::any_of(a, is_in_window) || std::ranges::any_of(b, is_in_triangle)) return true;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const LatticePoint p = a[i];
      const LatticePoint q = a[(i + 1) % 3];
      const LatticePoint u = b[j];
      const LatticePoint v = b[(j + 1) % 4];
      if (sign(p, q, u) * sign(p, q, v) < 0 && sign(u, v, p) * sign(u, v, q) < 0) return true;
    }
  return false;
}

TEST_P(triangle_hierarchies, find_what_meets_a_window_by_descent) {
  for (const TerrainCase& c : terrain_cases()) {
    const Hierarchy h = build(c.grid);
    oracles::Random random(2);
    for (int n = 0; n < 12; ++n) {
      const auto any = [&](std::int32_t last) {
        return static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(last) + 1));
      };
      triangle_hierarchy::Window window{{any(c.grid.n_columns), any(c.grid.n_rows)}, {}};
      window.upper = {window.lower.x + any(9), window.lower.y + any(9)};
      for (int level = 0; level < h.n_levels(); ++level) {
        SCOPED_TRACE(testing::Message() << c.name << ", level " << level);
        std::vector<std::uint32_t> expected;
        for (std::uint32_t t = 0; t < h.triangles_until[static_cast<std::size_t>(level)]; ++t)
          if (h.is_in_level(t, level) && meets(h, t, window)) expected.push_back(t);
        EXPECT_EQ(find_in_window(h, level, window), expected);
      }
    }
  }
}

TEST_P(triangle_hierarchies, are_the_same_for_any_number_of_threads) {
  for (const TerrainCase& c : terrain_cases()) {
    SCOPED_TRACE(c.name);
    const Hierarchy one = build(c.grid, kLevels, {1});
    const Hierarchy three = build(c.grid, kLevels, {3});
    EXPECT_EQ(one.vertices, three.vertices);
    EXPECT_EQ(one.heights, three.heights);
    ASSERT_EQ(one.triangles.size(), three.triangles.size());
    for (std::size_t t = 0; t < one.triangles.size(); ++t) {
      EXPECT_EQ(one.triangles[t].corner, three.triangles[t].corner);
      EXPECT_EQ(one.triangles[t].twin, three.triangles[t].twin);
      EXPECT_EQ(one.triangles[t].error, three.triangles[t].error);
    }
  }
}

TEST_P(triangle_hierarchies, say_which_level_keeps_a_tolerance) {
  const Hierarchy h = build(terrain_cases()[0].grid);
  EXPECT_EQ(h.level_within(2000).value(), 0);
  EXPECT_EQ(h.level_within(40).value(), 2);
  EXPECT_EQ(h.level_within(39).value(), 3);
  EXPECT_FALSE(h.level_within(-1));
}

TEST_P(triangle_hierarchies, refuse_what_is_no_terrain_and_no_levels) {
  const HeightGrid hills = make_grid<float>(9, 9, hills_with_spikes);
  const HeightGrid row = make_grid<float>(9, 1, hills_with_spikes);
  const HeightGrid high = make_grid<double>(3, 3, [](int, int) { return 1e31; });
  HeightGrid empty = make_grid<float>(3, 3, hills_with_spikes);
  delaunay::test::set_missing(empty, 1, 1);
  const std::array one{1.0};
  for (const HeightGrid* grid : {&row, &high, &std::as_const(empty)})
    EXPECT_FALSE(GetParam().build(*grid, one, {1}));
  for (const std::vector<double>& levels :
       {std::vector<double>{}, {1, 1}, {1, 2}, {-1}, {std::nan("")}})
    EXPECT_FALSE(GetParam().build(hills, levels, {1}));
}

INSTANTIATE_TEST_SUITE_P(
    models, triangle_hierarchies,
    testing::Values(Model{"adaptive_triangulation",
                          [](const HeightGrid& grid, std::span<const double> levels,
                             Threads threads) -> Result<Hierarchy> {
                            Progress progress;
                            LODE_TRY(auto made, adaptive_triangulation::build(grid, levels, threads,
                                                                              progress));
                            return std::move(made.hierarchy);
                          }},
                    Model{"hierarchical_delaunay",
                          [](const HeightGrid& grid, std::span<const double> levels,
                             Threads threads) -> Result<Hierarchy> {
                            Progress progress;
                            LODE_TRY(auto made,
                                     hierarchical_delaunay::build(grid, levels, threads, progress));
                            return std::move(made.hierarchy);
                          }}),
    [](const auto& model) { return std::string(model.param.name); });

}  // namespace
}  // namespace lode::test
