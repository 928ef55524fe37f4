#include "lode/mappers/point_tin_check.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "lode/delaunay/lattice.h"
#include "lode/mappers/point_squares.h"
#include "lode/mappers/tin_edge_check.h"
#include "lode/mappers/tin_lines.h"
#include "lode/mappers/worst_seen.h"

namespace lode {
namespace {

/// Edges that border edges of triangles must be part of.
class PointOutline {
 public:
  PointOutline(const HeightPoints& points, std::span<const std::array<std::uint32_t, 2>> edges) {
    for (const auto& [a, b] : edges) edges_.emplace_back(points.nodes[a], points.nodes[b]);
    std::ranges::sort(edges_, {}, key);
  }

  [[nodiscard]] bool has(LatticePoint p, LatticePoint q) const {
    if (std::ranges::binary_search(edges_, key({p, q}), {}, key)) return true;
    return std::ranges::any_of(edges_, [&](const Edge& edge) {
      const LatticePoint a = edge.first;
      const LatticePoint b = edge.second;
      const auto along = [&](LatticePoint u) {
        return a.x != b.x ? std::int64_t{u.x} * (b.x > a.x ? 1 : -1)
                          : std::int64_t{u.y} * (b.y > a.y ? 1 : -1);
      };
      return delaunay::doubled_area(a, b, p) == 0 && delaunay::doubled_area(a, b, q) == 0 &&
             along(a) <= along(p) && along(p) < along(q) && along(q) <= along(b);
    });
  }
  /// Twice that of what is to the left: of sums that may be larger, the last 64 bits.
  [[nodiscard]] std::int64_t doubled_area() const {
    std::uint64_t area = 0;
    for (const auto& [a, b] : edges_)
      area += static_cast<std::uint64_t>(std::int64_t{a.x} * b.y - std::int64_t{a.y} * b.x);
    return static_cast<std::int64_t>(area);
  }

 private:
  using Edge = std::pair<LatticePoint, LatticePoint>;
  static std::tuple<std::int32_t, std::int32_t, std::int32_t, std::int32_t> key(const Edge& edge) {
    return {edge.first.x, edge.first.y, edge.second.x, edge.second.y};
  }

  std::vector<Edge> edges_;
};

class PointTinChecker {
 public:
  PointTinChecker(const HeightPoints& points, PointOutline outline, double max_error)
      : points_(points), outline_(std::move(outline)), squares_(points), max_error_(max_error) {
    const HeightRange range = height_range(points);
    slack_ = 0x1p-60L * (static_cast<long double>(range.upper) - range.lower);
  }

  /// In floats, or in places.
  void take(const PlacedSurfaceView& placed) {
    triangles_ = turning_left(placed.surface, points_);
    for (std::uint32_t v = 0; v < placed.surface.positions.size(); ++v)
      add_vertex(find_point(placed, placed.world_position(v)));
  }
  /// Exactly.
  void take(const delaunay::Tin& tin) {
    triangles_ = tin.triangles;
    const auto place = [](LatticePoint p) { return std::pair(p.y, p.x); };
    for (std::size_t v = 0; v < tin.vertices.size(); ++v) {
      const auto at = std::ranges::lower_bound(points_.nodes, place(tin.vertices[v]), {}, place);
      const auto number = static_cast<std::uint32_t>(at - points_.nodes.begin());
      const bool is_point = at != points_.nodes.end() && *at == tin.vertices[v] &&
                            points_.heights[number] == tin.heights[v];
      add_vertex(is_point ? std::optional(number) : std::nullopt);
    }
  }

  /// The same of vertices wherever they are.
  void take_any(const delaunay::Tin& tin) {
    triangles_ = tin.triangles;
    nodes_ = tin.vertices;
    heights_ = tin.heights;
  }

