#include "lode/delaunay/greedy_insertion.h"

#include <cmath>
#include <limits>

#include "lode/delaunay/grid_domain.h"
#include "tests/delaunay/lattice_fixtures.h"
#include "tests/models/all_targets.h"

namespace lode::delaunay {
namespace {

struct Answer {
  Tin tin;
  GreedyReport report;
};

Answer insert(const HeightGrid& grid, const GreedyOptions& options) {
  const auto domain = find_domain(grid);
  EXPECT_TRUE(domain) << domain.error().message;
  const LatticePacking packing(grid.n_columns);
  LatticeMesh mesh(packing, domain->triangles);
  const HeightRange range = height_range(grid);
  Progress progress;
  const auto report = std::visit(
      [&](const auto& samples) {
        using T = typename std::decay_t<decltype(samples)>::value_type;
        return insert_greedily(mesh, SampleRows<T>{samples.data(), grid.stride, packing},
                               range.lower, range.upper, options, progress);
      },
      grid.heights);
  EXPECT_TRUE(report);
  return {to_tin(mesh), *report};
}

/// Hills, a plain and single spikes.
double terrain(std::int32_t x, std::int32_t y) {
  const double hills = 900 * std::sin(0.31 * x) * std::cos(0.23 * y + 0.01 * x * y);
  const bool is_plain = x + y < 18;
  const bool is_spike = (x * 7 + y * 13) % 31 == 0;
  return std::round((is_plain ? 0 : hills) + (is_spike ? 150 : 0)) + 2000;
}

/// |z - z'| at all samples in a triangle's box.
void expect_within(const LatticeMesh& mesh, const HeightGrid& grid, double max_error) {
  for (const LatticeTriangle& triangle : mesh.triangles()) {
    std::array<LatticePoint, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = mesh.nodes().unpack(triangle.corner[i]);
    const auto area = static_cast<double>(doubled_area(at[0], at[1], at[2]));
    const auto [left, right] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [low, high] = std::minmax({at[0].y, at[1].y, at[2].y});
    for (std::int32_t y = low; y <= high; ++y)
      for (std::int32_t x = left; x <= right; ++x) {
        const std::array<std::int64_t, 3> weight{doubled_area(at[1], at[2], {x, y}),
                                                 doubled_area(at[2], at[0], {x, y}),
                                                 doubled_area(at[0], at[1], {x, y})};
        if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
        double z = 0;
        for (std::size_t i = 0; i < 3; ++i)
          z += static_cast<double>(weight[i]) / area * grid.height(at[i].x, at[i].y);
        ASSERT_LE(std::abs(z - grid.height(x, y)), max_error + 1e-9);
        ASSERT_LE(std::abs(z - grid.height(x, y)), static_cast<double>(triangle.error) + 1e-9);
      }
  }
}

/// Rasters that are refined in regions, with a gap through several of them.
template <typename T>
HeightGrid large_grid() {
  HeightGrid grid = test::make_grid<T>(230, 190, [](std::int32_t x, std::int32_t y) {
    const auto mixed =
        (static_cast<std::uint32_t>(x) * 73856093U) ^ (static_cast<std::uint32_t>(y) * 19349663U);
    return std::round(2000 + 900 * std::sin(0.031 * x) * std::cos(0.023 * y) +
                      static_cast<double>(mixed * 2654435761U >> 24) / 4);
  });
  for (std::int32_t y = 40; y < 150; ++y)
    for (std::int32_t x = 90; x < 94 + y / 9; ++x) test::set_missing(grid, x, y);
  return grid;
}

template <typename T>
class regional_insertion : public testing::Test {};
using RegionalTypes = testing::Types<std::int16_t, float, double>;
TYPED_TEST_SUITE(regional_insertion, RegionalTypes);

TYPED_TEST(regional_insertion, is_delaunay_within_the_error_and_the_same_for_any_threads) {
  const HeightGrid grid = large_grid<TypeParam>();
  const auto domain = find_domain(grid);
  ASSERT_TRUE(domain);
  const LatticePacking packing(grid.n_columns);
  const HeightRange range = height_range(grid);
  for (const double max_error : {0.0, 0.8, 4.0}) {
    SCOPED_TRACE(max_error);
    const auto make = [&](int n_threads, InsertionOrder order) {
      LatticeMesh mesh(packing, domain->triangles);
      const auto& samples = std::get<HeightGrid::Samples<TypeParam>>(grid.heights);
      Progress progress;
      const auto report = insert_greedily(
          mesh, SampleRows<TypeParam>{samples.data(), grid.stride, packing}, range.lower,
          range.upper, {.max_error = max_error, .order = order, .threads = {n_threads}}, progress);
      EXPECT_TRUE(report);
      EXPECT_LE(report->achieved_error, max_error);
      EXPECT_EQ(
          report->n_inserted + to_tin(LatticeMesh(packing, domain->triangles)).vertices.size(),
          to_tin(mesh).vertices.size());
      return mesh;
    };
    const LatticeMesh one = make(1, InsertionOrder::levels);
    ASSERT_GT(one.triangles().size(), 10'000U) << "else there are no regions";
    EXPECT_TRUE(one.is_delaunay());
    test::expect_fills(to_tin(one), grid);
    expect_within(one, grid, max_error);
    for (const int n_threads : {2, 3}) {
      const LatticeMesh other = make(n_threads, InsertionOrder::levels);
      EXPECT_EQ(to_tin(one).vertices, to_tin(other).vertices);
      EXPECT_EQ(to_tin(one).triangles, to_tin(other).triangles);
    }
    const std::size_t n_strict = make(1, InsertionOrder::strict).triangles().size();
    EXPECT_LE(one.triangles().size(), n_strict + n_strict / 33);
  }
}

/// Turning all edges that are not Delaunay makes a triangulation such.
TEST(lattice_mesh, becomes_delaunay_by_turning_edges) {
  const LatticePacking packing(256);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  // A fan over a comb: thin triangles from one corner.
  const auto node = [&](std::int32_t x, std::int32_t y) { return packing.pack({x, y}); };
  for (std::int32_t i = 1; i < 40; ++i)
    triangles.push_back(
        {node(0, 0), node(200 + (i * i) % 3, i - 1), node(200 + (i + 1) * (i + 1) % 3, i)});
  LatticeMesh mesh(packing, triangles);
  std::vector<std::uint32_t> suspects;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) suspects.push_back(4 * t + i);
  std::int64_t area = 0;
  const auto area_of = [&](const LatticeTriangle& t) {
    return doubled_area(packing.unpack(t.corner[0]), packing.unpack(t.corner[1]),
                        packing.unpack(t.corner[2]));
  };
  for (const LatticeTriangle& t : mesh.triangles()) area += area_of(t);
  EXPECT_FALSE(mesh.is_delaunay());
  EXPECT_FALSE(mesh.make_delaunay(suspects).empty());
  EXPECT_TRUE(mesh.is_delaunay());
  for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
    const LatticeTriangle& triangle = mesh.triangles()[t];
    EXPECT_GT(area_of(triangle), 0);
    area -= area_of(triangle);
    for (std::uint32_t i = 0; i < 3; ++i)
      if (const std::uint32_t twin = triangle.twin[i]; twin != kNoHalfEdge) {
        EXPECT_EQ(mesh.triangles()[twin >> 2].twin[twin & 3], 4 * t + i);
        EXPECT_EQ(mesh.triangles()[twin >> 2].corner[twin & 3], triangle.corner[(i + 1) % 3]);
      }
  }
  EXPECT_EQ(area, 0);
}

template <typename T>
class greedy_insertion : public testing::Test {};
using Types = testing::Types<std::int16_t, std::uint16_t, float, double>;
TYPED_TEST_SUITE(greedy_insertion, Types);

TYPED_TEST(greedy_insertion, keeps_the_error_at_every_sample_and_delaunay_in_both_orders) {
  for (const auto& [n_columns, n_rows] : {std::pair{2, 2}, {2, 30}, {31, 2}, {40, 33}}) {
    const HeightGrid grid = test::make_grid<TypeParam>(n_columns, n_rows, terrain);
    for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict})
      for (const double max_error : {0.0, 1.0, 17.5, 200.0, 5000.0}) {
        SCOPED_TRACE(testing::Message() << n_columns << " x " << n_rows << ", " << max_error);
        const Answer answer = insert(grid, {.max_error = max_error, .order = order});
        const auto largest = static_cast<double>(test::largest_error(answer.tin, grid));
        EXPECT_LE(largest, answer.report.achieved_error);
        EXPECT_LE(answer.report.achieved_error, max_error);
        EXPECT_TRUE(answer.report.is_within_error);
        test::expect_fills(answer.tin, grid);
        test::expect_empty_circles(answer.tin);
        if (max_error == 5000) EXPECT_EQ(answer.tin.triangles.size(), 2U);
      }
  }
}

