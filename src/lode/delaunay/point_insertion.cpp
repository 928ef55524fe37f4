#include "lode/delaunay/point_insertion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "lode/delaunay/greedy_loop.h"

namespace lode::delaunay {
namespace {

constexpr std::uint32_t kNone = WorstSample::kNone;

/// Of equal points the smallest is taken. Were it the first in rows, planes would be filled from
/// one side, and nearly all points change lists with every insertion. (The mixer of C. Wellons,
/// "Prospecting for hash functions", 2018.)
std::uint32_t shuffled(std::uint32_t p) {
  p = (p ^ (p >> 16)) * 0x7feb352dU;
  p = (p ^ (p >> 15)) * 0x846ca68bU;
  return p ^ (p >> 16);
}

/// Whether it is known of each point in which triangle's list it is.
enum class Finding : std::uint8_t { none, by_point };

/// The points of each triangle.
class PointLists {
 public:
  PointLists(const PointMesh& mesh, const PointSamples& samples, Finding finding)
      : nodes_(samples.nodes),
        first_(mesh.triangles().size(), kNone),
        next_(samples.nodes.size(), kNone),
        triangle_of_(finding == Finding::by_point ? samples.nodes.size() : 0, kNone) {
    std::vector<bool> is_corner(nodes_.size(), false);
    for (const LatticeTriangle& triangle : mesh.triangles())
      for (const std::uint32_t corner : triangle.corner) is_corner[corner] = true;
    for (std::uint32_t p = 0; p < nodes_.size(); ++p)
      if (const std::uint32_t t = samples.triangle_of[p]; t != kNoHalfEdge && !is_corner[p])
        add(p, t);
  }

  /// Inserts a point of triangle t, and hands those of removed triangles to the new ones.
  std::span<const std::uint32_t> insert(PointMesh& mesh, std::uint32_t point, std::uint32_t t) {
    const std::size_t n_before = mesh.triangles().size();
    const std::span<const std::uint32_t> made = mesh.insert(point, t);
    first_.resize(mesh.triangles().size(), kNone);
    loose_.clear();
    for (const std::uint32_t slot : made) {
      if (slot >= n_before) break;
      for_each(slot, [&](std::uint32_t p) { loose_.push_back(p); });
      first_[slot] = kNone;
    }
    sort_fan(mesh, made);
    for (const std::uint32_t p : loose_)
      if (p != point) add(p, find_in_fan(mesh, made, p));
    return made;
  }

  /// Where it is known; kNone: in none.
  [[nodiscard]] std::uint32_t triangle_of(std::uint32_t point) const { return triangle_of_[point]; }
  template <typename Visit>
  void for_each(std::uint32_t t, const Visit& visit) const {
    for (std::uint32_t p = first_[t]; p != kNone; p = next_[p]) visit(p);
  }

 private:
  void add(std::uint32_t p, std::uint32_t t) {
    next_[p] = std::exchange(first_[t], p);
    if (!triangle_of_.empty()) triangle_of_[p] = t;
  }

  static constexpr std::size_t kLargeFan = 32;

  /// A spoke from the fan's middle, and the triangle to the left of it.
  struct Spoke {
    LatticePoint way;
    std::uint32_t triangle;

    /// By angle, from that of (1, 0) once round.
    bool operator<(const Spoke& other) const {
      const bool is_upper = way.y > 0 || (way.y == 0 && way.x > 0);
      const bool is_other = other.way.y > 0 || (other.way.y == 0 && other.way.x > 0);
      if (is_upper != is_other) return is_upper;
      return doubled_area({}, way, other.way) > 0;
    }
  };
  /// Of large fans, so that not all of their triangles need be tried.
  void sort_fan(const PointMesh& mesh, std::span<const std::uint32_t> fan) {
    spokes_.clear();
    if (fan.size() < kLargeFan || loose_.size() < kLargeFan) return;
    const LatticePoint centre = nodes_[mesh.triangles()[fan[0]].corner[2]];
    for (const std::uint32_t t : fan) {
      const LatticePoint p = nodes_[mesh.triangles()[t].corner[0]];
      spokes_.push_back({{p.x - centre.x, p.y - centre.y}, t});
    }
    std::ranges::sort(spokes_, std::less<>());
  }
  /// The triangle to the left of the last spoke that p is not to the right of.
  [[nodiscard]] std::uint32_t find_by_angle(const PointMesh& mesh, std::uint32_t p) const {
    const LatticePoint centre = nodes_[mesh.triangles()[spokes_[0].triangle].corner[2]];
    const Spoke own{{nodes_[p].x - centre.x, nodes_[p].y - centre.y}, kNone};
    auto after = std::upper_bound(spokes_.begin(), spokes_.end(), own);
    return (after == spokes_.begin() ? spokes_.end() : after)[-1].triangle;
  }

