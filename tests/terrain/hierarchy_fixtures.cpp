#include "tests/terrain/hierarchy_fixtures.h"

#include <optional>
#include <set>

namespace lode::test {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

int level_of(const Hierarchy& h, std::uint32_t triangle) {
  int level = 0;
  while (triangle >= h.triangles_until[static_cast<std::size_t>(level)]) ++level;
  return level;
}

/// The directed edges of a refinement that no other of its triangles has the other way, by their
/// starts; each start once.
std::map<std::uint32_t, std::uint32_t> border_of(const Hierarchy& h, std::uint32_t refinement) {
  const auto [first, end] = h.triangles_of(refinement);
  std::set<Edge> edges;
  for (std::uint32_t t = first; t < end; ++t)
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_TRUE(
          edges.insert({h.triangles[t].corner[i], h.triangles[t].corner[(i + 1) % 3]}).second);
  std::map<std::uint32_t, std::uint32_t> border;
  for (const auto& [from, to] : edges)
    if (!edges.contains({to, from})) EXPECT_TRUE(border.emplace(from, to).second);
  return border;
}

/// Once round from corner to corner; vertices between them are next to the edge.
void expect_border(const Hierarchy& h, std::uint32_t refinement) {
  const auto border = border_of(h, refinement);
  const auto& corner = h.triangles[h.refinements[refinement].triangle].corner;
  std::size_t n_passed = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint a = h.vertices[corner[i]];
    const LatticePoint b = h.vertices[corner[(i + 1) % 3]];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    for (std::uint32_t at = corner[i]; at != corner[(i + 1) % 3];) {
      const auto step = border.find(at);
      ASSERT_NE(step, border.end());
      ASSERT_LE(++n_passed, border.size());
      at = step->second;
      const auto off = static_cast<double>(delaunay::doubled_area(a, b, h.vertices[at])) / length;
      EXPECT_LE(std::abs(off), h.reach);
    }
  }
  EXPECT_EQ(n_passed, border.size());
}

/// By how much an edge errs where it crosses lines of samples that run along `along` (0: rows).
long double edge_error(const Hierarchy& h, std::uint32_t from, std::uint32_t to, int along,
                       const HeightGrid& grid) {
  const std::int64_t scale = h.scale();
  const auto place = [&](std::uint32_t v) {
    const LatticePoint p = h.vertices[v];
    return along == 0 ? std::pair<std::int64_t, std::int64_t>(p.y, p.x)
                      : std::pair<std::int64_t, std::int64_t>(p.x, p.y);
  };
  const auto z = [&](std::int64_t line, std::int64_t at) -> std::optional<double> {
    const auto x = static_cast<std::int32_t>(along == 0 ? at : line);
    const auto y = static_cast<std::int32_t>(along == 0 ? line : at);
    if (x >= grid.n_columns || y >= grid.n_rows || !grid.has_height(x, y)) return {};
    return grid.height(x, y);
  };
  const auto [line_a, at_a] = place(from);
  const auto [line_b, at_b] = place(to);
  long double worst = 0;
  for (std::int64_t line = std::min(line_a, line_b) / scale + 1;
       line * scale < std::max(line_a, line_b); ++line) {
    const long double t =
        static_cast<long double>(line * scale - line_a) / static_cast<long double>(line_b - line_a);
    const long double at = (at_a + t * static_cast<long double>(at_b - at_a)) / scale;
    const auto below = static_cast<std::int64_t>(std::floor(at));
    const long double share = at - below;
    const auto low = z(line, below);
    const auto high = share == 0 ? low : z(line, below + 1);
    if (!low || !high) continue;
    const long double edge = h.heights[from] + t * (h.heights[to] - h.heights[from]);
    worst = std::max(worst, std::abs(*low + share * (*high - *low) - edge));
  }
  return worst;
}

/// The largest error of the samples in a triangle, and of its edges.
long double true_error(const Hierarchy& h, std::uint32_t triangle, const HeightGrid& grid) {
  const auto& corner = h.triangles[triangle].corner;
  const LatticePoint a = h.vertices[corner[0]];
  const LatticePoint b = h.vertices[corner[1]];
  const LatticePoint c = h.vertices[corner[2]];
  const auto area = static_cast<long double>(delaunay::doubled_area(a, b, c));
  const auto [left, right] = std::minmax({a.x, b.x, c.x});
  const auto [low, high] = std::minmax({a.y, b.y, c.y});
  long double worst = 0;
  for (std::int32_t y = low / h.scale(); y <= high / h.scale(); ++y)
    for (std::int32_t x = left / h.scale(); x <= right / h.scale(); ++x) {
      const LatticePoint p{x * h.scale(), y * h.scale()};
      const std::int64_t wa = delaunay::doubled_area(b, c, p);
      const std::int64_t wb = delaunay::doubled_area(c, a, p);
      const std::int64_t wc = delaunay::doubled_area(a, b, p);
      if (wa < 0 || wb < 0 || wc < 0 || !grid.has_height(x, y)) continue;
      const long double plane = (wa * static_cast<long double>(h.heights[corner[0]]) +
                                 wb * static_cast<long double>(h.heights[corner[1]]) +
                                 wc * static_cast<long double>(h.heights[corner[2]])) /
                                area;
      worst = std::max(worst, std::abs(grid.height(x, y) - plane));
    }
  for (std::size_t i = 0; i < 3; ++i)
    for (const int along : {0, 1})
      worst = std::max(worst, edge_error(h, corner[i], corner[(i + 1) % 3], along, grid));
  return worst;
}

/// A refinement is for a triangle that errs, or with an edge that does, as that is split.
void expect_erred(const Hierarchy& h, std::uint32_t refinement, const HeightGrid* grid) {
  const std::uint32_t refined = h.refinements[refinement].triangle;
  const int level = level_of(h, h.triangles_of(refinement)[0]);
  const double tolerance = h.tolerances[static_cast<std::size_t>(level)];
  const bool has_split_edge = border_of(h, refinement).size() > 3;
  EXPECT_TRUE(static_cast<double>(h.triangles[refined].error) > tolerance || has_split_edge)
      << "triangle " << refined << " states " << h.triangles[refined].error << " at " << tolerance;
  if (grid == nullptr) return;
  const HeightRange range = height_range(*grid);
  const double rounding = 0x1p-48 * std::max(std::abs(range.lower), std::abs(range.upper));
  const auto error = static_cast<double>(true_error(h, refined, *grid));
  EXPECT_GT(error + rounding, tolerance) << "triangle " << refined << " at level " << level;
}

}  // namespace

void expect_hierarchy(const Hierarchy& h, const HeightGrid* grid) {
  for (std::uint32_t r = 0; r < h.refinements.size(); ++r) {
    const auto [first, end] = h.triangles_of(r);
    const std::uint32_t refined = h.refinements[r].triangle;
    EXPECT_EQ(h.triangles[refined].refinement, r);
    EXPECT_GE(end - first, 2U);
    EXPECT_EQ(level_of(h, first), level_of(h, end - 1));
    EXPECT_LT(level_of(h, refined), level_of(h, first));
    expect_border(h, r);
    expect_erred(h, r, grid);
  }
  std::size_t n_refined = 0;
  for (const Hierarchy::Triangle& t : h.triangles)
    n_refined += t.refinement != triangle_hierarchy::kNone;
  EXPECT_EQ(n_refined, h.refinements.size());
  const std::size_t n_finest = h.triangles.size() - n_refined;
  EXPECT_LT(h.triangles.size(), 2 * n_finest);
}

}  // namespace lode::test
