// Right triangles bisected over rasters of any size, with and without gaps in their heights.
#include <cmath>
#include <limits>
#include <map>

#include "lode/mappers/tin_gaps.h"
#include "lode/models/terrain/right_triangle_bisection/extract.h"
#include "lode/models/terrain/right_triangle_bisection/locate.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/oracles/random.h"
#include "tests/oracles/trials.h"
#include "tests/terrain/bisection_fixtures.h"

namespace lode {
namespace {

using bisection::Bisection;
using bisection::Diamond;
using bisection::Lattice;
using bisection::test::build;
using bisection::test::diamonds_of;
using bisection::test::hills;
using bisection::test::random_grid;
using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::test::has_cell;
using delaunay::test::make_grid;
using delaunay::test::set_missing;

struct Case {
  const char* name;
  HeightGrid grid;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  all.push_back({"a cell", make_grid<double>(2, 2, hills)});
  all.push_back({"two cells", make_grid<std::int16_t>(3, 2, hills)});
  all.push_back({"three rows", make_grid<std::uint16_t>(
                                   3, 3, [](int x, int y) { return 65535.0 * ((x + y) % 2); })});
  all.push_back({"a power of two and one", make_grid<std::int16_t>(65, 65, hills)});
  all.push_back({"a power of two", make_grid<std::int16_t>(64, 64, hills)});
  all.push_back({"odd", make_grid<float>(45, 22, hills)});
  all.push_back({"a strip", make_grid<std::int16_t>(2, 40, hills)});
  all.push_back({"wide", make_grid<std::int16_t>(300, 37, hills)});
  all.push_back({"large", make_grid<std::int16_t>(273, 290, hills)});
  // Differences of these heights are not what float64 makes of them.
  all.push_back({"rounded", make_grid<double>(21, 49, [](int x, int y) {
                   return std::exp2(y % 5 * 9) * std::sin(0.7 * x + y) / 3;
                 })});
  all.push_back(
      {"tenths", make_grid<float>(70, 41, [](int x, int y) { return hills(x, y) / 10; })});
  all.push_back({"flat", make_grid<float>(40, 17, [](int, int) { return 0.1; })});
  all.push_back(
      {"slanted", make_grid<std::int16_t>(50, 33, [](int x, int y) { return 3 * x - 2 * y; })});
  // Whole numbers of steps in floating point, with and without rounding of their own.
  all.push_back({"tenths of float64", make_grid<double>(64, 48, [](int x, int y) {
                   return std::round(hills(x, y) * (x < 30 ? 7 : 0) - 23000) / 10;
                 })});
  all.push_back({"hundredths, some beside them", make_grid<double>(65, 40, [](int x, int y) {
                   const double z = x < 20 ? 12.34 : std::round(hills(x, y) * 31) / 100;
                   return (x * 5 + y * 3) % 11 == 0 ? std::nextafter(z, 1e9) : z;
                 })});
  all.push_back({"whole floats",
                 make_grid<float>(70, 64, [](int x, int y) { return 1e6 + 90 * hills(x, y); })});
  all.push_back({"multiples of 1/256", make_grid<float>(40, 66, [](int x, int y) {
                   return 40 + hills(x, y) / 16 + (x % 3) / 256.0;
                 })});
  all.push_back({"more than 16 bits apart", make_grid<double>(33, 20, [](int x, int y) {
                   return x == 4 && y == 5 ? 65536 : hills(x, y);
                 })});
  Case gaps{"gaps", make_grid<std::int16_t>(38, 41, hills)};
  for (std::int32_t y = 10; y < 17; ++y)
    for (std::int32_t x = 5; x < 9 + y / 2; ++x) set_missing(gaps.grid, x, y);
  set_missing(gaps.grid, 0, 40);
  set_missing(gaps.grid, 37, 20);
  set_missing(gaps.grid, 30, 30);
  all.push_back(std::move(gaps));
  Case holes{"missing values are no numbers", make_grid<float>(40, 29, hills)};
  for (std::int32_t i = 0; i < 30; ++i) {
    const std::int32_t x = i * 37 % 40;
    const std::int32_t y = i * 11 % 29;
    set_missing(holes.grid, x, y);
    std::get<HeightGrid::Samples<float>>(
        holes.grid.heights)[static_cast<std::size_t>(y * holes.grid.stride + x)] =
        std::numeric_limits<float>::quiet_NaN();
  }
  all.push_back(std::move(holes));
  return all;
}

constexpr std::array kTolerances{70000.0, 1000.0, 150.0, 40.0, 7.0, 0.5, 0.0};

/// From the definition, in long doubles: over all samples in a closed triangle.
long double triangle_error(LatticePoint a, LatticePoint b, LatticePoint c, const HeightGrid& grid) {
  const auto area = static_cast<long double>(delaunay::doubled_area(a, b, c));
  if (area == 0) return 0;
  long double worst = 0;
  for (std::int32_t y = std::min({a.y, b.y, c.y}); y <= std::max({a.y, b.y, c.y}); ++y)
    for (std::int32_t x = std::min({a.x, b.x, c.x}); x <= std::max({a.x, b.x, c.x}); ++x) {
      const auto u = static_cast<long double>(delaunay::doubled_area(b, c, {x, y}));
      const auto v = static_cast<long double>(delaunay::doubled_area(c, a, {x, y}));
      const auto w = static_cast<long double>(delaunay::doubled_area(a, b, {x, y}));
      if (u / area < 0 || v / area < 0 || w / area < 0) continue;
      const long double plane =
          u * grid.height(a.x, a.y) + v * grid.height(b.x, b.y) + w * grid.height(c.x, c.y);
      worst = std::max(worst, std::abs((plane - area * grid.height(x, y)) / area));
    }
  return worst;
}

/// Over the triangles that are there.
long double own_error(const Diamond& diamond, const Lattice& lattice, const HeightGrid& grid) {
  long double worst = 0;
  for (const LatticePoint apex : diamond.apexes)
    if (lattice.has(apex))
      worst = std::max(
          worst, triangle_error(lattice.place(diamond.ends[0]), lattice.place(diamond.ends[1]),
                                lattice.place(apex), grid));
  return worst;
}

double largest_error(const Tin& tin, const HeightGrid& grid) {
  long double worst = 0;
  for (const auto& t : tin.triangles)
    worst = std::max(
        worst, triangle_error(tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]], grid));
  return static_cast<double>(worst);
}

