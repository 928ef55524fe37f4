#include "lode/mappers/shadow_cover.h"

#include <algorithm>
#include <cmath>

namespace lode::simplification {
/// Of a large one most would be emptied for nothing.
void ShadowCover::Set::clear() {
  if (n_ == 0) return;
  table_.assign(table_.size() > kLarge ? kLeast : table_.size(), kNone);
  n_ = 0;
}

bool ShadowCover::Set::insert(std::uint32_t number) {
  const auto place = [this](std::uint32_t x) {
    std::size_t at = (x * 0x9E3779B1U) & (table_.size() - 1);
    while (table_[at] != kNone && table_[at] != x) at = (at + 1) & (table_.size() - 1);
    return at;
  };
  const std::size_t at = place(number);
  if (table_[at] == number) return false;
  table_[at] = number;
  if (2 * ++n_ <= table_.size()) return true;
  std::vector<std::uint32_t> old(2 * table_.size(), kNone);
  std::swap(old, table_);
  for (const std::uint32_t x : old)
    if (x != kNone) table_[place(x)] = x;
  return true;
}

ShadowCover::ShadowCover(const Surface& original, const Surroundings& around, double limit)
    : original_(original), around_(around), limit_(limit), margin_(kMargin * limit) {}

double ShadowCover::bound(const Piece& triangle, std::uint32_t start) {
  if (!place(triangle)) return kUnproven;
  met_.clear();
  highest_ = 0;
  is_odd_ = false;
  pending_.clear();
  if (!start_at(start)) return kUnproven;
  while (!pending_.empty()) {
    const Entry entry = pending_.back();
    pending_.pop_back();
    if (!take(entry)) return kUnproven;
  }
  const double bound = highest_ + margin_;  // for what rounding may have lifted
  return is_odd_ ? bound * bound : kUnproven;
}

/// The plane, and the triangle in it; whether it has one that rounding does not blur.
bool ShadowCover::place(const Piece& triangle) {
  const Vec3d b = triangle[1] - triangle[0];
  const Vec3d c = triangle[2] - triangle[0];
  const double longest2 = std::max({dot(b, b), dot(c, c), dot(c - b, c - b)});
  const Vec3d n = cross(b, c);
  // The least height is the length of n by the longest edge.
  constexpr double kThinnest = 1e-4;
  if (!(dot(n, n) > kThinnest * kThinnest * longest2 * longest2)) return false;
  if (!(longest2 < kLargest * kLargest * limit_ * limit_)) return false;
  origin_ = triangle[0];
  right_ = normalized(b);
  up_ = normalized(n);
  forward_ = cross(up_, right_);
  corners_ = {{{0, 0}, {dot(b, right_), 0}, {dot(c, right_), dot(c, forward_)}}};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& from = corners_[k];
    const auto& to = corners_[(k + 1) % 3];
    const double dx = to[0] - from[0];
    const double dy = to[1] - from[1];
    const double length = std::sqrt(dx * dx + dy * dy);
    inward_[k] = {-dy / length, dx / length};
  }
  // Not where lines through lattice points meet.
  constexpr std::array<double, 3> kWeights{0.4142135, 0.3090169, 0.2767696};
  middle_ = {0, 0};
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 2; ++i) middle_[i] += kWeights[k] * corners_[k][i];
  return true;
}

ShadowCover::Shadow ShadowCover::shadow_of(std::uint32_t vertex) const {
  const Vec3d d = widened(original_.positions[vertex]) - origin_;
  Shadow shadow{dot(d, right_), dot(d, forward_), dot(d, up_), {}};
  for (std::size_t k = 0; k < 3; ++k)
    shadow.inside[k] =
        (shadow.x - corners_[k][0]) * inward_[k][0] + (shadow.y - corners_[k][1]) * inward_[k][1];
  return shadow;
}

/// Whether what of a triangle is over the new one is within the limit of the plane.
bool ShadowCover::is_low(const std::array<const Shadow*, 3>& corners) {
  double highest = 0;
  for (const Shadow* corner : corners) {
    if (!(std::abs(corner->x) + std::abs(corner->y) < 4 * kLargest * limit_)) return false;
    highest = std::max(highest, std::abs(corner->height));
  }
  if (highest > limit_) highest = height_inside(corners);
  highest_ = std::max(highest_, highest);
  return highest <= limit_;
}