TYPED_TEST(greedy_insertion, leaves_planes_alone_however_steep) {
  for (const auto& [a, b] : {std::pair{0, 0}, {3, 0}, {-2, 5}}) {
    const HeightGrid grid = test::make_grid<TypeParam>(
        37, 23, [&, u = a, v = b](std::int32_t x, std::int32_t y) { return 500 + u * x + v * y; });
    const Answer answer = insert(grid, {.max_error = 0.5});
    EXPECT_EQ(answer.tin.triangles.size(), 2U);
    if (std::is_integral_v<TypeParam> || (a == 0 && b == 0)) {
      const Answer exact = insert(grid, {.max_error = 0});
      EXPECT_EQ(exact.tin.triangles.size(), 2U) << "rounding was taken for an error";
      EXPECT_EQ(exact.report.achieved_error, 0);
    }
  }
}

TYPED_TEST(greedy_insertion, is_within_the_error_where_samples_are_missing) {
  HeightGrid grid = test::make_grid<TypeParam>(36, 29, terrain);
  oracles::Random random(5);
  for (int i = 0; i < 40; ++i)
    test::set_missing(grid, static_cast<std::int32_t>(random.below(36)),
                      static_cast<std::int32_t>(random.below(29)));
  auto& samples = std::get<HeightGrid::Samples<TypeParam>>(grid.heights);
  for (std::int32_t y = 0; y < 29; ++y)
    for (std::int32_t x = 0; x < 36; ++x)
      if (!grid.has_height(x, y))
        samples[static_cast<std::size_t>(y * grid.stride + x)] =
            std::numeric_limits<TypeParam>::has_quiet_NaN
                ? std::numeric_limits<TypeParam>::quiet_NaN()
                : std::numeric_limits<TypeParam>::min();
  for (const InsertionOrder order : {InsertionOrder::levels, InsertionOrder::strict}) {
    const Answer answer = insert(grid, {.max_error = 25, .order = order});
    test::expect_fills(answer.tin, grid);
    test::expect_locally_delaunay(answer.tin);
    EXPECT_LE(static_cast<double>(test::largest_error(answer.tin, grid)),
              answer.report.achieved_error);
    EXPECT_LE(answer.report.achieved_error, 25);
  }
}