TEST(right_triangle_bisection, errors_are_the_largest_of_all_that_waits) {
  for (const Case& c : cases()) {
    if (!c.grid.is_valid.empty()) continue;
    SCOPED_TRACE(c.name);
    const Bisection made = build(c.grid);
    const Lattice& lattice = made.lattice();
    const bool is_whole_numbers = c.grid.heights.index() < 2;
    std::map<std::pair<std::int32_t, std::int32_t>, long double> nested;
    std::vector<Diamond> diamonds = diamonds_of(lattice);
    std::ranges::stable_sort(diamonds, [](const Diamond& p, const Diamond& q) {
      return std::pair(p.reach, p.is_square) < std::pair(q.reach, q.is_square);
    });
    for (const Diamond& diamond : diamonds) {
      long double error = own_error(diamond, lattice, c.grid);
      if (diamond.has_children())
        for (const LatticePoint child : diamond.children()) {
          const auto known = nested.find({child.x, child.y});
          if (known != nested.end()) error = std::max(error, known->second);
        }
      nested[{diamond.node.x, diamond.node.y}] = error;
      const auto found = static_cast<long double>(made.error(diamond.node));
      ASSERT_GE(found, error - 0x1p-60L * 65536) << diamond.node.x << ", " << diamond.node.y;
      // Stretched ones may be off by rounding of float32.
      ASSERT_LE(found, error * (1 + 1e-6L) + (is_whole_numbers ? 0.1L : 0.3L))
          << diamond.node.x << ", " << diamond.node.y;
    }
  }
}

TEST(right_triangle_bisection, errors_of_whole_numbers_are_exact) {
  const HeightGrid grid = make_grid<std::int16_t>(129, 129, hills);
  const Bisection made = build(grid);
  std::vector<Diamond> diamonds = diamonds_of(made.lattice());
  for (const Diamond& diamond : diamonds) {
    if (diamond.has_children() && diamond.reach < 32) continue;
    const long double own = own_error(diamond, made.lattice(), grid);
    long double error = own;
    if (diamond.has_children())
      for (const LatticePoint child : diamond.children())
        if (made.lattice().has(child))
          error = std::max(error, static_cast<long double>(made.error(child)));
    EXPECT_FLOAT_EQ(made.error(diamond.node), static_cast<float>(error));
  }
}

