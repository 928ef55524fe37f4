#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "lode/delaunay/lattice_mesh.h"
#include "lode/models/terrain/insertions/box_tree.h"
#include "lode/models/terrain/insertions/overlap.h"

namespace lode::insertions {

/// Where vertices lie that remove a triangle.
class Reach {
 public:
  Reach(const LatticeCorners& triangle, delaunay::InsertionRule rule)
      : triangle_(triangle), is_circle_(rule == delaunay::InsertionRule::delaunay) {
    box_ = box_of(triangle);
    if (is_circle_) find_circle();
  }

  /// Of everything that may be in it.
  [[nodiscard]] const LatticeBox& box() const { return box_; }
  /// False only where nothing in the box is in it.
  [[nodiscard]] bool may_meet(const LatticeBox& box) const {
    if (!box.meets(box_)) return false;
    if (!is_circle_) return true;
    const auto beside = [](double x, double low, double high) {
      return std::max({low - x, x - high, 0.0});
    };
    const double dx = beside(x_, box.lower.x, box.upper.x);
    const double dy = beside(y_, box.lower.y, box.upper.y);
    return dx * dx + dy * dy <= radius_ * radius_;
  }
  /// Exactly.
  [[nodiscard]] bool has(delaunay::LatticePoint p) const {
    if (is_circle_) return delaunay::is_in_circle(triangle_[0], triangle_[1], triangle_[2], p);
    return holds(triangle_, p) && std::ranges::find(triangle_, p) == triangle_.end();
  }

 private:
  /// A larger one than it is, by more than rounding: roundings of the centre are a few units in the
  /// last place of what it is the difference of.
  void find_circle() {
    constexpr double kRounding = 0x1p-46;
    const delaunay::LatticePoint a = triangle_[0];
    const double bx = triangle_[1].x - a.x;
    const double by = triangle_[1].y - a.y;
    const double cx = triangle_[2].x - a.x;
    const double cy = triangle_[2].y - a.y;
    const double b2 = bx * bx + by * by;
    const double c2 = cx * cx + cy * cy;
    const auto area =
        static_cast<double>(2 * delaunay::doubled_area(triangle_[0], triangle_[1], triangle_[2]));
    const double x = (cy * b2 - by * c2) / area;
    const double y = (bx * c2 - cx * b2) / area;
    const double terms =
        ((std::abs(cy) + std::abs(cx)) * b2 + (std::abs(by) + std::abs(bx)) * c2) / area;
    x_ = a.x + x;
    y_ = a.y + y;
    radius_ = std::sqrt(x * x + y * y) * (1 + kRounding) + kRounding * terms + 1;
    static constexpr double kEdge = 0x1p30;
    const auto clamped = [](double at) {
      return static_cast<std::int32_t>(std::clamp(at, -kEdge, kEdge));
    };
    box_ = {{clamped(std::floor(x_ - radius_)), clamped(std::floor(y_ - radius_))},
            {clamped(std::ceil(x_ + radius_)), clamped(std::ceil(y_ + radius_))}};
  }

  LatticeCorners triangle_;
  bool is_circle_;
  double x_ = 0;
  double y_ = 0;
  double radius_ = 0;
  LatticeBox box_;
};

}  // namespace lode::insertions
