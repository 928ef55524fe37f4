#include "lode/models/tetra_mt/midpoint/edge_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "lode/core/expects.h"
#include "lode/models/tetra_mt/patch_deviation.h"
#include "lode/models/tetra_mt/star.h"

namespace lode::tetra_mt::midpoint {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::infinity();

/// A point seen along a direction.
struct Seen {
  double x;
  double y;
  double height;
};
using SeenTriangle = std::array<Seen, 3>;
using SeenEdge = std::array<Seen, 2>;

double turn(const Seen& at, const Seen& a, const Seen& b) {
  return (a.x - at.x) * (b.y - at.y) - (a.y - at.y) * (b.x - at.x);
}

Vec3d between(const Seen& from, const Seen& to) {
  return {{to.x - from.x, to.y - from.y, to.height - from.height}};
}

bool turns_left(const Seen& at, const Seen& a, const Seen& b) {
  return turn(at, a, b) > kLeastSeen * length(between(at, a)) * length(between(at, b));
}

/// Sees points along the mean normal of triangles.
class View {
 public:
  explicit View(const Vec3d& normals) {
    const double size = length(normals);
    if (!(size > 0)) return;
    normal_ = normals * (1 / size);
    const bool is_along_x = std::abs(normal_[0]) > 0.7;
    const Vec3d axis{{is_along_x ? 0.0 : 1.0, is_along_x ? 1.0 : 0.0, 0.0}};
    right_ = cross(axis, normal_);
    right_ = right_ * (1 / length(right_));
    up_ = cross(normal_, right_);
    is_known_ = true;
  }
  [[nodiscard]] bool is_known() const { return is_known_; }
  [[nodiscard]] Seen operator()(const Vec3d& p) const {
    return {dot(right_, p), dot(up_, p), dot(normal_, p)};
  }

 private:
  Vec3d normal_;
  Vec3d right_;
  Vec3d up_;
  bool is_known_ = false;
};

/// From the triangle that a point is in, of those that cover it.
double height_over(const Seen& p, std::span<const SeenTriangle> triangles) {
  double height = kUnknown;
  double most_inside = -kUnknown;
  for (const auto& [a, b, c] : triangles) {
    const double whole = turn(a, b, c);
    const std::array<double, 3> weights{turn(p, b, c) / whole, turn(p, c, a) / whole,
                                        turn(p, a, b) / whole};
    const double inside = std::ranges::min(weights);
    if (!(inside > most_inside)) continue;
    most_inside = inside;
    height = std::abs(p.height -
                      (weights[0] * a.height + weights[1] * b.height + weights[2] * c.height));
  }
  return height;
}

/// 0 where edges do not cross.
double height_at_crossing(const SeenEdge& one, const SeenEdge& other) {
  const auto& [a, b] = one;
  const auto& [c, d] = other;
  const double turns = (b.x - a.x) * (d.y - c.y) - (b.y - a.y) * (d.x - c.x);
  const double s = ((c.x - a.x) * (d.y - c.y) - (c.y - a.y) * (d.x - c.x)) / turns;
  const double t = ((c.x - a.x) * (b.y - a.y) - (c.y - a.y) * (b.x - a.x)) / turns;
  if (!(s >= 0 && s <= 1 && t >= 0 && t <= 1)) return 0;
  return std::abs(a.height + s * (b.height - a.height) - c.height - t * (d.height - c.height));
}

/// Whether triangles round the first of their corners turn left, once in all.
bool is_fan(std::span<const SeenTriangle> fan) {
  const Seen& at = fan[0][0];
  const Seen& begin = fan[0][1];
  for (std::size_t i = 0; i < fan.size(); ++i) {
    if (!turns_left(at, fan[i][1], fan[i][2])) return false;
    const bool is_last = i + 1 == fan.size();
    if (!is_last && turn(at, begin, fan[i][1]) < 0 && turn(at, begin, fan[i][2]) >= 0) return false;
  }
  return true;
}

/// As many as there are round the two ends of an edge, without memory of their own elsewhere.
template <typename T>
class List {
 public:
  void push_back(const T& one) { all_[n_++] = one; }
  [[nodiscard]] std::size_t size() const { return n_; }
  [[nodiscard]] const T& back() const { return all_[n_ - 1]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return all_[i]; }
  [[nodiscard]] const T* begin() const { return all_.data(); }
  [[nodiscard]] const T* end() const { return all_.data() + n_; }

 private:
  std::array<T, std::size_t{2} * Star::kMaxLink> all_;
  std::size_t n_ = 0;
};

/// Of the old triangles, those at the edge first.
template <typename Visit>
void visit_old(const EdgePatch& patch, const Visit& visit) {
  visit(patch.first, patch.second, patch.first_ring.front());
  visit(patch.first, patch.first_ring.back(), patch.second);
  for (std::size_t i = 0; i + 1 < patch.first_ring.size(); ++i)
    visit(patch.first, patch.first_ring[i], patch.first_ring[i + 1]);
  for (std::size_t i = 0; i + 1 < patch.second_ring.size(); ++i)
    visit(patch.second, patch.second_ring[i], patch.second_ring[i + 1]);
}

}  // namespace

double edge_patch_deviation(const EdgePatch& patch, double limit) {
  LODE_EXPECTS(patch.first_ring.size() + patch.second_ring.size() <
               std::size_t{2} * Star::kMaxLink);
  Vec3d normals;
  visit_old(patch, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    normals = normals + cross(b - a, c - a);
  });
  const View view(normals);
  if (!view.is_known()) return kUnknown;
  List<SeenTriangle> before;
  bool is_seen = true;
  visit_old(patch, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    before.push_back({view(a), view(b), view(c)});
    is_seen = is_seen && turns_left(before.back()[0], before.back()[1], before.back()[2]);
  });
  if (!is_seen) return kUnknown;
  const Seen first = view(patch.first);
  const Seen second = view(patch.second);
  const Seen middle = view(patch.middle);
  List<SeenEdge> old_edges;
  old_edges.push_back({first, second});
  List<Seen> outline;
  for (const Vec3d& p : patch.first_ring) {
    outline.push_back(view(p));
    old_edges.push_back({first, outline.back()});
  }
  for (std::size_t i = 0; i < patch.second_ring.size(); ++i) {
    const Seen at = view(patch.second_ring[i]);
    old_edges.push_back({second, at});
    // Its ends are the first one's.
    if (i > 0 && i + 1 < patch.second_ring.size()) outline.push_back(at);
  }
  List<SeenTriangle> after;
  for (std::size_t i = 0; i < outline.size(); ++i)
    after.push_back({middle, outline[i], outline[(i + 1) % outline.size()]});
  if (!is_fan(after)) return kUnknown;
  double largest = std::max(
      {height_over(first, after), height_over(second, after), height_over(middle, before)});
  for (const SeenEdge& edge : old_edges)
    for (const Seen& end : outline) {
      if (!(largest <= limit)) return kUnknown;
      largest = std::max(largest, height_at_crossing(edge, {middle, end}));
    }
  return largest <= limit ? largest : kUnknown;
}

}  // namespace lode::tetra_mt::midpoint