TEST(right_triangle_bisection, meshes_fill_the_domain_and_keep_their_tolerance) {
  for (const Case& c : cases()) {
    const Bisection made = build(c.grid);
    std::size_t n_last = 0;
    for (const double tolerance : kTolerances) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const Tin tin = tin_within(made, c.grid, tolerance);
      delaunay::test::expect_fills(tin, c.grid);
      EXPECT_LE(largest_error(tin, c.grid), tolerance + 0x1p-46 * 65536);
      EXPECT_EQ(measure_gaps(tin).n_hanging, 0U);
      EXPECT_GE(tin.triangles.size(), n_last);
      n_last = tin.triangles.size();
      EXPECT_EQ(count_triangles(made, tolerance, 1U << 30), n_last);
    }
  }
}

TEST(right_triangle_bisection, any_raster_is_filled_within_any_tolerance) {
  oracles::Random random(2026);
  for (int trial = 0; trial < oracles::trials(3000, 60); ++trial) {
    const HeightGrid grid = random_grid(random);
    SCOPED_TRACE(testing::Message() << "trial " << trial << ": " << grid.n_columns << " x "
                                    << grid.n_rows << ", type " << grid.heights.index());
    Progress progress;
    const auto made = Bisection::build(grid, {1 + trial % 2}, progress);
    if (!made) {
      EXPECT_NE(made.error().message.find("four heights"), std::string::npos);
      continue;
    }
    const HeightRange range = height_range(grid);
    const double rounding = 0x1p-45 * std::max(std::abs(range.lower), std::abs(range.upper));
    const double tolerance = (range.upper - range.lower) * std::exp2(random.uniform(-12, 0));
    for (const double within : {tolerance, 0.0}) {
      const Tin tin = tin_within(*made, grid, within);
      delaunay::test::expect_fills(tin, grid);
      EXPECT_LE(largest_error(tin, grid), within + rounding);
    }
    // Somewhere fine: still no gaps, and the tolerance holds there.
    const double middle = random.uniform(0, grid.n_columns);
    const Demand demand = [&](const NodeFacts& facts) {
      return facts.bounds.centre[0] - facts.bounds.half[0] <= middle ? facts.error - tolerance : 0;
    };
    const Tin varied = tin_of(*made, grid, select_nodes(*made, grid, range, demand));
    delaunay::test::expect_fills(varied, grid);
    const auto x =
        static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(grid.n_columns)));
    const auto y = static_cast<std::int32_t>(random.below(static_cast<std::uint64_t>(grid.n_rows)));
    EXPECT_EQ(find_triangle(*made, tolerance, x, y).has_value(), made->has_node({x, y}));
    const delaunay::Window all{{0, 0}, made->lattice().last()};
    EXPECT_EQ(count_in_window(*made, tolerance, all), count_triangles(*made, tolerance, 1U << 30));
    if (testing::Test::HasFailure()) return;
  }
}

TEST(right_triangle_bisection, planes_have_the_fewest_triangles) {
  const auto slanted = [](int x, int y) { return 3 * x - 2 * y; };
  const auto in_quarters = [](int x, int y) { return 0.25 * x - 7.75 * y + 1000; };
  const auto flat = [](int, int) { return 0.1; };
  for (const auto& [n_columns, n_rows] : {std::pair{50, 33}, {64, 64}, {65, 65}, {300, 41}}) {
    SCOPED_TRACE(testing::Message() << n_columns << " x " << n_rows);
    for (const HeightGrid& grid :
         {make_grid<std::int16_t>(n_columns, n_rows, slanted),
          make_grid<double>(n_columns, n_rows, slanted),
          make_grid<float>(n_columns, n_rows, in_quarters),
          make_grid<float>(n_columns, n_rows, flat), make_grid<double>(n_columns, n_rows, flat)}) {
      Bisection made = build(grid);
      EXPECT_EQ(tin_within(made, grid, 0).triangles.size(), 2U) << grid.heights.index();
      // The raster's corners are vertices anyway.
      const LatticePoint last = made.lattice().last();
      made.keep({{0, 0}, {last.x, 0}, {0, last.y}, last});
      EXPECT_EQ(tin_within(made, grid, 0).triangles.size(), 2U) << grid.heights.index();
      // Whoever asks for no error at a place gets no triangle for it where there is none.
      const Demand all = [](const NodeFacts&) { return 1.0; };
      EXPECT_EQ(
          tin_of(made, grid, select_nodes(made, grid, height_range(grid), all)).triangles.size(),
          2U);
    }
  }
}