/// The largest height of a triangle where its shadow is on the new one: what is left of it is cut
/// by the line of each edge.
double ShadowCover::height_inside(const std::array<const Shadow*, 3>& corners) const {
  constexpr std::size_t kMostCorners = 24;  // each cut could double them, by rounding
  std::array<Shadow, kMostCorners> left{*corners[0], *corners[1], *corners[2]};
  std::size_t n = 3;
  for (std::size_t k = 0; k < 3; ++k) {
    std::array<Shadow, kMostCorners> cut;
    std::size_t n_cut = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Shadow& a = left[i];
      const Shadow& b = left[(i + 1) % n];
      const double from = a.inside[k] + margin_;
      const double to = b.inside[k] + margin_;
      if (from >= 0) cut[n_cut++] = a;
      if ((from >= 0) == (to >= 0)) continue;
      const double s = from / (from - to);
      Shadow& c = cut[n_cut++];
      c.height = a.height + s * (b.height - a.height);
      for (std::size_t j = 0; j < 3; ++j)
        c.inside[j] = a.inside[j] + s * (b.inside[j] - a.inside[j]);
    }
    left = cut;
    n = n_cut;
  }
  double highest = 0;
  for (std::size_t i = 0; i < n; ++i) highest = std::max(highest, std::abs(left[i].height));
  return highest;
}

/// With one triangle round the vertex, across two of its edges and the third.
bool ShadowCover::start_at(std::uint32_t vertex) {
  const auto around = around_.of(vertex);
  if (around.empty()) return false;
  const std::uint32_t t = around.front();
  const auto& corners = original_.triangles[t];
  const Entry entry{t, corners[0], corners[1], shadow_of(corners[0]), shadow_of(corners[1])};
  met_.insert(t);
  return take(entry) && go_across(t, entry.v, entry.w, entry.at_v, entry.at_w);
}

/// Counts the triangle, and goes on across its two other edges.
bool ShadowCover::take(const Entry& entry) {
  std::uint32_t apex = kNone;
  for (const std::uint32_t x : original_.triangles[entry.triangle])
    if (x != entry.v && x != entry.w) apex = x;
  if (apex == kNone) return false;
  const Shadow at_apex = shadow_of(apex);
  const std::array<const Shadow*, 3> corners{&entry.at_v, &entry.at_w, &at_apex};
  if (!is_low(corners) || !count(corners)) return false;
  return go_across(entry.triangle, entry.v, apex, entry.at_v, at_apex) &&
         go_across(entry.triangle, entry.w, apex, entry.at_w, at_apex);
}

/// To the one triangle that lies beyond an edge, if its shadow meets the new triangle; false at a
/// border, and where there are more.
bool ShadowCover::go_across(std::uint32_t triangle, std::uint32_t v, std::uint32_t w,
                            const Shadow& at_v, const Shadow& at_w) {
  if (misses(at_v, at_w)) return true;
  std::uint32_t beyond = kNone;
  for (const std::uint32_t t : around_.of(v)) {
    const auto& corners = original_.triangles[t];
    if (t == triangle || (corners[0] != w && corners[1] != w && corners[2] != w)) continue;
    if (beyond != kNone) return false;
    beyond = t;
  }
  if (beyond == kNone) return false;
  if (met_.insert(beyond)) pending_.push_back({beyond, v, w, at_v, at_w});
  return true;
}

/// Whether the edge's shadow is clearly apart from the new triangle: a line between two convex sets
/// that is parallel to an edge of one of them.
bool ShadowCover::misses(const Shadow& a, const Shadow& b) const {
  for (std::size_t k = 0; k < 3; ++k)
    if (a.inside[k] < -margin_ && b.inside[k] < -margin_) return true;
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double margin = margin_ * (std::abs(dx) + std::abs(dy));
  double least = kUnproven;
  double largest = -kUnproven;
  for (const auto& corner : corners_) {
    const double side = dx * (corner[1] - a.y) - dy * (corner[0] - a.x);
    least = std::min(least, side);
    largest = std::max(largest, side);
  }
  return least > margin || largest < -margin;
}

/// Whether it is clear if the shadow holds the point inside; counts it if it does.
bool ShadowCover::count(const std::array<const Shadow*, 3>& corners) {
  bool is_left = true;
  bool is_right = true;
  bool is_blurred = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Shadow& a = *corners[k];
    const Shadow& b = *corners[(k + 1) % 3];
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double side = dx * (middle_[1] - a.y) - dy * (middle_[0] - a.x);
    const double margin = margin_ * (std::abs(dx) + std::abs(dy));
    is_left = is_left && side >= -margin;
    is_right = is_right && side <= margin;
    is_blurred = is_blurred || std::abs(side) <= margin;
  }
  if (!is_left && !is_right) return true;  // clearly outside
  is_odd_ = !is_odd_;
  return !is_blurred;
}

}  // namespace lode::simplification
