#include "lode/models/tetra_mt/patch_deviation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lode::tetra_mt {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// A patch seen along the mean normal of its old triangles.
class FlatPatch {
 public:
  explicit FlatPatch(const Patch& patch) : n_(patch.n), is_closed_(patch.is_closed) {
    Vec3d normal;
    for (int i = 0; i < n_sides(); ++i)
      normal = normal + cross(patch.ring[at(i)], patch.ring[at((i + 1) % n_)]);
    const double size = length(normal);
    if (!(size > 0)) return;
    normal = normal * (1 / size);
    // Any two directions across from it.
    const bool is_along_x = std::abs(normal[0]) > 0.7;
    const Vec3d axis{{is_along_x ? 0.0 : 1.0, is_along_x ? 1.0 : 0.0, 0.0}};
    Vec3d right = cross(axis, normal);
    right = right * (1 / length(right));
    const Vec3d up = cross(normal, right);
    for (std::size_t i = 0; i < at(n_); ++i) {
      const Vec3d& p = patch.ring[i];
      points_[i] = {dot(right, p), dot(up, p), dot(normal, p)};
    }
    is_seen_ = shows_old() && shows_new();
  }

  /// The largest distance along the normal.
  [[nodiscard]] double deviation(double limit) const {
    if (!is_seen_) return kUnknown;
    double largest = at_origin();
    if (largest > limit) return kUnknown;
    for (int i = 1; i < n_; ++i)
      for (int j = 2; j < (is_closed_ ? n_ - 1 : n_); ++j)
        if (i != j) largest = std::max(largest, at_crossing(at(i), at(j)));
    return largest;
  }

 private:
  struct Point {
    double x;
    double y;
    double height;
  };

  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] static double turn(const Point& a, const Point& b) { return a.x * b.y - a.y * b.x; }
  [[nodiscard]] static bool turns_left(const Point& a, const Point& b) {
    return turn(a, b) > kLeastSeen * std::sqrt(square(a) * square(b));
  }
  [[nodiscard]] static double square(const Point& a) {
    return a.x * a.x + a.y * a.y + a.height * a.height;
  }
  [[nodiscard]] Point from_first(std::size_t i) const {
    return {points_[i].x - points_[0].x, points_[i].y - points_[0].y,
            points_[i].height - points_[0].height};
  }
  /// Of the old triangles, each from one corner of the ring to the next.
  [[nodiscard]] int n_sides() const { return is_closed_ ? n_ : n_ - 1; }

  /// All old triangles turn to the left, and less than once round the origin until the last.
  [[nodiscard]] bool shows_old() const {
    for (int i = 0; i < n_sides(); ++i)
      if (!turns_left(points_[at(i)], points_[at((i + 1) % n_)])) return false;
    for (int i = 1; i + 1 < n_; ++i)
      if (turn(points_[0], points_[at(i)]) < 0 && turn(points_[0], points_[at(i + 1)]) >= 0)
        return false;
    return true;
  }
  /// With the same outline as the old ones, they lie side by side if all turn to the left.
  [[nodiscard]] bool shows_new() const {
    for (int i = 1; i + 1 < n_; ++i)
      if (!turns_left(from_first(at(i)), from_first(at(i + 1)))) return false;
    return true;
  }
  /// From the new triangle that the origin is in, if there is one.
  [[nodiscard]] double at_origin() const {
    double height = 0;
    double most_inside = is_closed_ ? -kUnknown : 0.0;
    for (std::size_t i = 1; i + 1 < at(n_); ++i) {
      const double whole = turn(from_first(i), from_first(i + 1));
      const double a = turn(points_[i], points_[i + 1]) / whole;
      const double b = turn(points_[i + 1], points_[0]) / whole;
      const double c = turn(points_[0], points_[i]) / whole;
      const double inside = std::min({a, b, c});
      if (!(inside > most_inside)) continue;
      most_inside = inside;
      height = std::abs(a * points_[0].height + b * points_[i].height + c * points_[i + 1].height);
    }
    return height;
  }
  /// Of the old edge to one corner and the new one to another.
  [[nodiscard]] double at_crossing(std::size_t old_end, std::size_t new_end) const {
    const Point along = from_first(new_end);
    const double turns = turn(points_[old_end], along);
    const double s = turn(points_[0], along) / turns;
    const double t = turn(points_[0], points_[old_end]) / turns;
    if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) return 0;
    return std::abs(s * points_[old_end].height - (points_[0].height + t * along.height));
  }

  int n_;
  bool is_closed_;
  bool is_seen_ = false;
  std::array<Point, Star::kMaxLink> points_;
};

double cosine(const Vec3d& a, const Vec3d& b) { return dot(a, b) / (length(a) * length(b)); }

}  // namespace

double distance_to_line(const Vec3d& a, const Vec3d& b) {
  const Vec3d along = b - a;
  const double square = dot(along, along);
  const double t = square > 0 ? std::clamp(-dot(a, along) / square, 0.0, 1.0) : 0.0;
  const bool is_between = t > 0 && t < 1;
  return is_between && length(cross(a, b)) == 0 ? 0 : length(a + along * t);
}

double patch_deviation(const Patch& patch, double limit) {
  if (patch.n < 2 || (patch.is_closed && patch.n < 3)) return kUnknown;
  const double edge =
      patch.is_closed
          ? 0
          : distance_to_line(patch.ring[0], patch.ring[static_cast<std::size_t>(patch.n - 1)]);
  // Of one triangle nothing but the line is left.
  const double all = patch.n == 2 ? edge : edge + FlatPatch(patch).deviation(limit - edge);
  return all <= limit ? all : kUnknown;
}

double distance_to_triangle(const Vec3d& p, const std::array<Vec3d, 3>& triangle) {
  const Vec3d normal = cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  bool is_above = true;
  double nearest = kUnknown;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d a = triangle[i] - p;
    const Vec3d b = triangle[(i + 1) % 3] - p;
    is_above = is_above && dot(cross(a, b), normal) >= 0;
    nearest = std::min(nearest, distance_to_line(a, b));
  }
  return is_above ? std::abs(dot(p - triangle[0], normal)) / length(normal) : nearest;
}

double sheet_deviation(const Patch& patch, double limit) {
  const double whole = patch_deviation(patch, limit);
  if (!patch.is_closed || patch.n < 3 || whole == 0) return whole;
  const auto n = static_cast<std::size_t>(patch.n);
  const auto& ring = patch.ring;
  std::size_t opposite = 1;
  for (std::size_t i = 2; i < n; ++i)
    if (cosine(ring[0], ring[i]) < cosine(ring[0], ring[opposite])) opposite = i;
  Patch left{.ring = {}, .n = static_cast<int>(opposite) + 1, .is_closed = false};
  std::copy_n(ring.begin(), opposite + 1, left.ring.begin());
  Patch right{.ring = {}, .n = static_cast<int>(n - opposite) + 1, .is_closed = false};
  right.ring[0] = ring[0];
  for (std::size_t i = n; i-- > opposite;) right.ring[n - i] = ring[i];
  return std::min(whole, std::max(patch_deviation(left, limit), patch_deviation(right, limit)));
}

}  // namespace lode::tetra_mt
