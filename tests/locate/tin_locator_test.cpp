#include "lode/locate/tin_locator.h"

#include <gtest/gtest.h>

#include "lode/locate/tin_height.h"
#include "tests/locate/tin_fixtures.h"

namespace lode::test {
namespace {

TEST(tin_locator, finds_a_triangle_exactly_where_one_holds_the_place) {
  for (const GridTin& one : all_tins()) {
    const TinLocator locator(one.tin);
    std::size_t n_inside = 0;
    for (const Point& p : hard_places(one, 5, 400)) {
      const std::uint32_t any = find_by_trying(one.tin, p);
      const auto found = locator.find(p);
      ASSERT_EQ(found.has_value(), any < one.tin.triangles.size())
          << one.name << ' ' << p[0] << ' ' << p[1];
      if (!found) continue;
      ++n_inside;
      ASSERT_TRUE(holds_exactly(one.tin, *found, p)) << one.name << ' ' << p[0] << ' ' << p[1];
      EXPECT_EQ(locator.find(p), found);
    }
    EXPECT_GT(n_inside, 500U) << one.name;
  }
}

TEST(tin_locator, finds_places_by_cells_whatever_is_missing) {
  const GridTin one = select_tin("holes", holey_grid(), 60);
  const TinLocator locator(one.tin);
  for (std::int32_t y = -1; y <= one.grid.n_rows; ++y)
    for (std::int32_t x = -1; x <= one.grid.n_columns; ++x)
      EXPECT_EQ(locator.find({{x + 0.5, y + 0.25}}).has_value(),
                delaunay::test::has_cell(one.grid, x, y))
          << x << ' ' << y;
}

TEST(tin_locator, finds_nothing_far_away) {
  const GridTin one = select_tin("hills", make_grid<std::int16_t>(50, 40, hilly), 40);
  const TinLocator locator(one.tin);
  for (const double far : {-1e300, -5e9, 5e9, 1e300}) {
    EXPECT_FALSE(locator.find({{far, 3}}));
    EXPECT_FALSE(locator.find({{3, far}}));
  }
}

TEST(tin_height, is_the_plane_of_any_triangle_that_holds_the_place) {
  for (const GridTin& one : all_tins())
    for (const Point& p : hard_places(one, 6, 100)) {
      const std::uint32_t t = find_by_trying(one.tin, p);
      if (t == one.tin.triangles.size()) continue;
      const TinHeight z = height_in(one.tin, t, p);
      // The oracle's own rounding, in 64 bits, is 2^-11 of what is allowed.
      EXPECT_LE(std::abs(z.height - plane_at(one.tin, t, p)), z.rounding) << one.name;
      EXPECT_LT(z.rounding, 1e-9);
    }
}

TEST(tin_height, is_the_samples_at_vertices) {
  const auto odd = [](std::int32_t x, std::int32_t y) { return hilly(x, y) / 3 + 1e7; };
  const GridTin one = select_tin("odd", make_grid<double>(40, 30, odd), 3);
  const TinLocator locator(one.tin);
  for (const LatticePoint& v : one.tin.vertices) {
    const Point p{{static_cast<double>(v.x), static_cast<double>(v.y)}};
    const auto t = locator.find(p);
    ASSERT_TRUE(t);
    EXPECT_EQ(height_in(one.tin, *t, p).height, odd(v.x, v.y));
  }
}

TEST(tin_height, is_within_the_triangles_error_at_samples) {
  for (const GridTin& one : all_tins()) {
    const TinLocator locator(one.tin);
    for (std::int32_t y = 0; y < one.grid.n_rows; ++y)
      for (std::int32_t x = 0; x < one.grid.n_columns; ++x) {
        const Point p{{static_cast<double>(x), static_cast<double>(y)}};
        const auto t = locator.find(p);
        if (!t) continue;
        const TinHeight z = height_in(one.tin, *t, p);
        EXPECT_LE(std::abs(z.height - one.grid.height(x, y)),
                  static_cast<double>(one.tin.errors[*t]) + z.rounding)
            << one.name;
      }
  }
}

}  // namespace
}  // namespace lode::test