  /// Of triangles that turn round their last corner, and together hold p, the first that does:
  /// it is to the left of one side at that corner and to the right of the other, which differ by
  /// less than half a turn.
  [[nodiscard]] std::uint32_t find_in_fan(const PointMesh& mesh, std::span<const std::uint32_t> fan,
                                          std::uint32_t p) const {
    const LatticePoint at = nodes_[p];
    const LatticePoint centre = nodes_[mesh.triangles()[fan[0]].corner[2]];
    if (!spokes_.empty()) {
      const std::uint32_t t = find_by_angle(mesh, p);
      const auto& corner = mesh.triangles()[t].corner;
      if (doubled_area(centre, nodes_[corner[0]], at) >= 0 &&
          doubled_area(centre, nodes_[corner[1]], at) <= 0)
        return t;
    }
    std::uint32_t spoke = kNone;
    std::int64_t side = 0;
    for (const std::uint32_t t : fan) {
      const auto& corner = mesh.triangles()[t].corner;
      if (corner[0] != spoke) side = doubled_area(centre, nodes_[corner[0]], at);
      const std::int64_t next_side = doubled_area(centre, nodes_[corner[1]], at);
      if (side >= 0 && next_side <= 0) return t;
      spoke = corner[1];
      side = next_side;
    }
    LODE_EXPECTS(false);
    return kNone;
  }

  std::span<const LatticePoint> nodes_;
  std::vector<std::uint32_t> first_;        ///< By triangle.
  std::vector<std::uint32_t> next_;         ///< By point.
  std::vector<std::uint32_t> triangle_of_;  ///< Likewise; empty: not known.
  std::vector<std::uint32_t> loose_;
  std::vector<Spoke> spokes_;  ///< Of a large fan, sorted.
};

/// The plane of a triangle of points.
class PointPlane {
 public:
  PointPlane(const PointSamples& samples, const std::array<std::uint32_t, 3>& corner)
      : samples_(samples),
        at_{samples.nodes[corner[0]], samples.nodes[corner[1]], samples.nodes[corner[2]]},
        base_(samples.heights[corner[2]]),
        rise_{samples.heights[corner[0]] - base_, samples.heights[corner[1]] - base_},
        area_(doubled_area(at_[0], at_[1], at_[2])) {}

  struct Seen {
    double error = 0;
    std::uint32_t edge = 3;  ///< Of the triangle, that the point lies on; 3: none.
  };
  [[nodiscard]] Seen look_at(std::uint32_t p) const {
    const LatticePoint q = samples_.nodes[p];
    const std::int64_t weight_0 = doubled_area(at_[1], at_[2], q);
    const std::int64_t weight_1 = doubled_area(at_[2], at_[0], q);
    const double way =
        (static_cast<double>(weight_0) * rise_[0] + static_cast<double>(weight_1) * rise_[1]) /
        static_cast<double>(area_);
    const std::uint32_t edge = weight_0 == 0                  ? 1
                               : weight_1 == 0                ? 2
                               : weight_0 + weight_1 == area_ ? 0
                                                              : 3;
    return {std::abs((samples_.heights[p] - base_) - way), edge};
  }
  [[nodiscard]] bool is_level() const { return rise_[0] == 0 && rise_[1] == 0; }

 private:
  const PointSamples& samples_;
  std::array<LatticePoint, 3> at_;
  double base_;
  std::array<double, 2> rise_;
  std::int64_t area_;
};

/// The worst point of triangles that are beyond the tolerance.
class WorstPoint {
 public:
  WorstPoint(const PointSamples& samples, HeightRange range, double max_error)
      : samples_(samples),
        slack_(kRounding * std::max(0.0, range.upper - range.lower) + kUnderflow),
        max_error_(max_error) {}

  /// Whether there are points on the triangle's edges.
  bool operator()(const PointLists& lists, LatticeTriangle& triangle, std::uint32_t t) const {
    const PointPlane plane(samples_, triangle.corner);
    double worst = 0;
    std::uint32_t node = kNone;
    bool has_edge_points = false;
    lists.for_each(t, [&](std::uint32_t p) {
      const auto [error, edge] = plane.look_at(p);
      has_edge_points = has_edge_points || edge < 3;
      const bool is_first = node == kNone || shuffled(p) < shuffled(node);
      if (error < worst || (error == worst && !is_first)) return;
      worst = error;
      node = p;
    });
    const double bound = node == kNone ? 0 : bound_of(plane, worst);
    triangle.candidate = bound > max_error_ ? node : kNone;
    triangle.error = to_float_above(bound);
    return has_edge_points;
  }
  /// Calls visit(edge, error) for each point of a triangle's list that lies on one of its edges;
  /// the error is a bound, no larger than the triangle's.
  template <typename Visit>
  void visit_edges(const PointLists& lists, const LatticeTriangle& triangle, std::uint32_t t,
                   const Visit& visit) const {
    const PointPlane plane(samples_, triangle.corner);
    lists.for_each(t, [&](std::uint32_t p) {
      const auto [error, edge] = plane.look_at(p);
      if (edge < 3) visit(edge, to_float_above(bound_of(plane, error)));
    });
  }

