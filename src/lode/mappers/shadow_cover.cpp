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

std::size_t ShadowCover::Set::place(std::uint32_t number) const {
  std::size_t at = (number * 0x9E3779B1U) & (table_.size() - 1);
  while (table_[at] != kNone && table_[at] != number) at = (at + 1) & (table_.size() - 1);
  return at;
}

bool ShadowCover::Set::insert(std::uint32_t number) {
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
  met_.clear();
  high_.clear();
  shadows_.clear();
  rims_.clear();
  highest_ = 0;
  is_odd_ = is_blurred_ = false;
  is_placed_ = place(triangle);
  return bound_with(start);
}

double ShadowCover::bound_with(std::uint32_t start) {
  if (!is_placed_) return kUnproven;
  start_at(start);
  while (!pending_.empty()) {
    const Cast cast = pending_.back();
    pending_.pop_back();
    if (!cast.is_entered) go_across(cast, 0, 1);
    go_across(cast, 1, 2);
    go_across(cast, 2, 0);
  }
  if (!is_odd_ || is_blurred_ || has_rims()) return kUnproven;
  const double bound = highest_ + margin_;  // for what rounding may have lifted
  return bound * bound;
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
bool ShadowCover::is_low(const std::array<Shadow, 3>& corners) {
  double highest = 0;
  for (const Shadow& corner : corners) {
    if (!(std::abs(corner.x) + std::abs(corner.y) < 4 * kLargest * limit_)) return false;
    highest = std::max(highest, std::abs(corner.height));
  }
  if (highest > limit_) highest = height_inside(corners);
  if (!(highest <= limit_)) return false;
  highest_ = std::max(highest_, highest);
  return true;
}

/// The largest height of a triangle where its shadow is on the new one: what is left of it is cut
/// by the line of each edge.
double ShadowCover::height_inside(const std::array<Shadow, 3>& corners) const {
  constexpr std::size_t kMostCorners = 24;  // each cut could double them, by rounding
  std::array<Shadow, kMostCorners> left{corners[0], corners[1], corners[2]};
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

/// With the triangles round the vertex.
void ShadowCover::start_at(std::uint32_t vertex) {
  for (const std::uint32_t t : around_.of(vertex)) {
    if (!met_.insert(t)) continue;
    const auto& v = original_.triangles[t];
    const bool has_corners = v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
    if (!has_corners || !take({t, v, {shadow_of(v[0]), shadow_of(v[1]), shadow_of(v[2])}, false}))
      high_.insert(t);
  }
}

/// If it is not too high.
bool ShadowCover::take(const Cast& cast) {
  if (!is_low(cast.at)) return false;
  auto& shadow = shadows_.emplace_back();
  for (std::size_t k = 0; k < 3; ++k) shadow[k] = {cast.at[k].x, cast.at[k].y};
  const Holds holds = held_by(shadow, middle_);
  is_odd_ = is_odd_ != (holds != Holds::no);
  is_blurred_ = is_blurred_ || holds == Holds::blurred;
  pending_.push_back(cast);
  return true;
}

/// To the triangle that lies beyond an edge, if its shadow meets the new triangle.
void ShadowCover::go_across(const Cast& cast, std::size_t i, std::size_t j) {
  if (misses(cast.at[i], cast.at[j])) return;
  const std::uint32_t next = beyond(cast.triangle, cast.v[i], cast.v[j]);
  bool is_taken = next != kNone && !high_.contains(next);
  if (is_taken && met_.insert(next)) {
    std::uint32_t apex = kNone;
    for (const std::uint32_t x : original_.triangles[next])
      if (x != cast.v[i] && x != cast.v[j]) apex = x;
    is_taken =
        apex != kNone &&
        take({next, {cast.v[i], cast.v[j], apex}, {cast.at[i], cast.at[j], shadow_of(apex)}, true});
    if (!is_taken) high_.insert(next);
  }
  if (!is_taken) rims_.push_back({{{cast.at[i].x, cast.at[i].y}, {cast.at[j].x, cast.at[j].y}}});
}

/// The one other triangle with an edge; kNone at a border, and where there are more.
std::uint32_t ShadowCover::beyond(std::uint32_t triangle, std::uint32_t v, std::uint32_t w) const {
  std::uint32_t found = kNone;
  for (const std::uint32_t t : around_.of(v)) {
    const auto& corners = original_.triangles[t];
    if (t == triangle || (corners[0] != w && corners[1] != w && corners[2] != w)) continue;
    if (found != kNone) return kNone;
    found = t;
  }
  return found;
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

/// Whether a point lies in a shadow: on an edge that is not clear.
ShadowCover::Holds ShadowCover::held_by(const std::array<Point, 3>& shadow, const Point& p) const {
  for (std::size_t i = 0; i < 2; ++i) {
    const auto [low, high] = std::minmax({shadow[0][i], shadow[1][i], shadow[2][i]});
    if (p[i] < low - margin_ || p[i] > high + margin_) return Holds::no;
  }
  bool is_left = true;
  bool is_right = true;
  bool is_near_edge = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Point& a = shadow[k];
    const Point& b = shadow[(k + 1) % 3];
    const double dx = b[0] - a[0];
    const double dy = b[1] - a[1];
    const double side = dx * (p[1] - a[1]) - dy * (p[0] - a[0]);
    const double margin = margin_ * (std::abs(dx) + std::abs(dy));
    is_left = is_left && side >= -margin;
    is_right = is_right && side <= margin;
    is_near_edge = is_near_edge || std::abs(side) <= margin;
  }
  if (!is_left && !is_right) return Holds::no;
  return is_near_edge ? Holds::blurred : Holds::yes;
}

}  // namespace lode::simplification