  Result<TinFacts> run(std::span<const std::array<std::uint32_t, 2>> lines, std::uint64_t n_samples,
                       Threads threads, Progress& progress) {
    facts_.n_vertices = nodes_.size();
    facts_.n_triangles = triangles_.size();
    if (facts_.n_off_samples > 0) return facts_;
    check_turns(triangles_, nodes_, facts_);
    if (facts_.n_turned > 0) return facts_;
    const TinLines fixed(triangles_, nodes_, places_of(lines));
    facts_.n_lines = lines.size();
    facts_.n_broken_lines = fixed.n_broken();
    check_edges(
        triangles_, nodes_, [this](LatticePoint a, LatticePoint b) { return outline_.has(a, b); },
        facts_, [&](std::uint32_t a, std::uint32_t b) { return fixed.has(a, b); });
    facts_.doubled_domain_area = outline_.doubled_area();
    facts_.n_samples = n_samples;
    LODE_CHECK(check_samples(threads, progress));
    return facts_;
  }

 private:
  void add_vertex(const std::optional<std::uint32_t>& point) {
    nodes_.push_back(points_.nodes[point.value_or(0)]);
    heights_.push_back(points_.heights[point.value_or(0)]);
    facts_.n_off_samples += static_cast<std::uint64_t>(!point.has_value());
  }
  /// What rounding explains of a coordinate: of floats, but of heights where there are places. x
  /// and y may have been floats before: other programs keep what they read in float64.
  [[nodiscard]] static double rounding_of(const PlacedSurfaceView& placed, const Vec3d& world,
                                          std::size_t axis) {
    const double of_floats =
        placed.places.empty() || axis < 2
            ? 0x1p-23 * std::abs(world[axis] - placed.surface.origin[axis]) + 0x1p-149
            : 0;
    return of_floats + 0x1p-51 * std::abs(world[axis]);
  }
  /// In columns and rows, and a little more.
  [[nodiscard]] std::array<double, 2> reach_of(const PlacedSurfaceView& placed,
                                               const Vec3d& world) const {
    constexpr double kMore = 0.05;
    const std::array<double, 6>& g = points_.to_world;
    const double area = std::abs(g[1] * g[5] - g[2] * g[4]);
    const double x = rounding_of(placed, world, 0);
    const double y = rounding_of(placed, world, 1);
    return {(std::abs(g[5]) * x + std::abs(g[2]) * y) / area + kMore,
            (std::abs(g[4]) * x + std::abs(g[1]) * y) / area + kMore};
  }
  [[nodiscard]] std::optional<std::uint32_t> find_point(const PlacedSurfaceView& placed,
                                                        const Vec3d& world) {
    const Vec<double, 2> at = points_.lattice(world[0], world[1]);
    const std::array<double, 2> reach = reach_of(placed, world);
    const auto node = [&](double x, double y) {
      constexpr double kMost = 1 << 30;
      return LatticePoint{static_cast<std::int32_t>(std::clamp(std::round(x), -1.0, kMost)),
                          static_cast<std::int32_t>(std::clamp(std::round(y), -1.0, kMost))};
    };
    double allowed = rounding_of(placed, world, 2);
    if (max_error_ > 0) allowed = std::min(allowed, max_error_);
    std::optional<std::uint32_t> best;
    double least = allowed;
    double nearest = 0;  // of those whose height is off by as much
    squares_.for_each_near(
        node(at[0] - reach[0], at[1] - reach[1]), node(at[0] + reach[0], at[1] + reach[1]),
        [&](std::uint32_t i) {
          const LatticePoint& p = points_.nodes[i];
          if (std::abs(p.x - at[0]) > reach[0] || std::abs(p.y - at[1]) > reach[1]) return;
          const double offset = std::abs(world[2] - points_.heights[i]);
          if (offset > least) return;
          const double way = std::hypot(p.x - at[0], p.y - at[1]);
          if (best && offset == least && way >= nearest) return;
          best = i;
          least = offset;
          nearest = way;
        });
    if (best) facts_.height_offset = std::max(facts_.height_offset, least);
    return best;
  }

  [[nodiscard]] std::vector<std::array<LatticePoint, 2>> places_of(
      std::span<const std::array<std::uint32_t, 2>> lines) const {
    std::vector<std::array<LatticePoint, 2>> places;
    for (const auto& [a, b] : lines) places.push_back({points_.nodes[a], points_.nodes[b]});
    return places;
  }

  using Seen = WorstSeen<long double>;