TEST(right_triangle_bisection, holes_stay_whatever_the_tolerance) {
  for (const Case& c : cases())
    for (const double tolerance :
         {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::max()})
      delaunay::test::expect_fills(tin_within(build(c.grid), c.grid, tolerance), c.grid);
}

TEST(right_triangle_bisection, is_the_same_for_any_number_of_threads) {
  for (const Case& c : cases()) {
    const Bisection one = build(c.grid, 1);
    const Bisection more = build(c.grid, 7);
    for (const Diamond& diamond : diamonds_of(one.lattice()))
      ASSERT_EQ(one.error(diamond.node), more.error(diamond.node)) << c.name;
  }
}

TEST(right_triangle_bisection, a_demand_for_one_tolerance_is_that_mesh) {
  for (const Case& c : cases()) {
    const Bisection made = build(c.grid);
    for (const double tolerance : {150.0, 7.0}) {
      const Tin uniform = tin_within(made, c.grid, tolerance);
      const Demand demand = [tolerance](const NodeFacts& facts) { return facts.error - tolerance; };
      const Tin selected =
          tin_of(made, c.grid, select_nodes(made, c.grid, height_range(c.grid), demand));
      EXPECT_EQ(selected.triangles, uniform.triangles) << c.name << ", " << tolerance;
      EXPECT_EQ(selected.vertices, uniform.vertices) << c.name << ", " << tolerance;
    }
  }
}

TEST(right_triangle_bisection, is_fine_in_a_box_and_coarse_elsewhere) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Bisection made = build(c.grid);
    const double middle = c.grid.n_columns / 2.0;
    // Whatever reaches into the left half is to be within 7.
    const Demand demand = [middle](const NodeFacts& facts) {
      return facts.bounds.centre[0] - facts.bounds.half[0] <= middle ? facts.error - 7 : 0;
    };
    const Tin tin = tin_of(made, c.grid, select_nodes(made, c.grid, height_range(c.grid), demand));
    delaunay::test::expect_fills(tin, c.grid);
    EXPECT_EQ(measure_gaps(tin).n_hanging, 0U);
    EXPECT_LE(tin.triangles.size(), tin_within(made, c.grid, 7).triangles.size());
    Tin left;
    left.vertices = tin.vertices;
    left.heights = tin.heights;
    for (const auto& t : tin.triangles)
      if (std::ranges::any_of(t, [&](std::uint32_t v) { return tin.vertices[v].x <= middle; }))
        left.triangles.push_back(t);
    EXPECT_LE(largest_error(left, c.grid), 7);
  }
}

TEST(right_triangle_bisection, keeps_samples_as_vertices) {
  for (const Case& c : cases()) {
    if (c.grid.n_columns < 20) continue;
    SCOPED_TRACE(c.name);
    Bisection made = build(c.grid);
    std::vector<LatticePoint> kept;
    for (std::int32_t y = 0; y < c.grid.n_rows; y += 7)
      for (std::int32_t x = y % 5; x < c.grid.n_columns; x += 9) {
        bool is_in = false;
        for (const std::int32_t dy : {-1, 0})
          for (const std::int32_t dx : {-1, 0}) is_in = is_in || has_cell(c.grid, x + dx, y + dy);
        if (is_in) kept.push_back({x, y});
      }
    made.keep(kept);
    const Tin tin = tin_within(made, c.grid, 70000);
    delaunay::test::expect_fills(tin, c.grid);
    for (const LatticePoint p : kept)
      EXPECT_TRUE(std::ranges::find(tin.vertices, p) != tin.vertices.end()) << p.x << ", " << p.y;
  }
}

