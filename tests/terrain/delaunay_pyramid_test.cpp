#include <cmath>
#include <map>
#include <set>

#include "lode/models/terrain/delaunay_pyramid/encodings.h"
#include "lode/models/terrain/delaunay_selector/selector.h"
#include "lode/models/terrain/insertions/history_locator.h"
#include "lode/models/terrain/insertions/overlap.h"
#include "tests/terrain/insertions_fixtures.h"

namespace lode::delaunay_pyramid {
namespace {

using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::TinLinks;
using insertions::HistoryLocator;
using insertions::holds;
using insertions::LatticeCorners;
using insertions::test::Case;
using insertions::test::cases;
using insertions::test::expect_true;
using insertions::test::grid_with_gaps;

History history_of(const HeightGrid& grid, double max_error) {
  return insertions::test::history_of(grid, max_error, insertions::Model::delaunay_pyramid);
}

constexpr std::array kLevels{400.0, 200.0, 90.0, 30.0, 30.0 / 4, 2.0};

using PlacedTriangle = std::array<std::pair<std::int32_t, std::int32_t>, 3>;

/// What a mesh is, whatever its numbers and order.
std::multiset<PlacedTriangle> shape_of(const Tin& tin) {
  std::multiset<PlacedTriangle> shape;
  for (const auto& corners : tin.triangles) {
    PlacedTriangle placed;
    for (std::size_t i = 0; i < 3; ++i)
      placed[i] = {tin.vertices[corners[i]].x, tin.vertices[corners[i]].y};
    std::ranges::rotate(placed, std::ranges::min_element(placed));
    shape.insert(placed);
  }
  return shape;
}

TEST(delaunay_pyramid, has_the_selectors_mesh_at_every_tolerance) {
  for (const Case& c : cases()) {
    const History history = history_of(c.grid, 2);
    for (const double tolerance : {1000.0, 400.0, 123.0, 50.0, 7.5, 2.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const Tin tin = tin_at(history, time_within(history, tolerance), TinLinks::kept);
      expect_true(tin, c.grid, tolerance);
      delaunay::test::expect_locally_delaunay(tin);
      Progress progress;
      const auto selected = delaunay_selector::select_samples(
          c.grid, {.max_error = tolerance, .order = delaunay::InsertionOrder::strict}, progress);
      ASSERT_TRUE(selected);
      // Errors are rounded up by less than a part in 128: few insertions more.
      EXPECT_LE(selected->tin.triangles.size(), tin.triangles.size());
      EXPECT_LE(static_cast<double>(tin.triangles.size()),
                8 + 1.1 * static_cast<double>(selected->tin.triangles.size()));
    }
  }
}

TEST(delaunay_pyramid, encodings_have_one_mesh_at_each_level) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const History history = history_of(c.grid, 2);
    const auto times = times_of(history, kLevels);
    const auto complete = CompletePyramid::make(history, times, {}, progress);
    const auto plain = TriangleLists::make(history, times, Interference::left_out, {}, progress);
    const auto linked = TriangleLists::make(history, times, Interference::linked, {}, progress);
    ASSERT_TRUE(complete && plain && linked);
    ASSERT_EQ(complete->levels().size(), kLevels.size());
    ASSERT_EQ(linked->n_levels(), kLevels.size());
    for (std::size_t level = 0; level < kLevels.size(); ++level) {
      const Tin tin = tin_at(history, times[level], TinLinks::kept);
      const auto shape = shape_of(tin);
      EXPECT_EQ(shape_of(complete->extract(history, level)), shape);
      EXPECT_EQ(shape_of(plain->extract(history, level)), shape);
      EXPECT_EQ(shape_of(linked->extract(history, level)), shape);
      expect_true(tin, c.grid, kLevels[level]);
    }
    // Each triangle once.
    EXPECT_LE(plain->entries().size(), history.triangles.size());
    EXPECT_LE(linked->n_links(), complete->n_links());
  }
}

/// Twice the area in which two triangles meet, by clipping one at the other, in doubles.
double common_area(const LatticeCorners& a, const LatticeCorners& b) {
  std::vector<std::array<double, 2>> polygon;
  for (const LatticePoint& p : a)
    polygon.push_back({static_cast<double>(p.x), static_cast<double>(p.y)});
  for (std::size_t i = 0; i < 3; ++i) {
    const LatticePoint from = b[i];
    const LatticePoint to = b[(i + 1) % 3];
    const auto side = [&](const std::array<double, 2>& p) {
      return (to.x - from.x) * (p[1] - from.y) - (to.y - from.y) * (p[0] - from.x);
    };
    std::vector<std::array<double, 2>> clipped;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const auto& p = polygon[k];
      const auto& q = polygon[(k + 1) % polygon.size()];
      const double sp = side(p);
      const double sq = side(q);
      if (sp >= 0) clipped.push_back(p);
      if ((sp > 0 && sq < 0) || (sp < 0 && sq > 0)) {
        const double t = sp / (sp - sq);
        clipped.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
      }
    }
    polygon = clipped;
    if (polygon.empty()) return 0;
  }
  double sum = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const auto& p = polygon[k];
    const auto& q = polygon[(k + 1) % polygon.size()];
    sum += p[0] * q[1] - p[1] * q[0];
  }
  return sum;
}