  Result<void> check_samples(Threads threads, Progress& progress) {
    constexpr std::size_t kPiece = 1024;
    std::vector<std::atomic<std::uint8_t>> is_covered(points_.nodes.size());
    LODE_TRY(const Seen all,
             look_at_triangles<long double>(
                 triangles_.size(), kPiece, threads, progress,
                 [&](std::size_t t, Seen& seen) { look_at(triangles_[t], is_covered, seen); }));
    facts_.n_beyond = all.n_beyond;
    facts_.worst_error = static_cast<double>(all.worst);
    facts_.worst = all.at;
    std::uint64_t n_covered = 0;
    for (const auto& flag : is_covered) n_covered += flag.load(std::memory_order_relaxed);
    facts_.n_uncovered = facts_.n_samples - std::min(n_covered, facts_.n_samples);
    return {};
  }

  void look_at(const std::array<std::uint32_t, 3>& t,
               std::vector<std::atomic<std::uint8_t>>& is_covered, Seen& seen) const {
    const std::array<LatticePoint, 3> at{nodes_[t[0]], nodes_[t[1]], nodes_[t[2]]};
    std::array<long double, 3> z{};
    for (std::size_t i = 0; i < 3; ++i) z[i] = heights_[t[i]];
    const auto area = static_cast<long double>(delaunay::doubled_area(at[0], at[1], at[2]));
    const auto [left, right] = std::minmax({at[0].x, at[1].x, at[2].x});
    const auto [low, high] = std::minmax({at[0].y, at[1].y, at[2].y});
    squares_.for_each_near({left, low}, {right, high}, [&](std::uint32_t i) {
      const LatticePoint p = points_.nodes[i];
      const std::array<std::int64_t, 3> weight{delaunay::doubled_area(at[1], at[2], p),
                                               delaunay::doubled_area(at[2], at[0], p),
                                               delaunay::doubled_area(at[0], at[1], p)};
      if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) return;
      is_covered[i].store(1, std::memory_order_relaxed);
      const long double way = (static_cast<long double>(weight[1]) * (z[1] - z[0]) +
                               static_cast<long double>(weight[2]) * (z[2] - z[0])) /
                              area;
      const long double error = std::abs((points_.heights[i] - z[0]) - way);
      seen.n_beyond += static_cast<std::uint64_t>(error > max_error_ + slack_);
      seen.join({0, error, p});
    });
  }

  const HeightPoints& points_;
  PointOutline outline_;
  PointSquares squares_;
  double max_error_;
  long double slack_ = 0;  ///< Of errors, by rounding to 64 bits.
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<LatticePoint> nodes_;  ///< By vertex.
  std::vector<double> heights_;
  TinFacts facts_;
};

}  // namespace

template <typename Mesh>
Result<TinFacts> check_point_tin(const Mesh& mesh, const HeightPoints& points,
                                 std::span<const std::array<std::uint32_t, 2>> outline,
                                 std::span<const std::array<std::uint32_t, 2>> lines,
                                 std::uint64_t n_samples, double max_error, Threads threads,
                                 Progress& progress) {
  PointTinChecker checker(points, PointOutline(points, outline), max_error);
  checker.take(mesh);
  return checker.run(lines, n_samples, threads, progress);
}

Result<TinFacts> check_fine_point_tin(const delaunay::Tin& tin, const HeightPoints& points,
                                      std::span<const std::array<std::uint32_t, 2>> outline,
                                      std::span<const std::array<std::uint32_t, 2>> lines,
                                      std::uint64_t n_samples, double max_error, Threads threads,
                                      Progress& progress) {
  PointTinChecker checker(points, PointOutline(points, outline), max_error);
  checker.take_any(tin);
  return checker.run(lines, n_samples, threads, progress);
}

template Result<TinFacts> check_point_tin(const PlacedSurfaceView&, const HeightPoints&,
                                          std::span<const std::array<std::uint32_t, 2>>,
                                          std::span<const std::array<std::uint32_t, 2>>,
                                          std::uint64_t, double, Threads, Progress&);
template Result<TinFacts> check_point_tin(const delaunay::Tin&, const HeightPoints&,
                                          std::span<const std::array<std::uint32_t, 2>>,
                                          std::span<const std::array<std::uint32_t, 2>>,
                                          std::uint64_t, double, Threads, Progress&);

}  // namespace lode
