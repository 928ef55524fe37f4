#pragma once

// Rasters and oracles for tests of what is made by insertions.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "lode/models/terrain/delaunay_selector/spatial_order.h"
#include "lode/models/terrain/implicit_pyramid/build.h"
#include "lode/models/terrain/insertions/build.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/persist.h"
#include "lode/refine/focus.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"

namespace lode::insertions::test {

using delaunay::Tin;

inline constexpr std::array kModels{Model::delaunay_pyramid, Model::ternary_triangulation,
                                    Model::implicit_delaunay_pyramid};

inline bool is_delaunay(Model model) { return rule_of(model) == delaunay::InsertionRule::delaunay; }

/// Hills, a plain and single spikes.
inline double terrain(std::int32_t x, std::int32_t y) {
  const double hills = 900 * std::sin(0.31 * x) * std::cos(0.23 * y + 0.01 * x * y);
  const bool is_spike = (x * 7 + y * 13) % 31 == 0;
  return std::round((x + y < 18 ? 0 : hills) + (is_spike ? 150 : 0)) + 2000;
}

inline HeightGrid grid_with_gaps() {
  HeightGrid grid = delaunay::test::make_grid<float>(37, 29, terrain);
  for (std::int32_t y = 8; y < 14; ++y)
    for (std::int32_t x = 11; x < 13 + y / 3; ++x) delaunay::test::set_missing(grid, x, y);
  delaunay::test::set_missing(grid, 0, 0);
  delaunay::test::set_missing(grid, 36, 15);
  return grid;
}

/// Squares of 4 x 4 cells as on a chessboard, which meet at corners alone.
inline HeightGrid grid_of_parts() {
  HeightGrid grid = delaunay::test::make_grid<float>(17, 21, terrain);
  for (std::int32_t y = 0; y < 21; ++y)
    for (std::int32_t x = 0; x < 17; ++x)
      if ((x / 4 + y / 4) % 2 == 1 && x % 4 != 0 && y % 4 != 0)
        delaunay::test::set_missing(grid, x, y);
  return grid;
}

struct Case {
  const char* name;
  HeightGrid grid;
};

inline std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"whole", delaunay::test::make_grid<std::int16_t>(40, 33, terrain)});
  all.push_back({"gaps", grid_with_gaps()});
  all.push_back({"parts", grid_of_parts()});
  all.push_back({"flat", delaunay::test::make_grid<float>(17, 9, [](int, int) { return 3.5; })});
  all.push_back({"one cell", delaunay::test::make_grid<double>(2, 2, terrain)});
  all.push_back({"strip", delaunay::test::make_grid<std::uint16_t>(2, 60, terrain)});
  return all;
}

inline double hills(std::int32_t x, std::int32_t y) {
  return 40 * std::sin(0.3 * x + 0.1 * y) * std::cos(0.2 * y) + (x * 5 + y * 11) % 7;
}

/// With a line across its domain, and a lattice larger than rasters have.
inline LevelledHistory make_point_model(Model model) {
  HeightPoints points;
  oracles::Random random(3);
  const auto scaled = [](std::uint64_t x) { return static_cast<std::int32_t>(x << 20); };
  constexpr std::uint64_t kSize = 60;
  std::vector<delaunay::LatticePoint> nodes{{0, 0},
                                            {scaled(kSize), 0},
                                            {0, scaled(kSize)},
                                            {scaled(kSize), scaled(kSize)},
                                            {scaled(20), scaled(20)},
                                            {scaled(30), scaled(30)},
                                            {scaled(45), scaled(45)}};
  for (int i = 0; i < 240; ++i)
    nodes.push_back({scaled(random.below(kSize)), scaled(random.below(kSize))});
  const auto row = [](delaunay::LatticePoint p) { return std::pair(p.y, p.x); };
  std::ranges::sort(nodes, {}, row);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  points.nodes = nodes;
  for (const delaunay::LatticePoint& p : nodes)
    points.heights.push_back(hills(p.x >> 20, p.y >> 20));
  points.n_columns = points.n_rows = scaled(kSize) + 1;
  points.crs = "PROJCS[\"somewhere\"]";
  const auto number = [&](std::int32_t x, std::int32_t y) {
    const auto at = std::ranges::lower_bound(points.nodes, std::pair(y << 20, x << 20), {}, row);
    return static_cast<std::uint32_t>(at - points.nodes.begin());
  };
  Progress progress;
  const auto hull = delaunay_selector::find_hull(points);
  const std::vector<std::array<std::uint32_t, 2>> line{{number(20, 20), number(45, 45)}};
  const auto lined = delaunay_selector::with_lines(points, *hull, line, {}, progress);
  const delaunay_selector::SpatialOrder order(points, lined->domain);
  auto history = build_history({.frame = points,
                                .range = height_range(points),
                                .samples = order.samples(),
                                .triangles = order.triangles,
                                .lines = order.lines,
                                .n_left_out = 0},
                               1.5, model, progress);
  EXPECT_TRUE(history) << history.error().message;
  history->sample_type = "points";
  return {*std::move(history), {20, 6, 1.5}};
}

inline History history_of(const HeightGrid& grid, double max_error, Model model) {
  Progress progress;
  auto made = model == Model::implicit_delaunay_pyramid
                  ? implicit_pyramid::build(grid, progress)
                  : build_history(grid, max_error, model, progress);
  EXPECT_TRUE(made) << made.error().message;
  return *std::move(made);
}

/// It fills the domain, errs by no more, and has the samples' heights.
inline void expect_true(const Tin& tin, const HeightGrid& grid, double max_error) {
  delaunay::test::expect_fills(tin, grid);
  EXPECT_LE(static_cast<double>(delaunay::test::largest_error(tin, grid)), max_error);
  for (std::size_t i = 0; i < tin.vertices.size(); ++i)
    EXPECT_EQ(tin.heights[i], grid.height(tin.vertices[i].x, tin.vertices[i].y));
}

/// The fewest nodes by the definition: rounds over all triangles until nothing changes.
inline AppliedNodes by_rounds(const History& history, const Demand& demand) {
  AppliedNodes applied(history.n_nodes());
  const auto was_made = [&](std::uint32_t t) {
    return history.birth(t) == kNone || applied[history.birth(t)];
  };
  for (bool changes = true; changes;) {
    changes = false;
    for (std::uint32_t t = 0; t < history.triangles.size(); ++t) {
      const std::uint32_t death = history.triangles[t].death;
      if (death == kNone || applied[death] || !was_made(t)) continue;
      if (!(demand(facts_of(history, history.triangles[t])) > 0)) continue;
      applied[death] = true;
      changes = true;
    }
    for (std::uint32_t node = 0; node < history.n_nodes(); ++node)
      if (applied[node])
        for (const std::uint32_t t : history.removed_by(node))
          if (!was_made(t)) {
            applied[history.birth(t)] = true;
            changes = true;
          }
  }
  return applied;
}

inline Demand box_demand(double inside, double outside) {
  return FocusDemand{
      .foci = {BoxFocus{{{{10, 5, -1e9}}, {{19, 12, 1e9}}}}}, .inside = inside, .outside = outside};
}

}  // namespace lode::insertions::test
