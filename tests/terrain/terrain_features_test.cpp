// Peaks, pits and passes against Euler's formula and against components found by flooding; ridges
// and channels against what they are said to be.
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangulation.h"
#include "lode/models/terrain/terrain_features/features.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::terrain_features {
namespace {

using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::test::make_grid;
using delaunay::test::set_missing;
using oracles::Random;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

Features features_of(const Tin& tin, double least_relief) {
  Progress progress;
  auto features = find_features(tin, least_relief, progress);
  EXPECT_TRUE(features);
  return *std::move(features);
}

Tin full_tin(const HeightGrid& grid) {
  auto full = delaunay::to_full_tin(grid);
  EXPECT_TRUE(full);
  return std::move(full->tin);
}

/// A triangulation without gaps, and which of its triangles are in the domain.
struct Case {
  std::string name;
  Tin whole;
  std::vector<bool> is_in;
  Tin tin;
};

Case cut_out(std::string name, Tin whole, std::vector<bool> is_in) {
  Case made{std::move(name), std::move(whole), std::move(is_in), {}};
  made.tin.vertices = made.whole.vertices;
  made.tin.heights = made.whole.heights;
  for (std::size_t t = 0; t < made.whole.triangles.size(); ++t)
    if (made.is_in[t]) made.tin.triangles.push_back(made.whole.triangles[t]);
  made.tin.twins = delaunay::find_twins(made.tin.triangles);
  return made;
}

/// Heights that are often equal.
double coarse_height(Random& random) { return static_cast<double>(random.below(9)); }

Tin scattered_tin(int n, Random& random) {
  std::set<std::pair<std::int32_t, std::int32_t>> places;
  while (places.size() < static_cast<std::size_t>(n))
    places.insert(
        {static_cast<std::int32_t>(random.below(60)), static_cast<std::int32_t>(random.below(60))});
  Tin tin;
  std::vector<delaunay::Point> points;
  for (const auto& [x, y] : places) {
    tin.vertices.push_back({x, y});
    tin.heights.push_back(coarse_height(random));
    points.push_back({static_cast<double>(x), static_cast<double>(y)});
  }
  const auto triangulation = delaunay::Triangulation::of(points);
  EXPECT_TRUE(triangulation);
  for (const auto& triangle : triangulation->triangles()) tin.triangles.push_back(triangle.corner);
  tin.twins = delaunay::find_twins(tin.triangles);
  return tin;
}

/// Rasters and scattered points, whole and with triangles left out: holes, islands, corners that
/// touch, vertices of no triangle.
std::vector<Case> cases() {
  std::vector<Case> made;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const auto side = [&] { return 2 + static_cast<std::int32_t>(random.below(9)); };
    const std::int32_t n_columns = side();
    const std::int32_t n_rows = side();
    Tin whole = seed % 2 == 0 ? scattered_tin(4 + static_cast<int>(random.below(90)), random)
                              : full_tin(make_grid<float>(n_columns, n_rows, [&](int, int) {
                                  return coarse_height(random);
                                }));
    const std::uint64_t share = seed % 3 == 0 ? 10 : 3 + random.below(7);  // Of ten.
    std::vector<bool> is_in(whole.triangles.size());
    for (std::size_t t = 0; t < is_in.size(); ++t) is_in[t] = random.below(10) < share;
    is_in[0] = true;
    made.push_back(cut_out("seed " + std::to_string(seed), std::move(whole), std::move(is_in)));
  }
  return made;
}

class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0U); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::size_t> parent_;
};

Sets joined_corners(const Tin& tin) {
  Sets sets(tin.vertices.size());
  for (const auto& t : tin.triangles)
    for (const std::uint32_t corner : t) sets.join(t[0], corner);
  return sets;
}

/// Edges between vertices and what is outside, which are numbers from vertices.size() on: for each
/// connected piece of the domain every connected part of the rest of the plane.
struct OutsideEdges {
  std::vector<std::pair<std::size_t, std::size_t>> edges;
  std::size_t n_nodes;
};

OutsideEdges outside_edges(const Case& c) {
  const std::size_t n = c.whole.vertices.size();
  const std::size_t n_triangles = c.whole.triangles.size();
  Sets pieces = joined_corners(c.tin);
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> numbers;
  OutsideEdges made{{}, n};
  std::set<std::size_t> roots;
  for (const auto& t : c.tin.triangles) roots.insert(pieces.find(t[0]));
  for (const std::size_t piece : roots) {
    const auto is_rest = [&](std::size_t t) {
      return !c.is_in[t] || pieces.find(c.whole.triangles[t][0]) != piece;
    };
    Sets parts(n_triangles + 1);
    std::vector<std::pair<std::size_t, std::size_t>> touched;  // Vertices, and triangles there.
    for (std::size_t t = 0; t < n_triangles; ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t twin = c.whole.twins[t][i];
        const std::size_t other = twin == delaunay::kNoHalfEdge ? n_triangles : twin / 4;
        const bool is_other_rest = other == n_triangles || is_rest(other);
        if (is_rest(t) && is_other_rest) parts.join(t, other);
        for (const std::size_t corner : {i, (i + 1) % 3}) {
          if (is_rest(t)) touched.emplace_back(c.whole.triangles[t][corner], t);
          if (is_other_rest) touched.emplace_back(c.whole.triangles[t][corner], other);
        }
      }
    std::set<std::size_t> corners;
    for (const auto& t : c.tin.triangles)
      if (pieces.find(t[0]) == piece) corners.insert(t.begin(), t.end());
    for (const auto& [vertex, t] : touched) {
      if (!corners.contains(vertex)) continue;
      const auto [at, is_new] = numbers.try_emplace({piece, parts.find(t)}, made.n_nodes);
      if (is_new) ++made.n_nodes;
      made.edges.emplace_back(vertex, at->second);
    }
  }
  return made;
}

