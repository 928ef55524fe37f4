#include "lode/mappers/tin_bands.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "lode/core/disjoint_sets.h"
#include "lode/delaunay/lattice_side.h"
#include "lode/mappers/tin_contours.h"

namespace lode {
namespace {

using delaunay::kNoHalfEdge;
using delaunay::Tin;

constexpr std::array<std::uint32_t, 3> kAfter{1, 2, 0};

/// The bands of each triangle: a vertex at a level belongs to the band above it.
class TriangleBands {
 public:
  TriangleBands(const Tin& tin, std::span<const double> levels) : tin_(tin) {
    n_reached_.reserve(tin.heights.size());
    for (const double z : tin.heights)
      n_reached_.push_back(static_cast<std::uint32_t>(
          std::upper_bound(levels.begin(), levels.end(), z) - levels.begin()));
    first_.reserve(tin.triangles.size() + 1);
    std::uint64_t n = 0;
    for (const auto& corner : tin.triangles) {
      first_.push_back(n);
      const auto [low, high] =
          std::minmax({n_reached_[corner[0]], n_reached_[corner[1]], n_reached_[corner[2]]});
      n += high - low + 1;
    }
    first_.push_back(n);
  }
  /// Of a vertex.
  [[nodiscard]] std::uint32_t band_of(std::uint32_t vertex) const { return n_reached_[vertex]; }
  /// At the start and end of an edge, 4 times a triangle and its edge.
  [[nodiscard]] std::uint32_t band_at_start(std::uint32_t half_edge) const {
    return band_of(start_of(half_edge));
  }
  [[nodiscard]] std::uint32_t band_at_end(std::uint32_t half_edge) const {
    return band_of(tin_.triangles[half_edge / 4][kAfter[half_edge % 4]]);
  }
  [[nodiscard]] std::uint32_t start_of(std::uint32_t half_edge) const {
    return tin_.triangles[half_edge / 4][half_edge % 4];
  }
  /// A number for what a band has of a triangle.
  [[nodiscard]] std::uint64_t part_of(std::uint32_t t, std::uint32_t band) const {
    const auto& corner = tin_.triangles[t];
    return first_[t] +
           (band - std::min({n_reached_[corner[0]], n_reached_[corner[1]], n_reached_[corner[2]]}));
  }
  [[nodiscard]] std::uint64_t n_parts() const { return first_.back(); }
  /// Joins what lies on both sides of edges.
  [[nodiscard]] DisjointSets<std::uint64_t> connected() const {
    DisjointSets<std::uint64_t> sets(n_parts());
    for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t twin = tin_.twins[t][i];
        if (twin == kNoHalfEdge || twin / 4 < t) continue;
        const auto [low, high] = std::minmax({band_at_start(4 * t + i), band_at_end(4 * t + i)});
        for (std::uint32_t band = low; band <= high; ++band)
          sets.join(part_of(t, band), part_of(twin / 4, band));
      }
    return sets;
  }

 private:
  const Tin& tin_;
  std::vector<std::uint32_t> n_reached_;  ///< Per vertex: levels that it is at or above.
  std::vector<std::uint64_t> first_;      ///< Per triangle, and one more.
};

/// A ring round a band, and the part of a triangle at it.
struct BandRing {
  std::uint32_t band;
  std::uint64_t part;
  Ring points;
};

/// Follows the borders of bands, the band on the left: along the outline until a level is crossed,
/// then along its contour to where that ends at the outline.
class BandTracer {
 public:
  BandTracer(const Tin& tin, const TriangleBands& bands, const std::vector<ContourLine>& lines)
      : tin_(tin), bands_(bands), lines_(lines) {}

  std::vector<BandRing> run() {
    number_outline();
    for (std::uint32_t i = 0; i < lines_.size(); ++i)
      if (lines_[i].is_ring)
        add_ring(lines_[i]);
      else
        find_crossings(i);
    for (std::size_t edge = 0; edge < outline_.size(); ++edge)
      for (std::size_t k = first_[edge]; k < first_[edge + 1]; ++k)
        if (!is_done_[k]) trace(edge, k);
    for (std::size_t edge = 0; edge < outline_.size(); ++edge)
      if (!is_passed_[edge]) trace_outline(edge);
    return std::move(made_);
  }

 private:
  /// A level crosses an edge of the outline: where it rises a line ends, else one begins.
  [[nodiscard]] bool is_rising(std::size_t edge) const {
    return bands_.band_at_start(outline_[edge]) < bands_.band_at_end(outline_[edge]);
  }
  /// The k-th crossing in the order of the edge.
  [[nodiscard]] std::uint32_t level_of(std::size_t edge, std::size_t k) const {
    const auto n = static_cast<std::uint32_t>(k - first_[edge]);
    const std::uint32_t start = bands_.band_at_start(outline_[edge]);
    return is_rising(edge) ? start + n : start - 1 - n;
  }
  [[nodiscard]] std::size_t crossing_of(std::size_t edge, std::uint32_t level) const {
    const std::uint32_t start = bands_.band_at_start(outline_[edge]);
    return first_[edge] + (is_rising(edge) ? level - start : start - 1 - level);
  }
  [[nodiscard]] std::size_t edge_of(std::uint32_t half_edge) const {
    return static_cast<std::size_t>(std::ranges::lower_bound(outline_, half_edge) -
                                    outline_.begin());
  }
  /// Turning left round the domain, within what hangs together by edges.
  [[nodiscard]] std::size_t next_of(std::size_t edge) const {
    std::uint32_t half_edge = outline_[edge];
    for (;;) {
      half_edge = half_edge - half_edge % 4 + kAfter[half_edge % 4];
      const std::uint32_t twin = tin_.twins[half_edge / 4][half_edge % 4];
      if (twin == kNoHalfEdge) return edge_of(half_edge);
      half_edge = twin;
    }
  }