TEST(right_triangle_bisection, finds_the_tolerance_of_a_number_of_triangles) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Bisection made = build(c.grid);
    const std::uint64_t coarsest = tin_within(made, c.grid, 1e30).triangles.size();
    EXPECT_FALSE(tolerance_of_cells(made, coarsest - 1));
    for (const std::uint64_t most :
         {coarsest, coarsest + 7, 3 * coarsest, std::uint64_t{1} << 30}) {
      const auto tolerance = tolerance_of_cells(made, most);
      ASSERT_TRUE(tolerance);
      EXPECT_LE(tin_within(made, c.grid, *tolerance).triangles.size(), most);
      if (*tolerance > 0)
        EXPECT_GT(tin_within(made, c.grid, std::nextafter(static_cast<float>(*tolerance), 0.0F))
                      .triangles.size(),
                  most);
    }
  }
}

bool is_in(const std::array<LatticePoint, 3>& corners, LatticePoint p) {
  for (std::size_t i = 0; i < 3; ++i)
    if (delaunay::doubled_area(corners[i], corners[(i + 1) % 3], p) < 0) return false;
  return true;
}

using Places = std::set<std::pair<std::int32_t, std::int32_t>>;

Places places_of(const std::array<LatticePoint, 3>& corners) {
  Places places;
  for (const LatticePoint p : corners) places.insert({p.x, p.y});
  return places;
}

TEST(right_triangle_bisection, finds_the_triangles_of_its_meshes) {
  for (const Case& c : cases()) {
    const Bisection made = build(c.grid);
    for (const double tolerance : {150.0, 7.0}) {
      SCOPED_TRACE(testing::Message() << c.name << ", " << tolerance);
      const Tin tin = tin_within(made, c.grid, tolerance);
      std::set<Places> all;
      for (const auto& t : tin.triangles)
        all.insert(places_of({tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]}));
      for (std::int32_t y = 0; y < c.grid.n_rows; y += 3)
        for (std::int32_t x = y % 2; x < c.grid.n_columns; x += 2) {
          const auto found = find_triangle(made, tolerance, x, y);
          ASSERT_EQ(found.has_value(), made.has_node({x, y})) << x << ", " << y;
          if (!found) continue;
          EXPECT_TRUE(is_in(found->corners, {x, y})) << x << ", " << y;
          EXPECT_TRUE(all.contains(places_of(found->corners))) << x << ", " << y;
          EXPECT_LE(static_cast<double>(found->error), tolerance);
          EXPECT_LE(std::abs(height_in(*found, c.grid, x, y) - c.grid.height(x, y)),
                    static_cast<double>(found->error) + 1e-9);
        }
    }
  }
}

TEST(right_triangle_bisection, counts_what_meets_a_window) {
  for (const Case& c : cases()) {
    const Bisection made = build(c.grid);
    const Tin tin = tin_within(made, c.grid, 7);
    const LatticePoint last = made.lattice().last();
    for (const delaunay::Window& window : {delaunay::Window{{0, 0}, last},
                                           {{last.x / 3, last.y / 4}, {last.x / 2, last.y / 2}},
                                           {{last.x - 1, last.y - 1}, last},
                                           {{last.x + 5, 0}, {last.x + 9, 9}}}) {
      std::uint64_t n = 0;
      for (const auto& t : tin.triangles)
        if (meets_window({tin.vertices[t[0]], tin.vertices[t[1]], tin.vertices[t[2]]}, window)) ++n;
      EXPECT_EQ(count_in_window(made, 7, window), n) << c.name;
    }
  }
}

TEST(right_triangle_bisection, refuses_what_has_no_cell) {
  Progress progress;
  HeightGrid grid = make_grid<float>(3, 3, hills);
  set_missing(grid, 1, 1);
  const auto none = Bisection::build(grid, {1}, progress);
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("four heights"), std::string::npos);
  EXPECT_FALSE(Bisection::build(make_grid<float>(1, 9, hills), {1}, progress));
  EXPECT_FALSE(Bisection::build(make_grid<double>(3, 3, [](int x, int) { return 1e31 * x; }), {1},
                                progress));
  progress.cancel();
  EXPECT_FALSE(Bisection::build(make_grid<float>(9, 9, hills), {1}, progress));
}

}  // namespace
}  // namespace lode
