#include "lode/mappers/triangle_cuts.h"

#include <algorithm>
#include <cmath>

#include "lode/core/point_triangle.h"

namespace lode::simplification {
namespace {

struct Cut {
  Vec3d at;
  double distance2 = kUnproven;  ///< From the farther one of both.
};

/// From a, whose triangle is `first`, to b. The distance from either is convex on the way, so that
/// from the nearer one grows: the point that is as far from both is approached from two sides.
Cut find_cut(const Vec3d& a, const Vec3d& b, const Piece& first, const Piece& second,
             double limit2) {
  constexpr int kMostSteps = 6;
  double low = 0;
  double high = 1;
  // Where both would be equal if they were linear, and 0 at their own ends.
  const double from_second = std::sqrt(squared_distance_to_triangle(a, second));
  const double from_first = std::sqrt(squared_distance_to_triangle(b, first));
  const double both = from_second + from_first;
  double s = both > 0 ? from_second / both : 0.5;
  for (int step = 0; step < kMostSteps; ++step) {
    const Vec3d at = a + (b - a) * s;
    const double to_first = squared_distance_to_triangle(at, first);
    const double to_second = squared_distance_to_triangle(at, second);
    if (to_first <= limit2 && to_second <= limit2) return {at, std::max(to_first, to_second)};
    if (to_first > limit2 && to_second > limit2) break;  // neither side is left
    (to_first > limit2 ? high : low) = s;
    s = 0.5 * (low + high);
  }
  return {};
}

}  // namespace

double bound_by_cuts(const Piece& triangle, const std::array<Piece, 3>& targets,
                     const std::array<std::size_t, 3>& which, double limit2) {
  double bound = 0;
  const auto is_near = [&](const Vec3d& p, const Piece& target) {
    const double here = squared_distance_to_triangle(p, target);
    bound = std::max(bound, here);
    return here <= limit2;
  };
  for (std::size_t k = 0; k < 3; ++k)
    if (!is_near(triangle[k], targets[which[k]])) return kUnproven;
  Vec3d middle;
  std::size_t n_cuts = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (which[k] == which[next]) continue;
    const Cut cut =
        find_cut(triangle[k], triangle[next], targets[which[k]], targets[which[next]], limit2);
    if (!(cut.distance2 <= limit2)) return kUnproven;
    bound = std::max(bound, cut.distance2);
    middle = middle + cut.at;
    ++n_cuts;
  }
  if (n_cuts < 3) return bound;
  middle = middle * (1.0 / 3);
  for (const Piece& target : targets)
    if (!is_near(middle, target)) return kUnproven;
  return bound;
}

TriangleCuts::Box TriangleCuts::box_round(const Piece& piece, double reach) {
  Box box{piece[0], piece[0]};
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min({piece[0][i], piece[1][i], piece[2][i]}) - reach;
    box.upper[i] = std::max({piece[0][i], piece[1][i], piece[2][i]}) + reach;
  }
  return box;
}

void TriangleCuts::begin(const Piece& triangle, double limit) {
  triangle_ = triangle;
  box_ = box_round(triangle, 0);
  limit_ = limit;
  targets_.clear();
}

void TriangleCuts::add(const Piece& target) {
  const Box around = box_round(target, 1.001 * limit_);
  for (std::size_t i = 0; i < 3; ++i)
    if (around.lower[i] > box_.upper[i] || around.upper[i] < box_.lower[i]) return;
  if (targets_.size() == kMostTargets) return;
  Target t;
  t.around = around;
  t.origin = target[0];
  t.u = target[1] - target[0];
  t.v = target[2] - target[0];
  t.uu = dot(t.u, t.u);
  t.uv = dot(t.u, t.v);
  t.vv = dot(t.v, t.v);
  const Vec3d w = t.v - t.u;
  const double area2 = t.uu * t.vv - t.uv * t.uv;
  const bool has_inside = area2 > 1e-8 * t.uu * t.vv;
  const auto over = [](double x) { return x > 0 ? 1 / x : 0.0; };
  t.area2 = has_inside ? area2 : -1;
  t.over_uu = over(t.uu);
  t.over_vv = over(t.vv);
  t.over_ww = over(dot(w, w));
  t.over_area2 = has_inside ? 1 / area2 : 0;
  targets_.push_back(t);
}

/// Distances are those from points that lie in the targets, however these were rounded.
TriangleCuts::Corner TriangleCuts::corner_at(const Vec3d& at) const {
  Corner corner{at, {}};
  const double limit2 = limit_ * limit_;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const Target& t = targets_[i];
    if (!t.around.holds(at)) continue;
    const Vec3d q = at - t.origin;
    const double qu = dot(q, t.u);
    const double qv = dot(q, t.v);
    const double s = t.vv * qu - t.uv * qv;
    const double r = t.uu * qv - t.uv * qu;
    const auto to = [&](double b, double c) {
      const Vec3d d = q - t.u * b - t.v * c;
      return dot(d, d);
    };
    double distance2 = 0;
    if (s >= 0 && r >= 0 && s + r <= t.area2) {
      const double b = std::min(s * t.over_area2, 1.0);
      distance2 = to(b, std::min(r * t.over_area2, 1 - b));
    } else {
      const double on_u = std::clamp(qu * t.over_uu, 0.0, 1.0);
      const double on_v = std::clamp(qv * t.over_vv, 0.0, 1.0);
      const double on_w = std::clamp((qv - qu - t.uv + t.uu) * t.over_ww, 0.0, 1.0);
      distance2 = std::min({to(on_u, 0), to(0, on_v), to(1 - on_w, on_w)});
    }
    corner.near[i] = distance2 <= limit2;
  }
  return corner;
}

bool TriangleCuts::covers() {
  n_corners_ = 0;
  std::array<Corner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k] = corner_at(triangle_[k]);
    if (corners[k].near.none()) return false;
  }
  constexpr int kDepth = 12;
  return covers_part(corners[0], corners[1], corners[2], kDepth);
}

bool TriangleCuts::covers_part(const Corner& a, const Corner& b, const Corner& c, int depth) {
  if ((a.near & b.near & c.near).any()) return true;
  constexpr int kMostCorners = 128;
  if (depth == 0 || ++n_corners_ > kMostCorners) return false;
  // Between two that have none in common, if there are such; of these the farthest apart.
  const std::array<const Corner*, 3> corners{&a, &b, &c};
  std::size_t first = 0;
  double longest = -1;
  bool is_apart = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Corner& from = *corners[k];
    const Corner& to = *corners[(k + 1) % 3];
    const bool are_apart = (from.near & to.near).none();
    const Vec3d along = to.at - from.at;
    const double length2 = dot(along, along);
    if (is_apart > are_apart || (is_apart == are_apart && length2 <= longest)) continue;
    is_apart = are_apart;
    longest = length2;
    first = k;
  }
  const Corner& from = *corners[first];
  const Corner& to = *corners[(first + 1) % 3];
  const Corner& beside = *corners[(first + 2) % 3];
  const Corner middle = corner_at((from.at + to.at) * 0.5);
  return middle.near.any() && covers_part(from, middle, beside, depth - 1) &&
         covers_part(middle, to, beside, depth - 1);
}

}  // namespace lode::simplification