/// Components of {z <= t} and what is outside that hold a vertex with z <= s but nothing outside;
/// upside down, and then without the outside, of {z >= t}.
std::size_t n_closed_components(const Case& c, const OutsideEdges& outside, bool is_from_below,
                                double s, double t) {
  const auto is_in = [&](std::size_t v, double level) {
    return is_from_below ? c.tin.heights[v] <= level : c.tin.heights[v] >= level;
  };
  Sets sets(outside.n_nodes);
  for (const auto& corner : c.tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = corner[i];
      const std::uint32_t b = corner[(i + 1) % 3];
      if (is_in(a, t) && is_in(b, t)) sets.join(a, b);
    }
  std::set<std::size_t> open;
  if (is_from_below) {
    for (const auto& [vertex, node] : outside.edges)
      if (is_in(vertex, t)) sets.join(vertex, node);
    for (const auto& [vertex, node] : outside.edges) open.insert(sets.find(node));
  }
  std::set<std::size_t> closed;
  for (const auto& corner : c.tin.triangles)
    for (const std::uint32_t v : corner)
      if (is_in(v, s) && !open.contains(sets.find(v))) closed.insert(sets.find(v));
  return closed.size();
}

std::int64_t euler_number(const Tin& tin) {
  std::set<std::uint32_t> vertices;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      vertices.insert(t[i]);
      edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
    }
  return static_cast<std::int64_t>(vertices.size()) - static_cast<std::int64_t>(edges.size()) +
         static_cast<std::int64_t>(tin.triangles.size());
}

std::int64_t alternating_sum(const FeatureCounts& counts) {
  return static_cast<std::int64_t>(counts.peaks) - static_cast<std::int64_t>(counts.passes) +
         static_cast<std::int64_t>(counts.pits);
}

FeatureCounts counts_of(const std::vector<CriticalPoint>& points) {
  FeatureCounts counts;
  for (const CriticalPoint& p : points) {
    if (p.kind == CriticalKind::peak) ++counts.peaks;
    if (p.kind == CriticalKind::pit) ++counts.pits;
    if (p.kind == CriticalKind::pass) counts.passes += p.multiplicity;
  }
  return counts;
}

std::set<std::uint32_t> vertices_of(const Features& features, CriticalKind kind) {
  std::set<std::uint32_t> vertices;
  for (const CriticalPoint& p : features.points)
    if (p.kind == kind) vertices.insert(p.vertex);
  return vertices;
}

bool is_below(const Tin& tin, std::uint32_t a, std::uint32_t b) {
  return std::pair(tin.heights[a], a) < std::pair(tin.heights[b], b);
}

std::set<std::uint32_t> outline_of(const Tin& tin) {
  std::set<std::uint32_t> vertices;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (tin.twins[t][i] == delaunay::kNoHalfEdge)
        vertices.insert({tin.triangles[t][i], tin.triangles[t][(i + 1) % 3]});
  return vertices;
}

/// They run along edges, each once, from passes to extrema that are kept, the outline, or a line
/// that came earlier.
void expect_lines_lead_on(const Tin& tin, const Features& features) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : tin.triangles)
    for (std::size_t i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
  const auto passes = vertices_of(features, CriticalKind::pass);
  const auto outline = outline_of(tin);
  for (const LineKind kind : {LineKind::ridge, LineKind::channel}) {
    const bool is_ridge = kind == LineKind::ridge;
    std::set<std::uint32_t> ends =
        vertices_of(features, is_ridge ? CriticalKind::peak : CriticalKind::pit);
    if (!is_ridge) ends.insert(outline.begin(), outline.end());
    std::set<std::pair<std::uint32_t, std::uint32_t>> used;
    for (const FeatureLine& line : features.lines) {
      if (line.kind != kind) continue;
      const auto& v = line.vertices;
      ASSERT_GE(v.size(), 2U);
      EXPECT_TRUE(passes.contains(v.front()));
      EXPECT_TRUE(ends.contains(v.back()));
      EXPECT_TRUE(is_ridge ? is_below(tin, v[0], v[1]) : is_below(tin, v[1], v[0]));
      for (std::size_t i = 1; i < v.size(); ++i) {
        EXPECT_TRUE(edges.contains(std::minmax(v[i - 1], v[i])));
        EXPECT_TRUE(used.insert(std::minmax(v[i - 1], v[i])).second) << "an edge is used twice";
      }
      ends.insert(v.begin(), v.end());
    }
  }
}

/// Of each connected piece of the domain ridges join all kept passes and peaks, channels all kept
/// passes and pits, together with the outline.
void expect_lines_connect(const Tin& tin, const Features& features) {
  Sets pieces = joined_corners(tin);
  const std::size_t n = tin.vertices.size();
  const auto outline = outline_of(tin);
  for (const bool is_ridge : {true, false}) {
    Sets sets(2 * n);
    for (const FeatureLine& line : features.lines)
      if ((line.kind == LineKind::ridge) == is_ridge)
        for (const std::uint32_t v : line.vertices) sets.join(line.vertices[0], v);
    if (!is_ridge)
      for (const std::uint32_t v : outline) sets.join(v, n + pieces.find(v));
    std::map<std::size_t, std::set<std::size_t>> found;
    for (const CriticalPoint& p : features.points) {
      if (p.kind == (is_ridge ? CriticalKind::pit : CriticalKind::peak)) continue;
      found[pieces.find(p.vertex)].insert(sets.find(p.vertex));
    }
    for (const auto& [piece, components] : found) EXPECT_EQ(components.size(), 1U);
  }
}

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