 private:
  /// With u = 2^-53 and R the range of heights there are nine roundings of numbers up to R:
  /// differences of heights, weights as doubles, products, their sum and quotient, and the last
  /// difference, which is up to 2 R.
  static constexpr double kRounding = 0x1p-49;
  static constexpr double kUnderflow = 0x1p-1040;
  static constexpr double kRoundedUp = 1 + 0x1p-51;

  /// Of a level triangle only one difference is rounded, and zero is exact.
  [[nodiscard]] double bound_of(const PointPlane& plane, double error) const {
    return plane.is_level() ? error * kRoundedUp : error + slack_;
  }

  PointSamples samples_;
  double slack_;
  double max_error_;
};

/// Any point, as long as there are some.
struct AnyPoint {
  bool operator()(const PointLists& lists, LatticeTriangle& triangle, std::uint32_t t) const {
    triangle.candidate = kNone;
    lists.for_each(t, [&](std::uint32_t p) {
      if (triangle.candidate == kNone || shuffled(p) < shuffled(triangle.candidate))
        triangle.candidate = p;
    });
    triangle.error = triangle.candidate == kNone ? 0.0F : 1.0F;
    return false;
  }
  template <typename Visit>
  void visit_edges(const PointLists&, const LatticeTriangle&, std::uint32_t, const Visit&) const {}
};

/// Sets candidates by choose(lists, triangle, its number), which says whether there are points on
/// edges. Such a point is in the list of one triangle, and counts for the one behind the edge, too:
/// not for its candidate, but for what observers are told, and for errors in the end.
template <typename Choose>
class PointJudge {
 public:
  /// `observer` may be null.
  PointJudge(const PointMesh& mesh, const PointSamples& samples, Choose choose,
             PointObserver* observer = nullptr, Finding finding = Finding::none)
      : lists_(mesh, samples, finding), choose_(choose), observer_(observer) {}

  void judge_all(PointMesh& mesh) {
    const auto n = static_cast<std::uint32_t>(mesh.triangles().size());
    has_edge_points_.resize(n);
    for (std::uint32_t t = 0; t < n; ++t)
      has_edge_points_[t] = choose_(lists_, mesh.triangle(t), t);
    if (observer_ == nullptr) return;
    for (const LatticeTriangle& triangle : mesh.triangles()) errors_.push_back(triangle.error);
    for (std::uint32_t t = 0; t < n; ++t)
      raise_behind(mesh, t, [&](std::uint32_t behind, float error) { raise(behind, error); });
    observer_->on_start(mesh, errors_);
  }
  std::span<const std::uint32_t> insert(PointMesh& mesh, std::uint32_t t) {
    const std::size_t n_before = mesh.triangles().size();
    const std::uint32_t node = mesh.triangle(t).candidate;
    const std::span<const std::uint32_t> made = lists_.insert(mesh, node, t);
    has_edge_points_.resize(mesh.triangles().size());
    for (const std::uint32_t one : made)
      has_edge_points_[one] = choose_(lists_, mesh.triangle(one), one);
    if (observer_ != nullptr) {
      find_errors(mesh, made);
      const std::size_t n_added = mesh.triangles().size() - n_before;
      observer_->on_insertion(mesh, node, made, made.size() - n_added, made_errors_);
    }
    return made;
  }
  /// The point's triangle gets it for its candidate.
  [[nodiscard]] std::uint32_t choose(PointMesh& mesh, std::uint32_t point) const {
    const std::uint32_t t = lists_.triangle_of(point);
    LODE_EXPECTS(t != kNone);
    mesh.triangle(t).candidate = point;
    return t;
  }
  /// When no more is inserted.
  void share_errors(PointMesh& mesh) const {
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t)
      raise_behind(mesh, t, [&](std::uint32_t behind, float error) {
        mesh.triangle(behind).error = std::max(mesh.triangle(behind).error, error);
      });
  }

