#include "lode/mappers/tin_contours.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "lode/core/expects.h"
#include "lode/delaunay/lattice_side.h"

namespace lode {
namespace {

using delaunay::Point;
using delaunay::Tin;

constexpr std::array<std::uint32_t, 3> kNext{1, 2, 0};
constexpr std::uint32_t kPerReport = 1 << 16;

/// Levels from first up to, not with, last.
struct LevelSpan {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
};

class ContourTracer {
 public:
  ContourTracer(const Tin& tin, std::span<const double> levels, KeptLines kept, Progress& progress)
      : tin_(tin), levels_(levels), kept_(kept), progress_(progress) {}

  Result<ContourSet> run() {
    rank_vertices();
    number_segments();
    // Lines that come in over the outline first; then what is left are rings.
    for (const bool is_ring : {false, true})
      for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t) {
        if (t % kPerReport == 0) LODE_CHECK(check_in(t, is_ring));
        if (first_[t] == first_[t + 1] || (!is_ring && !has_border(t))) continue;
        const LevelSpan span = levels_in(t);
        for (std::uint32_t level = span.first; level < span.last; ++level)
          if (!is_traced(t, level) && (is_ring || is_first(t, level))) trace(t, level, is_ring);
      }
    // By levels; of one, as they were found.
    std::ranges::stable_sort(made_.lines, {}, &ContourLine::level);
    return std::move(made_);
  }

 private:
  Result<void> check_in(std::uint32_t t, bool is_ring) {
    if (progress_.is_cancelled()) return cancelled_error();
    const double share = static_cast<double>(t) / static_cast<double>(tin_.triangles.size());
    progress_.report("tracing contours", (share + (is_ring ? 1 : 0)) / 2);
    return {};
  }
  [[nodiscard]] bool has_border(std::uint32_t t) const {
    return std::ranges::count(tin_.twins[t], delaunay::kNoHalfEdge) > 0;
  }
  void rank_vertices() {
    n_reached_.reserve(tin_.heights.size());
    for (const double z : tin_.heights)
      n_reached_.push_back(static_cast<std::uint32_t>(
          std::upper_bound(levels_.begin(), levels_.end(), z) - levels_.begin()));
  }
  /// The levels that cross a triangle: above its lowest vertex, not above its highest.
  [[nodiscard]] LevelSpan levels_in(std::uint32_t t) const {
    const auto& corner = tin_.triangles[t];
    const auto [first, last] =
        std::minmax({n_reached_[corner[0]], n_reached_[corner[1]], n_reached_[corner[2]]});
    return {first, last};
  }
  /// One segment for each triangle and level that cross.
  void number_segments() {
    first_.reserve(tin_.triangles.size() + 1);
    std::uint64_t n = 0;
    for (std::uint32_t t = 0; t < tin_.triangles.size(); ++t) {
      first_.push_back(n);
      const LevelSpan span = levels_in(t);
      n += span.last - span.first;
    }
    first_.push_back(n);
    is_traced_.assign(n, false);
  }
  [[nodiscard]] std::uint64_t segment_of(std::uint32_t t, std::uint32_t level) const {
    return first_[t] + (level - levels_in(t).first);
  }
  [[nodiscard]] bool is_traced(std::uint32_t t, std::uint32_t level) const {
    return is_traced_[segment_of(t, level)];
  }
  [[nodiscard]] bool is_above(std::uint32_t t, std::uint32_t corner, std::uint32_t level) const {
    return n_reached_[tin_.triangles[t][corner]] > level;
  }
  /// Turning left round the triangle it comes in where the ground falls below the level, and leaves
  /// where it rises above: so higher ground is on the left.
  [[nodiscard]] std::uint32_t entry_of(std::uint32_t t, std::uint32_t level) const {
    std::uint32_t i = 0;
    while (!(is_above(t, i, level) && !is_above(t, kNext[i], level))) ++i;
    return i;
  }
  [[nodiscard]] std::uint32_t exit_of(std::uint32_t t, std::uint32_t level) const {
    std::uint32_t i = 0;
    while (!(!is_above(t, i, level) && is_above(t, kNext[i], level))) ++i;
    return i;
  }
  [[nodiscard]] bool is_first(std::uint32_t t, std::uint32_t level) const {
    return tin_.twins[t][entry_of(t, level)] == delaunay::kNoHalfEdge;
  }

  /// Always from the lower vertex, so that it is one point from both sides, and points of higher
  /// levels come after those of lower ones on the edge, or are the same, also when they are
  /// rounded.
  [[nodiscard]] Point crossing(std::uint32_t t, std::uint32_t edge, std::uint32_t level) const {
    std::uint32_t u = tin_.triangles[t][edge];
    std::uint32_t v = tin_.triangles[t][kNext[edge]];
    if (tin_.heights[u] > tin_.heights[v]) std::swap(u, v);
    const double share = (levels_[level] - tin_.heights[u]) / (tin_.heights[v] - tin_.heights[u]);
    const Point from = delaunay::to_point(tin_.vertices[u]);
    const Point to = delaunay::to_point(tin_.vertices[v]);
    return from + (to - from) * share;
  }

  void trace(std::uint32_t t, std::uint32_t level, bool is_ring) {
    ContourLine line{level, is_ring, {}, t};
    if (!is_ring) line.begin = 4 * t + entry_of(t, level);
    const auto add = [&](const Point& p) {
      if (line.points.empty() || line.points.back() != p) line.points.push_back(p);
    };
    add(crossing(t, entry_of(t, level), level));
    for (;;) {
      is_traced_[segment_of(t, level)] = true;
      const std::uint32_t out = exit_of(t, level);
      add(crossing(t, out, level));
      const std::uint32_t twin = tin_.twins[t][out];
      if (twin == delaunay::kNoHalfEdge) {
        line.end = 4 * t + out;
        break;
      }
      t = twin / 4;
      if (is_traced(t, level)) break;
    }
    if (line.points.size() < 2 && kept_ == KeptLines::drawable) {
      ++made_.n_left_out;
      return;
    }
    made_.n_points += line.points.size();
    line.points.shrink_to_fit();
    made_.lines.push_back(std::move(line));
  }

  const Tin& tin_;
  std::span<const double> levels_;
  KeptLines kept_;
  Progress& progress_;
  std::vector<std::uint32_t> n_reached_;  ///< Per vertex: levels that it is at or above.
  std::vector<std::uint64_t> first_;      ///< Per triangle, and one more: its first segment.
  std::vector<bool> is_traced_;           ///< Per segment.
  ContourSet made_;
};

}  // namespace

Result<ContourSet> trace_contours(const Tin& tin, std::span<const double> levels, KeptLines kept,
                                  Progress& progress) {
  LODE_EXPECTS(tin.twins.size() == tin.triangles.size() &&
               tin.heights.size() == tin.vertices.size());
  LODE_EXPECTS(std::ranges::adjacent_find(levels, std::ranges::greater_equal()) == levels.end());
  return ContourTracer(tin, levels, kept, progress).run();
}

}  // namespace lode
