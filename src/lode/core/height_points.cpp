#include "lode/core/height_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

namespace lode {
namespace {

constexpr std::int64_t kMostNodes = std::int64_t{1} << 30;
constexpr std::size_t kMostPoints = std::size_t{1} << 29;
/// Farthest from the origin, and finest step: doubles hold areas between such points.
constexpr double kFarthest = 1e150;
constexpr double kFinestStep = 1e-150;

/// Of the points' rectangle.
struct Extent {
  std::array<double, 2> lower;
  std::array<double, 2> upper;
};

Extent extent_of(std::span<const Vec3d> points) {
  Extent extent{{points[0][0], points[0][1]}, {points[0][0], points[0][1]}};
  for (const Vec3d& p : points)
    for (std::size_t i = 0; i < 2; ++i) {
      extent.lower[i] = std::min(extent.lower[i], p[i]);
      extent.upper[i] = std::max(extent.upper[i], p[i]);
    }
  return extent;
}

/// The given lattice, moved to the rectangle's corner; none where it does not fit.
PointLattice moved_lattice(const PointLattice& lattice, const Extent& extent) {
  // Whole numbers of steps are far from where doubles do not tell them apart.
  constexpr double kMostSteps = 0x1p50;
  PointLattice moved{{}, lattice.step};
  if (!(lattice.step >= kFinestStep)) return {};
  for (std::size_t i = 0; i < 2; ++i) {
    const double first = std::round((extent.lower[i] - lattice.origin[i]) / lattice.step);
    const double last = std::round((extent.upper[i] - lattice.origin[i]) / lattice.step);
    const double size = std::max(std::abs(lattice.origin[i]), std::abs(extent.upper[i]));
    if (!(last - first < static_cast<double>(kMostNodes)) || size / lattice.step > kMostSteps ||
        std::abs(first) > kMostSteps)
      return {};
    moved.origin[i] = lattice.origin[i] + first * lattice.step;
  }
  return moved;
}

PointLattice fitting_lattice(const Extent& extent) {
  const double range =
      std::max(extent.upper[0] - extent.lower[0], extent.upper[1] - extent.lower[1]);
  PointLattice lattice{extent.lower, 1};
  if (!(range > 0)) return lattice;
  int exponent = 0;
  std::frexp(range, &exponent);  // range < 2^exponent
  lattice.step = std::max(std::ldexp(1, exponent - 30), kFinestStep);
  if (std::round(range / lattice.step) >= static_cast<double>(kMostNodes)) lattice.step *= 2;
  return lattice;
}

/// Points in the order of their nodes, and those of one node in that of the file.
std::vector<std::uint32_t> order_by_nodes(const std::vector<LatticePoint>& nodes) {
  std::vector<std::uint32_t> order(nodes.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto key = [&](std::uint32_t i) {
    return std::uint64_t{static_cast<std::uint32_t>(nodes[i].y)} << 32 |
           static_cast<std::uint32_t>(nodes[i].x);
  };
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return key(a) != key(b) ? key(a) < key(b) : a < b;
  });
  return order;
}

/// Heights of one node as one.
class HeightMerge {
 public:
  void add(double height) {
    lowest_ = n_ == 0 ? height : std::min(lowest_, height);
    highest_ = n_ == 0 ? height : std::max(highest_, height);
    // Differences from the first lose less to rounding.
    if (n_ == 0) first_ = height;
    sum_ += height - first_;
    ++n_;
  }
  [[nodiscard]] double spread() const { return highest_ - lowest_; }
  [[nodiscard]] double height(RepeatedHeights repeated) const {
    if (repeated == RepeatedHeights::lowest) return lowest_;
    if (repeated == RepeatedHeights::highest) return highest_;
    return std::clamp(first_ + sum_ / static_cast<double>(n_), lowest_, highest_);
  }

 private:
  std::uint64_t n_ = 0;
  double first_ = 0;
  double sum_ = 0;
  double lowest_ = 0;
  double highest_ = 0;
};

Result<void> check_count(std::size_t n) {
  if (n == 0) return fail("expected points, got none");
  if (n >= kMostPoints) return fail("expected fewer than {} points, got {}", kMostPoints, n);
  return {};
}

Result<void> check_extent(const Extent& extent) {
  for (std::size_t i = 0; i < 2; ++i)
    if (!(extent.lower[i] >= -kFarthest && extent.upper[i] <= kFarthest))
      return fail("expected points whose x and y are from {} to {}, got {} to {}", -kFarthest,
                  kFarthest, extent.lower[i], extent.upper[i]);
  return {};
}

}  // namespace

Result<HeightPoints> to_height_points(std::span<const Vec3d> points, const PointLattice& lattice,
                                      RepeatedHeights repeated) {
  LODE_CHECK(check_count(points.size()));
  const Extent extent = extent_of(points);
  LODE_CHECK(check_extent(extent));
  PointLattice used = moved_lattice(lattice, extent);
  if (used.step == 0) used = fitting_lattice(extent);
  HeightPoints made;
  made.to_world = {used.origin[0], used.step, 0, used.origin[1], 0, used.step};
  std::vector<LatticePoint> nodes;
  nodes.reserve(points.size());
  for (const Vec3d& p : points) {
    const auto node_of = [&](std::size_t i) {
      return static_cast<std::int32_t>(std::round((p[i] - used.origin[i]) / used.step));
    };
    const LatticePoint& node = nodes.emplace_back(LatticePoint{node_of(0), node_of(1)});
    const Vec<double, 2> at = made.world(node.x, node.y);
    made.largest_move = std::max(made.largest_move, std::hypot(at[0] - p[0], at[1] - p[1]));
    made.n_columns = std::max(made.n_columns, node.x + 1);
    made.n_rows = std::max(made.n_rows, node.y + 1);
  }
  const std::vector<std::uint32_t> order = order_by_nodes(nodes);
  for (std::size_t i = 0; i < order.size();) {
    const LatticePoint node = nodes[order[i]];
    HeightMerge merge;
    const std::size_t first = i;
    for (; i < order.size() && nodes[order[i]] == node; ++i) merge.add(points[order[i]][2]);
    if (i - first > 1 && repeated == RepeatedHeights::refused)
      return fail("expected one height at each position, got {} at {}, {}, which differ by {}",
                  i - first, points[order[first]][0], points[order[first]][1], merge.spread());
    made.nodes.push_back(node);
    made.heights.push_back(merge.height(repeated));
    made.n_repeated += i - first - 1;
    made.largest_spread = std::max(made.largest_spread, merge.spread());
  }
  return made;
}

HeightRange height_range(const HeightPoints& points) {
  if (points.heights.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(points.heights);
  return {lowest, highest};
}

}  // namespace lode