TYPED_TEST(greedy_insertion, gives_the_same_with_every_instruction_set) {
  const HeightGrid grid = test::make_grid<TypeParam>(61, 47, terrain);
  const Answer expected = insert(grid, {.max_error = 30});
  lode::test::for_each_target([&] {
    const Answer answer = insert(grid, {.max_error = 30});
    EXPECT_EQ(answer.tin.vertices, expected.tin.vertices);
    EXPECT_EQ(answer.tin.triangles, expected.tin.triangles);
    EXPECT_EQ(answer.report.achieved_error, expected.report.achieved_error);
  });
}

TEST(strict_order, inserts_the_worst_of_all_samples_each_time) {
  const HeightGrid grid = test::make_grid<std::int16_t>(24, 21, terrain);
  Answer before = insert(grid, {.max_triangles = 2, .order = InsertionOrder::strict});
  for (std::uint64_t n = 3; n < 40; ++n) {
    const Answer after = insert(grid, {.max_triangles = n, .order = InsertionOrder::strict});
    EXPECT_LE(after.tin.triangles.size(), n);
    EXPECT_GE(after.tin.triangles.size() + 1, n) << "one more would have fitted";
    if (after.tin.vertices.size() == before.tin.vertices.size()) continue;
    ASSERT_EQ(after.tin.vertices.size(), before.tin.vertices.size() + 1);
    for (const LatticePoint& p : after.tin.vertices) {
      if (std::ranges::find(before.tin.vertices, p) != before.tin.vertices.end()) continue;
      // The error of that sample alone: put the grid back to it.
      HeightGrid only = grid;
      auto& samples = std::get<HeightGrid::Samples<std::int16_t>>(only.heights);
      const auto largest = test::largest_error(before.tin, only);
      auto& z = samples[static_cast<std::size_t>(p.y * only.stride + p.x)];
      const std::int16_t kept = z;
      z = static_cast<std::int16_t>(kept + 1);
      const auto up = test::largest_error(before.tin, only);
      z = static_cast<std::int16_t>(kept - 1);
      const auto down = test::largest_error(before.tin, only);
      EXPECT_GT(std::max(up, down), largest) << "it was not one with the largest error";
    }
    before = after;
  }
}

