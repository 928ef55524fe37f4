#pragma once

// Cases of TINs, and what features of them have to be, by other means.
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "lode/delaunay/full_tin.h"
#include "lode/delaunay/tin_links.h"
#include "lode/delaunay/triangulation.h"
#include "lode/models/terrain/terrain_features/features.h"
#include "tests/delaunay/lattice_fixtures.h"

namespace lode::terrain_features::test {

using delaunay::LatticePoint;
using delaunay::Tin;
using delaunay::test::make_grid;
using delaunay::test::set_missing;
using oracles::Random;

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();

inline Features features_of(const Tin& tin, double least_relief) {
  Progress progress;
  auto features = find_features(tin, least_relief, progress);
  EXPECT_TRUE(features);
  return *std::move(features);
}

inline Tin full_tin(const HeightGrid& grid) {
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

inline Case cut_out(std::string name, Tin whole, std::vector<bool> is_in) {
  Case made{std::move(name), std::move(whole), std::move(is_in), {}};
  made.tin.vertices = made.whole.vertices;
  made.tin.heights = made.whole.heights;
  for (std::size_t t = 0; t < made.whole.triangles.size(); ++t)
    if (made.is_in[t]) made.tin.triangles.push_back(made.whole.triangles[t]);
  made.tin.twins = delaunay::find_twins(made.tin.triangles);
  return made;
}

/// Heights that are often equal.
inline double coarse_height(Random& random) { return static_cast<double>(random.below(9)); }

inline Tin scattered_tin(int n, Random& random) {
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
inline std::vector<Case> cases() {
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

inline Sets joined_corners(const Tin& tin) {
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

inline OutsideEdges outside_edges(const Case& c) {
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
inline std::size_t n_closed_components(const Case& c, const OutsideEdges& outside,
                                       bool is_from_below, double s, double t) {
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

inline std::int64_t euler_number(const Tin& tin) {
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

inline std::int64_t alternating_sum(const FeatureCounts& counts) {
  return static_cast<std::int64_t>(counts.peaks) - static_cast<std::int64_t>(counts.passes) +
         static_cast<std::int64_t>(counts.pits);
}

inline FeatureCounts counts_of(const std::vector<CriticalPoint>& points) {
  FeatureCounts counts;
  for (const CriticalPoint& p : points) {
    if (p.kind == CriticalKind::peak) ++counts.peaks;
    if (p.kind == CriticalKind::pit) ++counts.pits;
    if (p.kind == CriticalKind::pass) counts.passes += p.multiplicity;
  }
  return counts;
}

inline std::set<std::uint32_t> vertices_of(const Features& features, CriticalKind kind) {
  std::set<std::uint32_t> vertices;
  for (const CriticalPoint& p : features.points)
    if (p.kind == kind) vertices.insert(p.vertex);
  return vertices;
}

inline bool is_below(const Tin& tin, std::uint32_t a, std::uint32_t b) {
  return std::pair(tin.heights[a], a) < std::pair(tin.heights[b], b);
}

inline std::set<std::uint32_t> outline_of(const Tin& tin) {
  std::set<std::uint32_t> vertices;
  for (std::size_t t = 0; t < tin.triangles.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i)
      if (tin.twins[t][i] == delaunay::kNoHalfEdge)
        vertices.insert({tin.triangles[t][i], tin.triangles[t][(i + 1) % 3]});
  return vertices;
}

/// They run along edges, each once, from passes to extrema that are kept, the outline, or a line
/// that came earlier.
inline void expect_lines_lead_on(const Tin& tin, const Features& features) {
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
inline void expect_lines_connect(const Tin& tin, const Features& features) {
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

}  // namespace lode::terrain_features::test