LatticeCorners places_of(const History& history, const std::array<std::uint32_t, 3>& corner) {
  return {history.vertices[corner[0]], history.vertices[corner[1]], history.vertices[corner[2]]};
}

bool have_boxes_in_common(const LatticeCorners& a, const LatticeCorners& b) {
  const auto x = [](const LatticePoint& p, const LatticePoint& q) { return p.x < q.x; };
  const auto y = [](const LatticePoint& p, const LatticePoint& q) { return p.y < q.y; };
  const auto [left, right] = std::ranges::minmax(a, x);
  const auto [low, high] = std::ranges::minmax(a, y);
  return std::ranges::min(b, x).x < right.x && left.x < std::ranges::max(b, x).x &&
         std::ranges::min(b, y).y < high.y && low.y < std::ranges::max(b, y).y;
}

/// Triangles of lattices have at least this much in common, or nothing.
constexpr double kSomeArea = 1e-7;

TEST(delaunay_pyramid, links_are_those_of_all_pairs) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const History history = history_of(c.grid, 30);
    const auto times = times_of(history, std::span(kLevels).first(4));
    const auto complete = CompletePyramid::make(history, times, {}, progress);
    const auto lists = TriangleLists::make(history, times, Interference::linked, {}, progress);
    ASSERT_TRUE(complete && lists);
    for (std::size_t level = 0; level + 1 < times.size(); ++level) {
      const auto& upper = complete->levels()[level];
      const auto& lower = complete->levels()[level + 1];
      for (std::uint32_t t = 0; t < upper.triangles.size(); ++t) {
        std::vector<std::uint32_t> expected;
        for (std::uint32_t s = 0; s < lower.triangles.size(); ++s)
          if (have_boxes_in_common(places_of(history, upper.triangles[t]),
                                   places_of(history, lower.triangles[s])) &&
              common_area(places_of(history, upper.triangles[t]),
                          places_of(history, lower.triangles[s])) > kSomeArea)
            expected.push_back(s);
        const auto links = upper.links.of(t);
        EXPECT_EQ(std::vector(links.begin(), links.end()), expected);
      }
    }
    const auto entries = lists->entries();
    for (std::uint32_t e = 0; e < entries.size(); ++e) {
      const LatticeCorners own = places_of(history, entries[e].corner);
      double area = 0;
      for (const std::uint32_t link : lists->links_of(e)) {
        EXPECT_GT(link, e);
        EXPECT_GT(entries[link].death, entries[e].death) << "is not of the level of its death";
        const double common = common_area(own, places_of(history, entries[link].corner));
        EXPECT_GT(common, kSomeArea);
        area += common;
      }
      // What is linked covers it once, so none is missing.
      const auto doubled = static_cast<double>(delaunay::doubled_area(own[0], own[1], own[2]));
      if (entries[e].death < times.size()) EXPECT_NEAR(area, doubled, 1e-6 * doubled);
    }
  }
}

