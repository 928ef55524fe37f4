#include "lode/io/polygon_triangles.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace lode::io {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::size_t kMostEars = 100;  // work grows with the cube of their number

Triangles fan_of(std::span<const std::uint32_t> polygon) {
  Triangles triangles;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
  return triangles;
}

/// A polygon as seen along the normal of its area.
class FlatPolygon {
 public:
  FlatPolygon(std::span<const Vec3d> points, std::span<const std::uint32_t> polygon)
      : points_(points), rest_(polygon.begin(), polygon.end()) {
    for (const auto& t : fan_of(polygon)) normal_ = normal_ + normal_of(t);
  }

  /// Whether the fan covers something twice, more than roundings do.
  [[nodiscard]] bool folds() const {
    constexpr double kRounding = 1e-9;
    const double least = -kRounding * dot(normal_, normal_);
    const Triangles fan = fan_of(rest_);
    return std::any_of(fan.begin(), fan.end(),
                       [&](const auto& t) { return dot(normal_of(t), normal_) < least; });
  }

  /// Nothing where at some time there is no ear.
  Triangles cut_ears() {
    Triangles triangles;
    while (rest_.size() > 3) {
      const std::size_t ear = highest_ear();
      if (ear == rest_.size()) return {};
      triangles.push_back(corner(ear));
      rest_.erase(rest_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({rest_[0], rest_[1], rest_[2]});
    return triangles;
  }

 private:
  [[nodiscard]] Vec3d normal_of(const std::array<std::uint32_t, 3>& t) const {
    return cross(points_[t[1]] - points_[t[0]], points_[t[2]] - points_[t[0]]);
  }
  [[nodiscard]] std::array<std::uint32_t, 3> corner(std::size_t i) const {
    const std::size_t n = rest_.size();
    return {rest_[(i + n - 1) % n], rest_[i], rest_[(i + 1) % n]};
  }
  /// Positive where it is wound as the polygon is.
  [[nodiscard]] double area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return dot(normal_of({a, b, c}), normal_);
  }

  [[nodiscard]] bool is_ear(const std::array<std::uint32_t, 3>& t) const {
    const auto& [a, b, c] = t;
    if (area(a, b, c) <= 0) return false;
    return std::none_of(rest_.begin(), rest_.end(), [&, a = a, b = b, c = c](std::uint32_t p) {
      return p != a && p != b && p != c && area(a, b, p) >= 0 && area(b, c, p) >= 0 &&
             area(c, a, p) >= 0;
    });
  }
  [[nodiscard]] std::size_t highest_ear() const {
    std::size_t best = rest_.size();
    double highest = 0;
    for (std::size_t i = 0; i < rest_.size(); ++i) {
      const auto t = corner(i);
      double longest = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d side = points_[t[(k + 1) % 3]] - points_[t[k]];
        longest = std::max(longest, dot(side, side));
      }
      const double height = longest > 0 ? area(t[0], t[1], t[2]) / longest : 0;
      if (height <= highest || !is_ear(t)) continue;
      best = i;
      highest = height;
    }
    return best;
  }

  std::span<const Vec3d> points_;
  std::vector<std::uint32_t> rest_;
  Vec3d normal_;
};

}  // namespace

Triangles polygon_triangles(std::span<const Vec3d> points, std::span<const std::uint32_t> polygon) {
  std::vector<std::uint32_t> loop(polygon.begin(), polygon.end());
  std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
  Triangles fan = fan_of(loop);
  if (loop.size() <= 4 || loop.size() > kMostEars) return fan;
  // To the smaller one of the points beside it.
  const bool is_turned = loop.back() < loop[1];
  if (is_turned) std::reverse(loop.begin() + 1, loop.end());
  FlatPolygon flat(points, loop);
  if (!flat.folds()) return fan;
  Triangles triangles = flat.cut_ears();
  if (triangles.empty()) return fan;
  if (is_turned)
    for (auto& triangle : triangles) std::swap(triangle[1], triangle[2]);
  return triangles;
}

}  // namespace lode::io
