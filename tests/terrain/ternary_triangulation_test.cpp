#include "lode/models/terrain/ternary_triangulation/ternary_triangulation.h"

#include <algorithm>
#include <numeric>

#include "lode/models/terrain/insertions/overlap.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::ternary_triangulation {
namespace {

using delaunay::doubled_area;
using delaunay::LatticePoint;
using delaunay::Tin;
using insertions::History;
using insertions::kNone;
using insertions::LatticeCorners;
using insertions::Triangle;
using insertions::test::Case;
using insertions::test::cases;
using insertions::test::expect_true;

History ternary_of(const HeightGrid& grid, double max_error) {
  Progress progress;
  auto made = build(grid, max_error, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

LatticeCorners places(const History& history, std::uint32_t t) {
  const auto& corner = history.triangles[t].corner;
  return {history.vertices[corner[0]], history.vertices[corner[1]], history.vertices[corner[2]]};
}

std::int64_t area_of(const LatticeCorners& p) { return doubled_area(p[0], p[1], p[2]); }

TEST(ternary_triangulation, is_true_at_any_tolerance) {
  for (const Case& c : cases()) {
    const History history = ternary_of(c.grid, 2);
    for (const double tolerance : {1000.0, 400.0, 123.0, 50.0, 7.5, 2.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      expect_true(tin_at(history, time_within(history, tolerance), delaunay::TinLinks::kept),
                  c.grid, tolerance);
    }
  }
}

/// The error of the triangle's plane at a sample, in doubles.
double error_at(const History& history, std::uint32_t t, LatticePoint p, double z) {
  const LatticeCorners at = places(history, t);
  const auto& corner = history.triangles[t].corner;
  double plane = 0;
  for (std::size_t i = 0; i < 3; ++i)
    plane += history.heights[corner[i]] *
             static_cast<double>(doubled_area(at[(i + 1) % 3], at[(i + 2) % 3], p)) /
             static_cast<double>(area_of(at));
  return std::abs(z - plane);
}

TEST(ternary_triangulation, splits_a_worst_triangle_at_its_worst_sample) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const History history = ternary_of(c.grid, 2);
    std::multiset<float> errors;
    for (std::uint32_t t = 0; t < history.n_base_triangles(); ++t)
      errors.insert(history.triangles[t].error);
    for (std::uint32_t node = 0; node < history.n_nodes(); ++node) {
      const std::uint32_t split = history.removed_by(node).front();
      const float error = history.triangles[split].error;
      EXPECT_EQ(error, *errors.rbegin()) << "another errs by more";
      const std::uint32_t vertex = history.vertex_of(node);
      EXPECT_GE(error_at(history, split, history.vertices[vertex], history.heights[vertex]),
                static_cast<double>(error) * (1 - 0x1p-7) - 1e-6);
      for (const std::uint32_t t : history.removed_by(node))
        errors.erase(errors.find(history.triangles[t].error));
      for (std::uint32_t t = history.first_made[node]; t < history.first_made[node + 1]; ++t)
        errors.insert(history.triangles[t].error);
    }
  }
}

TEST(ternary_triangulation, parts_fill_what_was_split) {
  std::uint64_t n_inside = 0;
  std::uint64_t n_on_edges = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const History history = ternary_of(c.grid, 2);
    for (std::uint32_t node = 0; node < history.n_nodes(); ++node) {
      const LatticePoint p = history.vertices[history.vertex_of(node)];
      const auto removed = history.removed_by(node);
      ASSERT_LE(removed.size(), 2U);
      std::vector<std::uint32_t> all;
      for (const std::uint32_t t : removed) {
        const LatticeCorners whole = places(history, t);
        EXPECT_TRUE(insertions::holds(whole, p));
        std::size_t n_edges = 0;
        for (std::size_t i = 0; i < 3; ++i)
          n_edges += doubled_area(whole[i], whole[(i + 1) % 3], p) == 0 ? 1U : 0U;
        ASSERT_LE(n_edges, 1U) << "at a corner";
        std::vector<std::uint32_t> parts;
        add_parts(history, t, parts);
        EXPECT_EQ(parts.size(), 3 - n_edges);
        std::int64_t area = 0;
        for (const std::uint32_t part : parts) {
          for (const LatticePoint q : places(history, part))
            EXPECT_TRUE(insertions::holds(whole, q));
          area += area_of(places(history, part));
        }
        EXPECT_EQ(area, area_of(whole));
        all.insert(all.end(), parts.begin(), parts.end());
        ++(n_edges > 0 ? n_on_edges : n_inside);
        if (removed.size() == 2) EXPECT_EQ(n_edges, 1U);
      }
      std::ranges::sort(all);
      std::vector<std::uint32_t> made(history.first_made[node + 1] - history.first_made[node]);
      std::iota(made.begin(), made.end(), history.first_made[node]);
      EXPECT_EQ(all, made) << "all that was made is a part of one";
    }
    std::vector<std::uint32_t> none;
    for (std::uint32_t t = 0; t < history.triangles.size(); ++t)
      if (history.triangles[t].death == kNone) add_parts(history, t, none);
    EXPECT_TRUE(none.empty());
  }
  EXPECT_GT(n_inside, 100U);
  EXPECT_GT(n_on_edges, 100U);
}

TEST(ternary_triangulation, is_no_larger_than_the_size_theorem_says) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const History history = ternary_of(c.grid, 2);
    const HierarchySize size = size_of(history);
    EXPECT_EQ(size.n_expanded,
              tin_at(history, history.n_nodes(), delaunay::TinLinks::left_out).triangles.size());
    // Fewer than b / (b - 1) times as many, b = 2 for samples on edges.
    EXPECT_LT(size.n_regions, 2 * size.n_expanded);
    EXPECT_GE(size.n_levels, history.n_nodes() > 0 ? 2U : 1U);
    EXPECT_LE(size.n_levels, history.n_nodes() + 1);
  }
}

TEST(ternary_triangulation, of_samples_off_all_edges_has_three_halves) {
  // A spike inside of both of the outline's triangles, and nothing else.
  const HeightGrid grid = delaunay::test::make_grid<std::int16_t>(
      9, 9, [](int x, int y) { return (x == 5 && y == 2) || (x == 2 && y == 5) ? 100 : 0; });
  const History history = ternary_of(grid, 99);
  ASSERT_EQ(history.n_nodes(), 2U);
  const HierarchySize size = size_of(history);
  EXPECT_EQ(size.n_regions, 8U);
  EXPECT_EQ(size.n_expanded, 6U);
  EXPECT_EQ(size.n_levels, 2U);
  EXPECT_LT(2 * size.n_regions, 3 * size.n_expanded);
}

}  // namespace
}  // namespace lode::ternary_triangulation