 private:
  void raise(std::uint32_t t, float error) { errors_[t] = std::max(errors_[t], error); }
  /// raise(triangle behind an edge, error of a point on it) for the points in t's list.
  template <typename Raise>
  void raise_behind(const PointMesh& mesh, std::uint32_t t, const Raise& raise) const {
    if (!has_edge_points_[t]) return;
    choose_.visit_edges(lists_, mesh.triangles()[t], t, [&](std::uint32_t edge, float error) {
      if (const std::uint32_t twin = mesh.behind(t, edge); twin != kNoHalfEdge)
        raise(twin >> 2, error);
    });
  }
  /// Of new triangles. What is behind their border knows the points on it since that edge is there:
  /// those of lists that were replaced, and its own.
  void find_errors(const PointMesh& mesh, std::span<const std::uint32_t> made) {
    errors_.resize(mesh.triangles().size());
    for (const std::uint32_t one : made) errors_[one] = mesh.triangles()[one].error;
    for (const std::uint32_t one : made) {
      raise_behind(mesh, one, [&](std::uint32_t behind, float error) { raise(behind, error); });
      const std::uint32_t twin = mesh.behind(one, 0);
      if (twin != kNoHalfEdge)
        raise_behind(mesh, twin >> 2,
                     [&](std::uint32_t behind, float error) { raise(behind, error); });
    }
    made_errors_.clear();
    for (const std::uint32_t one : made) made_errors_.push_back(errors_[one]);
  }

  PointLists lists_;
  Choose choose_;
  PointObserver* observer_;
  std::vector<bool> has_edge_points_;  ///< By triangle, in its list.
  std::vector<float> errors_;          ///< By triangle, those on its edges included.
  std::vector<float> made_errors_;
};

/// Tiles of some thousand points.
int tile_bits_of(LatticePoint last, std::size_t n_points) {
  constexpr std::size_t kPerTile = 4096;
  constexpr int kMostBits = 30;
  const auto n_tiles = [&](int bits) {
    return ((std::uint64_t{static_cast<std::uint32_t>(last.x)} >> bits) + 1) *
           ((std::uint64_t{static_cast<std::uint32_t>(last.y)} >> bits) + 1);
  };
  int bits = 0;
  while (bits < kMostBits && n_tiles(bits) > n_points / kPerTile + 1) ++bits;
  return bits;
}

}  // namespace

Result<GreedyReport> insert_points(PointMesh& mesh, const PointSamples& samples, HeightRange range,
                                   const GreedyOptions& options, Progress& progress,
                                   PointObserver* observer) {
  LODE_EXPECTS(options.max_error >= 0 && options.observer == nullptr);
  LODE_EXPECTS(samples.triangle_of.size() == samples.nodes.size());
  LODE_EXPECTS(options.order == InsertionOrder::strict ||
               options.max_triangles == std::numeric_limits<std::uint64_t>::max());
  PointJudge judge(mesh, samples, WorstPoint(samples, range, options.max_error), observer);
  const LatticePart part = part_of(mesh);
  LODE_TRY(const GreedyReport report,
           GreedyLoop(mesh, judge, options, progress)
               .run(part, tile_bits_of(part.last, samples.nodes.size())));
  judge.share_errors(mesh);
  return report;
}

Result<void> insert_points_in_order(PointMesh& mesh, const PointSamples& samples, HeightRange range,
                                    std::span<const std::uint32_t> order, PointObserver& observer,
                                    Progress& progress) {
  // The first ones hand on all points.
  constexpr std::size_t kPerReport = 64;
  LODE_EXPECTS(samples.triangle_of.size() == samples.nodes.size());
  if (mesh.triangles().size() + 2 * order.size() > kMostTriangles)
    return fail("expected up to {} triangles, got {} points to insert", kMostTriangles,
                order.size());
  // No error is beyond this, so that all are found as they are.
  constexpr double kAny = std::numeric_limits<double>::infinity();
  PointJudge judge(mesh, samples, WorstPoint(samples, range, kAny), &observer, Finding::by_point);
  judge.judge_all(mesh);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kPerReport == 0) {
      if (progress.is_cancelled()) return cancelled_error();
      progress.report("inserting", static_cast<double>(i) / static_cast<double>(order.size()));
    }
    judge.insert(mesh, judge.choose(mesh, order[i]));
  }
  judge.share_errors(mesh);
  return {};
}

Result<void> insert_all_points(PointMesh& mesh, const PointSamples& samples, Progress& progress) {
  LODE_EXPECTS(samples.triangle_of.size() == samples.nodes.size());
  PointJudge judge(mesh, samples, AnyPoint());
  const LatticePart part = part_of(mesh);
  const auto report = GreedyLoop(mesh, judge, {}, progress)
                          .run(part, tile_bits_of(part.last, samples.nodes.size()));
  if (!report) return report.error();
  return {};
}

}  // namespace lode::delaunay