  void number_outline() {
    for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t)
      for (std::uint32_t i = 0; i < 3; ++i)
        if (tin_.twins[t][i] == kNoHalfEdge) outline_.push_back(4 * t + i);
    std::size_t n = 0;
    for (const std::uint32_t half_edge : outline_) {
      first_.push_back(n);
      const auto [low, high] =
          std::minmax({bands_.band_at_start(half_edge), bands_.band_at_end(half_edge)});
      n += high - low;
    }
    first_.push_back(n);
    line_at_.assign(n, 0);
    is_done_.assign(n, false);
    is_passed_.assign(outline_.size(), false);
  }
  void find_crossings(std::uint32_t line) {
    line_at_[crossing_of(edge_of(lines_[line].begin), lines_[line].level)] = line;
    line_at_[crossing_of(edge_of(lines_[line].end), lines_[line].level)] = line;
  }
  /// Of the band above it, and the other way round of that below.
  void add_ring(const ContourLine& line) {
    Ring back(line.points.rbegin(), line.points.rend());
    made_.push_back({line.level + 1, bands_.part_of(line.triangle, line.level + 1), line.points});
    made_.push_back({line.level, bands_.part_of(line.triangle, line.level), std::move(back)});
  }
  void add_point(Ring& ring, std::uint32_t vertex) const {
    ring.push_back(delaunay::to_point(tin_.vertices[vertex]));
  }

  /// From behind the k-th crossing on.
  void trace(std::size_t edge, std::size_t k) {
    const std::size_t start = k;
    const std::uint32_t band = level_of(edge, k) + (is_rising(edge) ? 1 : 0);
    BandRing made{band, bands_.part_of(outline_[edge] / 4, band), {}};
    do {
      is_done_[k] = true;
      ++k;
      while (k == first_[edge + 1]) {
        is_passed_[edge] = true;
        edge = next_of(edge);
        add_point(made.points, bands_.start_of(outline_[edge]));
        k = first_[edge];
      }
      is_passed_[edge] = true;
      const ContourLine& line = lines_[line_at_[k]];
      // Down across the lower level along its line, up across the upper one against its line.
      if (is_rising(edge))
        made.points.insert(made.points.end(), line.points.rbegin(), line.points.rend());
      else
        made.points.insert(made.points.end(), line.points.begin(), line.points.end());
      const std::uint32_t to = is_rising(edge) ? line.begin : line.end;
      edge = edge_of(to);
      k = crossing_of(edge, line.level);
    } while (k != start);
    made.points.push_back(made.points.front());
    made_.push_back(std::move(made));
  }
  /// A loop of the outline that no level crosses.
  void trace_outline(std::size_t edge) {
    const std::uint32_t band = bands_.band_at_start(outline_[edge]);
    BandRing made{band, bands_.part_of(outline_[edge] / 4, band), {}};
    while (!is_passed_[edge]) {
      is_passed_[edge] = true;
      add_point(made.points, bands_.start_of(outline_[edge]));
      edge = next_of(edge);
    }
    made.points.push_back(made.points.front());
    made_.push_back(std::move(made));
  }

  const Tin& tin_;
  const TriangleBands& bands_;
  const std::vector<ContourLine>& lines_;
  std::vector<std::uint32_t> outline_;  ///< Edges with nothing behind them, as numbers rise.
  std::vector<std::size_t> first_;      ///< Per edge, and one more: its first crossing.
  std::vector<std::uint32_t> line_at_;  ///< Per crossing.
  std::vector<bool> is_done_;           ///< Per crossing: what comes behind it.
  std::vector<bool> is_passed_;         ///< Per edge: by any ring.
  std::vector<BandRing> made_;
};

/// Rings of one part make polygons.
void add_polygons(std::span<BandRing> rings, std::vector<BandPolygon>& polygons) {
  std::vector<Ring> all;
  for (BandRing& ring : rings)
    // A summit of just a level's height has a ring of one point.
    if (ring.points.size() > 2) all.push_back(std::move(ring.points));
  std::vector<Ring> simple;
  for (const Ring& ring : follow_inside(all))
    for (Ring& one : cut_at_repeated_points(ring)) simple.push_back(std::move(one));
  for (RingPolygon& polygon : nest_rings(std::move(simple)))
    polygons.push_back({rings[0].band, std::move(polygon)});
}

}  // namespace

Result<std::vector<BandPolygon>> find_bands(const Tin& tin, std::span<const double> levels,
                                            Progress& progress) {
  LODE_TRY(const ContourSet contours, trace_contours(tin, levels, KeptLines::all, progress));
  const TriangleBands bands(tin, levels);
  std::vector<BandRing> rings = BandTracer(tin, bands, contours.lines).run();
  DisjointSets<std::uint64_t> sets = bands.connected();
  for (BandRing& ring : rings) ring.part = sets.find(ring.part);
  // By bands, then parts; of one, as they were found.
  std::ranges::stable_sort(rings, {},
                           [](const BandRing& ring) { return std::pair(ring.band, ring.part); });
  std::vector<BandPolygon> polygons;
  for (std::size_t first = 0, end = 0; first < rings.size(); first = end) {
    if (progress.is_cancelled()) return cancelled_error();
    progress.report("joining bands",
                    static_cast<double>(first) / static_cast<double>(rings.size()));
    while (end < rings.size() && rings[end].part == rings[first].part) ++end;
    add_polygons(std::span(rings).subspan(first, end - first), polygons);
  }
  return polygons;
}

}  // namespace lode
