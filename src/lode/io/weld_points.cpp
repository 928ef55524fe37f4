#include "lode/io/weld_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "lode/core/expects.h"
#include "lode/core/flat_index.h"

namespace lode::io {
namespace {

constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

std::uint64_t mixed(std::uint64_t seed, double x) {
  // 0 and -0 are one place.
  std::uint64_t z = (seed ^ std::bit_cast<std::uint64_t>(x + 0.0)) + 0x9E3779B97F4A7C15ULL;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31);
}

std::uint64_t key_of(const Vec3d& place) {
  return mixed(mixed(mixed(0, place[0]), place[1]), place[2]);
}

/// Points under keys that others may share: who looks one up checks what it finds.
class PointBuckets {
 public:
  explicit PointBuckets(std::size_t n_points) : next_(n_points, kNoPoint) {}

  void add(std::uint64_t key, std::uint32_t point) {
    std::uint32_t bucket = index_.find(key);
    if (bucket == FlatIndex::kNone) {
      bucket = static_cast<std::uint32_t>(heads_.size());
      index_.insert(key, bucket);
      heads_.push_back(kNoPoint);
    }
    next_[point] = heads_[bucket];
    heads_[bucket] = point;
  }

  template <typename F>
  void for_each(std::uint64_t key, F&& visit) const {
    const std::uint32_t bucket = index_.find(key);
    if (bucket == FlatIndex::kNone) return;
    for (std::uint32_t point = heads_[bucket]; point != kNoPoint; point = next_[point])
      visit(point);
  }

 private:
  FlatIndex index_;
  std::vector<std::uint32_t> heads_;
  std::vector<std::uint32_t> next_;
};

bool is_close(double a, double b, double tolerance) {
  return a == b || std::abs(a - b) <= tolerance || (std::isnan(a) && std::isnan(b));
}

class Welder {
 public:
  Welder(std::span<const Vec3d> points, const std::vector<MeshField>& fields, const WeldRule& rule)
      : points_(points), fields_(fields), rule_(rule), buckets_(points.size()) {
    double largest = 0;
    for (const Vec3d& point : points)
      for (const double x : point.v) largest = std::max(largest, std::abs(x));
    // Boxes of at least 2^-40 of the extent: their numbers are whole in double.
    box_ = std::max(rule.distance, largest * 0x1p-40);
  }

  void weld(std::uint32_t point, Weld& result) {
    std::uint32_t same = kNoPoint;
    bool is_near = false;
    for_each_near(point, [&](std::uint32_t other) {
      is_near = true;
      if (other < same && has_values_of(point, other)) same = other;
    });
    if (same != kNoPoint) {
      result.ids[point] = same;
      ++result.n_welded;
      return;
    }
    if (is_near) ++result.n_refused;
    buckets_.add(key_of(is_exact() ? points_[point] : box_of(points_[point])), point);
  }

 private:
  [[nodiscard]] bool is_exact() const { return rule_.distance == 0; }

  [[nodiscard]] Vec3d box_of(const Vec3d& p) const {
    return {{std::floor(p[0] / box_), std::floor(p[1] / box_), std::floor(p[2] / box_)}};
  }

  [[nodiscard]] bool has_values_of(std::uint32_t a, std::uint32_t b) const {
    for (const MeshField& field : fields_)
      for (int k = 0; k < field.n_components; ++k)
        if (!is_close(field.at(a, k), field.at(b, k), rule_.values)) return false;
    return true;
  }

  template <typename F>
  void for_each_near(std::uint32_t point, F&& visit) const {
    const Vec3d& p = points_[point];
    if (is_exact()) {
      buckets_.for_each(key_of(p), [&](std::uint32_t other) {
        if (points_[other] == p) visit(other);
      });
      return;
    }
    const Vec3d middle = box_of(p);
    for (int i = 0; i < 27; ++i) {
      const std::array<int, 3> step = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const Vec3d box = middle + Vec3d{{1.0 * step[0], 1.0 * step[1], 1.0 * step[2]}};
      // A point whose box's key is that of another one's would come twice, which does no harm.
      buckets_.for_each(key_of(box), [&](std::uint32_t other) {
        if (length(points_[other] - p) <= rule_.distance) visit(other);
      });
    }
  }

  std::span<const Vec3d> points_;
  const std::vector<MeshField>& fields_;
  WeldRule rule_;
  double box_ = 0;
  PointBuckets buckets_;
};

}  // namespace

Weld weld_points(std::span<const Vec3d> points, const std::vector<MeshField>& fields,
                 const std::vector<std::uint8_t>& is_used, const WeldRule& rule) {
  LODE_EXPECTS(rule.distance >= 0 && points.size() == is_used.size());
  Weld result;
  result.ids.resize(points.size());
  Welder welder(points, fields, rule);
  for (std::uint32_t point = 0; point < points.size(); ++point) {
    result.ids[point] = point;
    if (is_used[point] != 0) welder.weld(point, result);
  }
  return result;
}

std::uint64_t count_coincident(std::span<const Vec3d> points) {
  return weld_points(points, {}, std::vector<std::uint8_t>(points.size(), 1), {}).n_welded;
}

}  // namespace lode::io
