#include "bench/surface_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace lode::bench {
namespace {

using Corners = std::array<Vec3d, 3>;

Corners corners_of(const Surface& surface, std::size_t t) {
  const auto& v = surface.triangles[t];
  return {surface.world_position(v[0]), surface.world_position(v[1]), surface.world_position(v[2])};
}

double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d e = b - a;
  const double along = dot(e, e);
  const double t = along > 0 ? std::clamp(dot(p - a, e) / along, 0.0, 1.0) : 0;
  return length(p - (a + e * t));
}

double triangle_distance(const Vec3d& p, const Corners& t) {
  const Vec3d n = cross(t[1] - t[0], t[2] - t[0]);
  bool is_above = dot(n, n) > 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d& a = t[i];
    const Vec3d& b = t[(i + 1) % 3];
    is_above = is_above && dot(cross(n, b - a), p - a) >= 0;
    least = std::min(least, segment_distance(p, a, b));
  }
  return is_above ? std::abs(dot(n, p - t[0])) / length(n) : least;
}

/// Triangles by the cells of a lattice that their boxes touch.
class Target {
 public:
  Target(const Surface& surface, double edge) : edge_(edge) {
    for (std::size_t i = 0; i < 3; ++i) lower_[i] = std::numeric_limits<double>::max();
    Vec3d upper = -1.0 * lower_;
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      triangles_.push_back(corners_of(surface, t));
      for (const Vec3d& p : triangles_.back())
        for (std::size_t i = 0; i < 3; ++i) {
          lower_[i] = std::min(lower_[i], p[i]);
          upper[i] = std::max(upper[i], p[i]);
        }
    }
    for (std::size_t i = 0; i < 3; ++i) dims_[i] = index(upper[i], i) + 1;
    cells_.resize(static_cast<std::size_t>(dims_[0]) * static_cast<std::size_t>(dims_[1]) *
                  static_cast<std::size_t>(dims_[2]));
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) add(t);
  }

  /// Looks in ever larger cubes of cells, until nothing outside can be nearer.
  [[nodiscard]] double distance(const Vec3d& p) const {
    double least = std::numeric_limits<double>::infinity();
    std::array<int, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = index(p[i], i);
    const int most = std::max({dims_[0], dims_[1], dims_[2]});
    for (int ring = 0; ring <= most && least > (ring - 1) * edge_; ++ring)
      visit_ring(at, ring, [&](std::uint32_t t) {
        least = std::min(least, triangle_distance(p, triangles_[t]));
      });
    return least;
  }

 private:
  [[nodiscard]] int index(double x, std::size_t i) const {
    return static_cast<int>(std::floor((x - lower_[i]) / edge_));
  }
  [[nodiscard]] std::size_t number(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(dims_[1]) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(dims_[0]) +
           static_cast<std::size_t>(x);
  }
  void add(std::uint32_t t) {
    std::array<int, 3> low{};
    std::array<int, 3> high{};
    const Corners& c = triangles_[t];
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = index(std::min({c[0][i], c[1][i], c[2][i]}), i);
      high[i] = index(std::max({c[0][i], c[1][i], c[2][i]}), i);
    }
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) cells_[number(x, y, z)].push_back(t);
  }
  template <typename Visit>
  void visit_ring(const std::array<int, 3>& at, int ring, const Visit& visit) const {
    const auto low = [&](std::size_t i) { return std::max(0, at[i] - ring); };
    const auto high = [&](std::size_t i) { return std::min(dims_[i] - 1, at[i] + ring); };
    for (int z = low(2); z <= high(2); ++z)
      for (int y = low(1); y <= high(1); ++y)
        for (int x = low(0); x <= high(0); ++x) {
          const int far = std::max({std::abs(x - at[0]), std::abs(y - at[1]), std::abs(z - at[2])});
          if (far != ring) continue;
          for (const std::uint32_t t : cells_[number(x, y, z)]) visit(t);
        }
  }

  double edge_;
  Vec3d lower_;
  std::array<int, 3> dims_{};
  std::vector<Corners> triangles_;
  std::vector<std::vector<std::uint32_t>> cells_;
};

double one_sided(const Surface& from, const Surface& to, double spacing, Threads threads) {
  if (from.triangles.empty() || to.triangles.empty()) return 0;
  const Target target(to, 2 * spacing);
  std::vector<double> largest(static_cast<std::size_t>(n_workers(threads)), 0);
  parallel_for(from.triangles.size(), threads, 4096, [&](std::size_t t, int worker) {
    const Corners c = corners_of(from, t);
    const double edge = std::max({length(c[1] - c[0]), length(c[2] - c[1]), length(c[0] - c[2])});
    const int n = std::max(1, static_cast<int>(std::ceil(edge / spacing)));
    double& own = largest[static_cast<std::size_t>(worker)];
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j)
        own = std::max(own, target.distance(c[0] + (c[1] - c[0]) * (static_cast<double>(i) / n) +
                                            (c[2] - c[0]) * (static_cast<double>(j) / n)));
  });
  return *std::max_element(largest.begin(), largest.end());
}

}  // namespace

TwoSidedDistance measure_distance(const Surface& first, const Surface& second, double spacing,
                                  Threads threads) {
  return {one_sided(first, second, spacing, threads), one_sided(second, first, spacing, threads)};
}

}  // namespace lode::bench
