// Peaks, pits and passes against Euler's formula and against components found by flooding; ridges
// and channels against what they are said to be.
#include "tests/terrain/feature_fixtures.h"

namespace lode::terrain_features {
namespace {

using namespace test;  // NOLINT(google-build-using-namespace)

TEST(terrain_features, alternate_to_eulers_number) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const Features features = features_of(c.tin, 0);
    EXPECT_EQ(features.euler_number, euler_number(c.tin));
    EXPECT_EQ(alternating_sum(features.all), features.euler_number);
    EXPECT_EQ(features.kept, features.all);
    EXPECT_EQ(counts_of(features.points), features.kept);
    FeatureCounts last = features.all;
    for (const double least_relief : {0.5, 1.0, 2.0, 3.0, 5.0, 100.0}) {
      const Features larger = features_of(c.tin, least_relief);
      EXPECT_EQ(larger.all, features.all);
      EXPECT_EQ(alternating_sum(larger.kept), features.euler_number);
      EXPECT_EQ(counts_of(larger.points), larger.kept);
      EXPECT_LE(larger.kept.peaks, last.peaks);
      EXPECT_LE(larger.kept.passes, last.passes);
      EXPECT_LE(larger.kept.pits, last.pits);
      for (const CriticalPoint& p : larger.points) EXPECT_GE(p.relief, least_relief);
      last = larger.kept;
    }
    std::set<std::size_t> pieces;
    Sets sets = joined_corners(c.tin);
    for (const auto& t : c.tin.triangles) pieces.insert(sets.find(t[0]));
    EXPECT_EQ(last.peaks, pieces.size()) << "the highest of each piece, and no other";
    EXPECT_EQ(last.pits, 0U) << "water leaves over the outline";
  }
}

TEST(terrain_features, alternate_to_eulers_number_on_rasters_with_gaps) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    HeightGrid grid = make_grid<std::int16_t>(40, 33, [&](int, int) { return random.below(6); });
    for (std::uint64_t i = 0; i < 12 * seed; ++i)
      set_missing(grid, static_cast<std::int32_t>(random.below(40)),
                  static_cast<std::int32_t>(random.below(33)));
    const Tin tin = full_tin(grid);
    for (const double least_relief : {0.0, 2.0}) {
      const Features features = features_of(tin, least_relief);
      EXPECT_EQ(features.euler_number, euler_number(tin));
      EXPECT_EQ(alternating_sum(features.all), features.euler_number);
      EXPECT_EQ(alternating_sum(features.kept), features.euler_number);
      expect_lines_lead_on(tin, features);
      expect_lines_connect(tin, features);
    }
  }
}

TEST(terrain_features, have_the_reliefs_of_components_that_floods_find) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const OutsideEdges outside = outside_edges(c);
    const Features features = features_of(c.tin, 0);
    for (int low = 0; low < 9; ++low)
      for (int high = low; high < 9; ++high) {
        std::size_t n_pits = 0;
        std::size_t n_peaks = 0;
        for (const CriticalPoint& p : features.points) {
          const double z = c.tin.heights[p.vertex];
          if (p.kind == CriticalKind::pit && z <= low && z + p.relief > high) ++n_pits;
          if (p.kind == CriticalKind::peak && z >= high && z - p.relief < low) ++n_peaks;
        }
        EXPECT_EQ(n_pits, n_closed_components(c, outside, true, low, high));
        EXPECT_EQ(n_peaks, n_closed_components(c, outside, false, high, low));
      }
  }
}

/// All others have as many pairs as their multiplicity: of a connected piece beside n parts of what
/// is outside, water divides that are never levelled are n - 1.
TEST(terrain_features, have_infinite_passes_only_between_what_is_outside) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const OutsideEdges outside = outside_edges(c);
    Sets pieces = joined_corners(c.tin);
    std::set<std::size_t> roots;
    for (const auto& t : c.tin.triangles) roots.insert(pieces.find(t[0]));
    const FeatureCounts kept = features_of(c.tin, kInfinite).kept;
    EXPECT_EQ(kept.passes, outside.n_nodes - c.tin.vertices.size() - roots.size());
  }
}

TEST(terrain_features, have_lines_along_edges_that_lead_on) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    for (const double least_relief : {0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 100.0}) {
      SCOPED_TRACE(least_relief);
      const Features features = features_of(c.tin, least_relief);
      expect_lines_lead_on(c.tin, features);
      expect_lines_connect(c.tin, features);
    }
  }
}

TEST(terrain_features, have_ridges_that_rise_and_channels_that_fall_where_all_is_kept) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    for (const FeatureLine& line : features_of(c.tin, 0).lines)
      for (std::size_t i = 1; i < line.vertices.size(); ++i) {
        const std::uint32_t from = line.vertices[i - 1];
        const std::uint32_t to = line.vertices[i];
        EXPECT_TRUE(line.kind == LineKind::ridge ? is_below(c.tin, from, to)
                                                 : is_below(c.tin, to, from));
      }
  }
}

