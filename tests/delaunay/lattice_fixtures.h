#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "lode/core/height_grid.h"
#include "lode/delaunay/tin.h"
#include "tests/oracles/random.h"

namespace lode::delaunay::test {

using Corners = std::array<std::uint32_t, 3>;
__extension__ using Int128 = __int128;

/// Heights by a rule z(x, y).
template <typename T, typename Rule>
HeightGrid make_grid(std::int32_t n_columns, std::int32_t n_rows, const Rule& rule) {
  HeightGrid grid = make_height_grid<T>(n_columns, n_rows);
  auto& samples = std::get<HeightGrid::Samples<T>>(grid.heights);
  for (std::int32_t y = 0; y < n_rows; ++y)
    for (std::int32_t x = 0; x < n_columns; ++x)
      samples[static_cast<std::size_t>(y * grid.stride + x)] = static_cast<T>(rule(x, y));
  return grid;
}

/// Whole numbers: smooth, but for some spikes.
inline double spiky_hills(std::int32_t x, std::int32_t y) {
  const bool is_spike = (x * 7 + y * 13) % 61 == 0;
  return std::round(300 * std::sin(0.21 * x) * std::cos(0.17 * y)) + (is_spike ? 64 : 0);
}

inline void set_missing(HeightGrid& grid, std::int32_t x, std::int32_t y) {
  if (grid.is_valid.empty()) grid.is_valid.assign(static_cast<std::size_t>(grid.n_samples()), 1);
  grid.is_valid[static_cast<std::size_t>(y * grid.n_columns + x)] = 0;
}

inline bool has_cell(const HeightGrid& grid, std::int32_t x, std::int32_t y) {
  return x >= 0 && y >= 0 && x + 1 < grid.n_columns && y + 1 < grid.n_rows &&
         grid.has_height(x, y) && grid.has_height(x + 1, y) && grid.has_height(x, y + 1) &&
         grid.has_height(x + 1, y + 1);
}

/// The sign of the determinant that is positive for d inside the circle of a, b, c turning left,
/// written out from its definition.
inline int circle_sign(LatticePoint a, LatticePoint b, LatticePoint c, LatticePoint d) {
  std::array<std::array<Int128, 3>, 3> m{};
  const std::array<LatticePoint, 3> points{a, b, c};
  for (std::size_t i = 0; i < 3; ++i) {
    const Int128 x = points[i].x - d.x;
    const Int128 y = points[i].y - d.y;
    m[i] = {x, y, x * x + y * y};
  }
  const Int128 determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return (determinant > 0) - (determinant < 0);
}

/// Positive triangles that fill the cells with four heights exactly once: areas add up, each inner
/// edge is used once each way, and the others are steps of the outline, each once. The grid's
/// columns and rows are `scale` of the TIN's apart.
inline void expect_fills(const Tin& tin, const HeightGrid& grid, std::int32_t scale = 1) {
  using Step = std::array<std::int32_t, 4>;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::int64_t area = 0;
  for (const Corners& t : tin.triangles) {
    const std::int64_t own =
        doubled_area(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]);
    EXPECT_GT(own, 0);
    area += own;
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_TRUE(edges.insert({t[i], t[(i + 1) % 3]}).second) << "an edge is used twice";
  }
  std::multiset<Step> border;
  for (const auto& [a, b] : edges) {
    if (edges.contains({b, a})) continue;
    LatticePoint p = tin.vertices[a];
    LatticePoint q = tin.vertices[b];
    ASSERT_TRUE(p.x == q.x || p.y == q.y) << "a border edge that is oblique";
    for (LatticePoint* end : {&p, &q}) {
      ASSERT_TRUE(end->x % scale == 0 && end->y % scale == 0) << "a border vertex is no sample";
      *end = {end->x / scale, end->y / scale};
    }
    const std::int32_t dx = (q.x > p.x) - (q.x < p.x);
    const std::int32_t dy = (q.y > p.y) - (q.y < p.y);
    for (LatticePoint s = p; s != q; s = {s.x + dx, s.y + dy})
      border.insert({s.x, s.y, s.x + dx, s.y + dy});
  }
  std::multiset<Step> outline;
  std::int64_t n_cells = 0;
  for (std::int32_t y = 0; y + 1 < grid.n_rows; ++y)
    for (std::int32_t x = 0; x + 1 < grid.n_columns; ++x) {
      if (!has_cell(grid, x, y)) continue;
      ++n_cells;
      if (!has_cell(grid, x, y - 1)) outline.insert({x, y, x + 1, y});
      if (!has_cell(grid, x + 1, y)) outline.insert({x + 1, y, x + 1, y + 1});
      if (!has_cell(grid, x, y + 1)) outline.insert({x + 1, y + 1, x, y + 1});
      if (!has_cell(grid, x - 1, y)) outline.insert({x, y + 1, x, y});
    }
  EXPECT_EQ(area, 2 * n_cells * scale * scale);
  EXPECT_EQ(border, outline);
}

/// Across no inner edge does a triangle's circle hold the other's corner.
inline void expect_locally_delaunay(const Tin& tin) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> across;
  for (const Corners& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) across[{t[i], t[(i + 1) % 3]}] = t[(i + 2) % 3];
  for (const Corners& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto other = across.find({t[(i + 1) % 3], t[i]});
      if (other == across.end()) continue;
      EXPECT_LE(circle_sign(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]],
                            tin.vertices[other->second]),
                0);
    }
}

/// No circle holds any vertex at all: Delaunay of a convex domain, by its definition.
inline void expect_empty_circles(const Tin& tin) {
  for (const Corners& t : tin.triangles)
    for (const LatticePoint& p : tin.vertices)
      EXPECT_LE(circle_sign(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]], p), 0);
}

/// The largest vertical error of a sample, by trying every triangle for every sample. Exact for
/// heights of up to 24 bits.
inline long double largest_error(const Tin& tin, const HeightGrid& grid) {
  long double largest = 0;
  for (std::int32_t y = 0; y < grid.n_rows; ++y)
    for (std::int32_t x = 0; x < grid.n_columns; ++x)
      for (const Corners& t : tin.triangles) {
        const LatticePoint p{x, y};
        const LatticePoint a = tin.vertices[t[0]];
        const LatticePoint b = tin.vertices[t[1]];
        const LatticePoint c = tin.vertices[t[2]];
        const std::int64_t wa = doubled_area(b, c, p);
        const std::int64_t wb = doubled_area(c, a, p);
        const std::int64_t wc = doubled_area(a, b, p);
        if (wa < 0 || wb < 0 || wc < 0) continue;
        const long double plane = static_cast<long double>(wa) * grid.height(a.x, a.y) +
                                  static_cast<long double>(wb) * grid.height(b.x, b.y) +
                                  static_cast<long double>(wc) * grid.height(c.x, c.y);
        const auto area = static_cast<long double>(wa + wb + wc);
        largest = std::max(largest, std::abs(grid.height(x, y) * area - plane) / area);
      }
  return largest;
}

}  // namespace lode::delaunay::test