TEST(delaunay_pyramid, finds_places_and_windows_as_a_search_does) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    Progress progress;
    const History history = history_of(c.grid, 2);
    const HistoryLocator locator(history);
    const auto times = times_of(history, kLevels);
    const auto complete = CompletePyramid::make(history, times, {}, progress);
    const auto lists = TriangleLists::make(history, times, Interference::linked, {}, progress);
    ASSERT_TRUE(complete && lists);
    const Window window{{c.grid.n_columns / 4, c.grid.n_rows / 3},
                        {c.grid.n_columns / 2, c.grid.n_rows / 3 + 2}};
    for (std::size_t level = 0; level < times.size(); ++level) {
      const Tin tin = tin_at(history, times[level], TinLinks::left_out);
      for (std::int32_t y = 0; y < c.grid.n_rows; ++y)
        for (std::int32_t x = 0; x < c.grid.n_columns; ++x) {
          const LatticePoint p{x, y};
          const bool is_inside = std::ranges::any_of(tin.triangles, [&](const auto& corners) {
            return holds(
                {tin.vertices[corners[0]], tin.vertices[corners[1]], tin.vertices[corners[2]]}, p);
          });
          const auto in_history = locator.find(insertions::NodeSet(times[level]),
                                               {{static_cast<double>(x), static_cast<double>(y)}});
          const auto in_complete = complete->locate(history, level, p);
          const auto in_lists = lists->locate(history, level, p);
          ASSERT_EQ(in_history.has_value(), is_inside);
          ASSERT_EQ(in_complete.has_value(), is_inside);
          ASSERT_EQ(in_lists.has_value(), is_inside);
          if (!is_inside) continue;
          EXPECT_GE(history.triangles[*in_history].death, times[level]);
          EXPECT_LT(*in_history, history.first_made[times[level]]);
          EXPECT_TRUE(holds(places_of(history, history.triangles[*in_history].corner), p));
          EXPECT_TRUE(
              holds(places_of(history, complete->levels()[level].triangles[*in_complete]), p));
          EXPECT_TRUE(holds(places_of(history, lists->entries()[*in_lists].corner), p));
        }
      const auto corners_in = [&](const std::vector<std::uint32_t>& found, const auto& corner_of) {
        std::multiset<std::array<std::uint32_t, 3>> corners;
        for (const std::uint32_t t : found) corners.insert(corner_of(t));
        return corners;
      };
      const auto seen = corners_in(zoom_in(history, insertions::NodeSet(times[level]), window),
                                   [&](std::uint32_t t) { return history.triangles[t].corner; });
      EXPECT_EQ(corners_in(complete->zoom(history, level, window),
                           [&](std::uint32_t t) { return complete->levels()[level].triangles[t]; }),
                seen);
      EXPECT_EQ(corners_in(lists->zoom(history, level, window),
                           [&](std::uint32_t t) { return lists->entries()[t].corner; }),
                seen);
      // Of all samples in the window, each has its triangles there.
      for (std::int32_t y = window.lower.y; y <= window.upper.y; ++y)
        for (std::int32_t x = window.lower.x; x <= window.upper.x; ++x)
          for (std::uint32_t t = 0; t < history.first_made[times[level]]; ++t)
            if (history.triangles[t].death >= times[level] &&
                holds(places_of(history, history.triangles[t].corner), {x, y}))
              EXPECT_TRUE(seen.contains(history.triangles[t].corner));
    }
  }
}

TEST(delaunay_pyramid, refuses_links_beyond_its_memory) {
  Progress progress;
  const History history = history_of(cases()[0].grid, 2);
  const auto times = times_of(history, kLevels);
  const auto refused = CompletePyramid::make(history, times, {.n_bytes = 1000}, progress);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("interference links"), std::string::npos);
  EXPECT_FALSE(
      TriangleLists::make(history, times, Interference::linked, {.n_bytes = 1000}, progress));
  EXPECT_TRUE(
      TriangleLists::make(history, times, Interference::left_out, {.n_bytes = 1000}, progress));
}

}  // namespace
}  // namespace lode::delaunay_pyramid
