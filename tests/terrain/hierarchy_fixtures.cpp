#include "tests/terrain/hierarchy_fixtures.h"

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

}  // namespace

void expect_hierarchy(const Hierarchy& h) {
  for (std::uint32_t r = 0; r < h.refinements.size(); ++r) {
    const auto [first, end] = h.triangles_of(r);
    const std::uint32_t refined = h.refinements[r].triangle;
    EXPECT_EQ(h.triangles[refined].refinement, r);
    EXPECT_GE(end - first, 2U);
    EXPECT_EQ(level_of(h, first), level_of(h, end - 1));
    EXPECT_LT(level_of(h, refined), level_of(h, first));
    expect_border(h, r);
  }
  std::size_t n_refined = 0;
  for (const Hierarchy::Triangle& t : h.triangles)
    n_refined += t.refinement != triangle_hierarchy::kNone;
  EXPECT_EQ(n_refined, h.refinements.size());
  const std::size_t n_finest = h.triangles.size() - n_refined;
  EXPECT_LT(h.triangles.size(), 2 * n_finest);
}

}  // namespace lode::test