TEST(terrain_features, are_two_peaks_and_the_pass_between_them) {
  // Rows from below; all else falls to the outline.
  const std::array<std::array<int, 7>, 5> rows{{{{0, 1, 2, 3, 2, 1, 0}},
                                                {{1, 11, 12, 13, 12, 11, 1}},
                                                {{2, 21, 50, 30, 40, 21, 2}},
                                                {{1, 11, 12, 14, 12, 11, 1}},
                                                {{0, 1, 2, 3, 2, 1, 0}}}};
  const Tin tin = full_tin(make_grid<float>(7, 5, [&](int x, int y) {
    return rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
  }));
  const std::uint32_t left = 2 * 7 + 2;
  const std::uint32_t middle = left + 1;
  const std::uint32_t right = left + 2;
  const Features features = features_of(tin, 5);
  EXPECT_EQ(features.points, (std::vector<CriticalPoint>{{left, CriticalKind::peak, 1, kInfinite},
                                                         {middle, CriticalKind::pass, 1, 10},
                                                         {right, CriticalKind::peak, 1, 10}}));
  EXPECT_EQ(features.kept, (FeatureCounts{2, 1, 0}));
  std::set<std::vector<std::uint32_t>> ridges;
  std::size_t n_channels = 0;
  for (const FeatureLine& line : features.lines) {
    if (line.kind == LineKind::ridge) {
      ridges.insert(line.vertices);
    } else {
      ++n_channels;
    }
  }
  EXPECT_EQ(ridges, (std::set<std::vector<std::uint32_t>>{{middle, left}, {middle, right}}));
  EXPECT_EQ(n_channels, 2U);
  const Features fewer = features_of(tin, 10.5);
  EXPECT_EQ(fewer.points, (std::vector<CriticalPoint>{{left, CriticalKind::peak, 1, kInfinite}}));
  EXPECT_TRUE(fewer.lines.empty());
}

TEST(terrain_features, are_a_bowls_pit_and_what_its_rim_has) {
  const Tin tin = full_tin(
      make_grid<float>(9, 9, [](int x, int y) { return (x - 4) * (x - 4) + (y - 4) * (y - 4); }));
  const Features features = features_of(tin, 0);
  EXPECT_EQ(features.all, (FeatureCounts{4, 4, 1}));
  std::multiset<double> peaks;
  for (const CriticalPoint& p : features.points) {
    if (p.kind == CriticalKind::peak) peaks.insert(p.relief);
    if (p.kind != CriticalKind::peak) EXPECT_EQ(p.relief, 16);
    if (p.kind == CriticalKind::pit) EXPECT_EQ(p.vertex, 40U);
  }
  EXPECT_EQ(peaks, (std::multiset<double>{16, 16, 16, kInfinite}));
}

/// A hexagon round a vertex, high and low in turn.
Tin monkey_saddle() {
  Tin tin;
  tin.vertices = {{2, 2}, {4, 2}, {3, 4}, {1, 4}, {0, 2}, {1, 0}, {3, 0}};
  tin.heights = {0, 1, -1, 2, -1, 3, -1};
  for (std::uint32_t i = 0; i < 6; ++i) tin.triangles.push_back({0, 1 + i, 1 + (i + 1) % 6});
  tin.twins = delaunay::find_twins(tin.triangles);
  return tin;
}

TEST(terrain_features, have_a_monkey_saddle_twice) {
  const Features features = features_of(monkey_saddle(), 0);
  EXPECT_EQ(features.points, (std::vector<CriticalPoint>{{0, CriticalKind::pass, 2, 2},
                                                         {1, CriticalKind::peak, 1, 1},
                                                         {3, CriticalKind::peak, 1, 2},
                                                         {5, CriticalKind::peak, 1, kInfinite}}));
  EXPECT_EQ(features.lines.size(), 6U);
  const Features half = features_of(monkey_saddle(), 1.5);
  EXPECT_EQ(half.points, (std::vector<CriticalPoint>{{0, CriticalKind::pass, 1, 2},
                                                     {3, CriticalKind::peak, 1, 2},
                                                     {5, CriticalKind::peak, 1, kInfinite}}));
  std::set<std::vector<std::uint32_t>> ridges;
  for (const FeatureLine& line : half.lines)
    if (line.kind == LineKind::ridge) ridges.insert(line.vertices);
  EXPECT_EQ(ridges, (std::set<std::vector<std::uint32_t>>{{0, 3}, {0, 5}}));
}

TEST(terrain_features, are_one_peak_of_cones_planes_and_flat_ground) {
  const std::vector<std::function<double(int, int)>> surfaces{
      [](int x, int y) { return -std::hypot(x - 6.2, y - 4.7); },
      [](int x, int y) { return x + 2 * y; }, [](int, int) { return 7; }};
  for (const auto& surface : surfaces) {
    const Features features = features_of(full_tin(make_grid<double>(12, 11, surface)), 0);
    EXPECT_EQ(features.all, (FeatureCounts{1, 0, 0}));
    EXPECT_TRUE(features.lines.empty());
    EXPECT_EQ(features.euler_number, 1);
  }
}

TEST(terrain_features, go_on_past_extrema_that_are_not_kept) {
  // A crest: a high and a low end, and a knoll between them that is too small.
  const std::array<int, 9> crest{0, 40, 20, 25, 22, 60, 30, 33, 0};
  const Tin tin = full_tin(make_grid<float>(
      9, 3, [&](int x, int y) { return y == 1 ? crest[static_cast<std::size_t>(x)] : -x - y; }));
  const Features features = features_of(tin, 10);
  EXPECT_EQ(vertices_of(features, CriticalKind::peak), (std::set<std::uint32_t>{10, 14}));
  std::set<std::vector<std::uint32_t>> ridges;
  for (const FeatureLine& line : features.lines)
    if (line.kind == LineKind::ridge) ridges.insert(line.vertices);
  EXPECT_EQ(ridges, (std::set<std::vector<std::uint32_t>>{{11, 10}, {11, 12, 13, 14}}));
}

TEST(terrain_features, stop_when_cancelled) {
  Progress progress;
  progress.cancel();
  EXPECT_FALSE(find_features(monkey_saddle(), 0, progress));
}

}  // namespace
}  // namespace lode::terrain_features