TEST(strict_order, needs_no_more_triangles_than_levels) {
  const HeightGrid grid =
      test::make_grid<std::int16_t>(120, 90, [](std::int32_t x, std::int32_t y) {
        return 3000 * std::sin(0.07 * x) * std::cos(0.05 * y) + 400 * std::sin(0.31 * x + 0.2 * y);
      });
  const Answer strict = insert(grid, {.max_error = 20, .order = InsertionOrder::strict});
  const Answer levels = insert(grid, {.max_error = 20});
  const double ratio = static_cast<double>(levels.tin.triangles.size()) /
                       static_cast<double>(strict.tin.triangles.size());
  EXPECT_LT(ratio, 1.1);
  EXPECT_GT(ratio, 0.9);
}

TEST(worst_sample, is_found_by_lanes_within_the_slack_of_the_exact_search) {
  oracles::Random random(9);
  for (int round = 0; round < 400; ++round) {
    const std::uint64_t size = 2 + random.below(60);
    const HeightGrid grid = test::make_grid<std::uint16_t>(
        64, 64, [&](std::int32_t, std::int32_t) { return random.below(65536); });
    const LatticePacking packing(256);
    std::array<LatticePoint, 3> v{};
    for (LatticePoint& p : v)
      p = {static_cast<std::int32_t>(random.below(size)),
           static_cast<std::int32_t>(random.below(size))};
    if (doubled_area(v[0], v[1], v[2]) < 0) std::swap(v[1], v[2]);
    if (doubled_area(v[0], v[1], v[2]) == 0) continue;
    const std::array<std::uint32_t, 3> corners{packing.pack(v[0]), packing.pack(v[1]),
                                               packing.pack(v[2])};
    const auto& samples = std::get<HeightGrid::Samples<std::uint16_t>>(grid.heights);
    const SampleRows<std::uint16_t> rows{samples.data(), grid.stride, packing};
    const WorstSample exact = find_worst_exactly(rows, double_slack(0, 65535), corners);
    const Tin tin{{v[0], v[1], v[2]}, {{0, 1, 2}}};
    const auto expected = static_cast<double>(test::largest_error(tin, grid));
    EXPECT_GE(exact.error, expected);
    EXPECT_LE(exact.error, expected * (1 + 0x1p-51));
    const WorstSample lanes = find_worst_sample<std::uint16_t>()(
        rows, lane_slack<std::uint16_t>(0, 65535), corners,
        {rows.height(v[0]), rows.height(v[1]), rows.height(v[2])});
    EXPECT_GE(lanes.error, expected);
    EXPECT_LE(lanes.error, expected + 2 * lanes.slack);
  }
}

TEST(greedy_insertion_stop, ends_with_an_error_when_cancelled) {
  const HeightGrid grid = test::make_grid<std::int16_t>(40, 33, terrain);
  const auto domain = find_domain(grid);
  const LatticePacking packing(grid.n_columns);
  LatticeMesh mesh(packing, domain->triangles);
  Progress progress;
  progress.cancel();
  const auto& samples = std::get<HeightGrid::Samples<std::int16_t>>(grid.heights);
  EXPECT_FALSE(insert_greedily(mesh, SampleRows<std::int16_t>{samples.data(), grid.stride, packing},
                               0, 5000, {.max_error = 1}, progress));
}

}  // namespace
}  // namespace lode::delaunay
