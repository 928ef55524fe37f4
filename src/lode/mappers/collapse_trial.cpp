// Whether a vertex may go where it would.
#include <algorithm>
#include <cmath>

#include "lode/core/point_triangle.h"
#include "lode/mappers/collapse_block.h"

namespace lode::simplification {
namespace {

/// Of area and longest edge: a sliver below it has no direction that means anything.
constexpr float kSliver = 1e-4F;
/// Squared, the shortest edge by the longest. A needle is to lose its short edge, whatever becomes
/// of its height until then: where the isovalue is a sample's, its vertex has dozens of them.
constexpr float kNeedle = 1e-4F;

float shortest2(const Vec3f& u, const Vec3f& v) {
  const Vec3f e = v - u;
  return std::min({dot(u, u), dot(v, v), dot(e, e)});
}

}  // namespace

bool BlockSimplifier::try_collapse(std::uint32_t kept, std::uint32_t removed,
                                   const Star& star_of_removed, const Vec3f& position) {
  if (!gather(kept, other_star_)) return false;
  if (!is_link_simple(kept, other_star_, star_of_removed)) return false;
  if (!make_triangles(kept, removed, other_star_, star_of_removed, position)) return false;
  join_triangles();
  if (!folds_little()) return false;
  if (limits_.band != nullptr && !keeps_to_band(kept, removed, star_of_removed, position))
    return false;
  moves_.clear();
  if (std::isfinite(limits_.distance) && !attach_points(position)) return false;
  apply(kept, removed, position);
  return true;
}

/// The link condition (Dey, Edelsbrunner, Guha, Nekhayev 1999): the collapse is a homeomorphism.
bool BlockSimplifier::is_link_simple(std::uint32_t kept, const Star& of_kept,
                                     const Star& of_removed) {
  std::uint32_t n_dead = 0;
  for (const Spoke& spoke : of_removed.all())
    if (spoke.a == kept || spoke.b == kept) ++n_dead;
  if (n_dead == 2 && of_kept.is_open && of_removed.is_open) return false;
  if (n_dead == 1 && of_kept.size == 1 && of_removed.size == 1) return false;
  if (of_kept.size == 3 && of_removed.size == 3 && !of_kept.is_open && !of_removed.is_open)
    return false;  // a tetrahedron, or a pyramid's top
  // Neighbours of one that are neighbours of the other: the ends of spokes, each once.
  marks_.forget();
  for (const Spoke& spoke : of_kept.all()) {
    marks_.set(spoke.a, 0);
    marks_.set(spoke.b, 0);
  }
  std::uint32_t n_common = 0;
  for (const Spoke& spoke : of_removed.all()) {
    if (spoke.a != kept && marks_.of(spoke.a) != kNone) ++n_common;
    if (!of_removed.is_open) continue;
    bool is_last = true;
    for (const Spoke& other : of_removed.all()) is_last = is_last && other.a != spoke.b;
    if (is_last && spoke.b != kept && marks_.of(spoke.b) != kNone) ++n_common;
  }
  return n_common == n_dead;
}

bool BlockSimplifier::make_triangles(std::uint32_t kept, std::uint32_t removed, const Star& of_kept,
                                     const Star& of_removed, const Vec3f& position) {
  n_new_ = 0;
  dead_ = {kNone, kNone};
  for (const Spoke& spoke : of_removed.all())
    if (spoke.a == kept || spoke.b == kept) dead_[dead_[0] == kNone ? 0 : 1] = spoke.triangle;
  const auto add = [&](const Star& star, std::uint32_t gone, std::uint32_t old) {
    for (const Spoke& spoke : star.all()) {
      if (spoke.a == gone || spoke.b == gone) continue;
      NewTriangle& t = new_triangles_[n_new_++];
      t.triangle = spoke.triangle;
      t.a = spoke.a;
      t.b = spoke.b;
      t.u = this->position(spoke.a) - position;
      t.v = this->position(spoke.b) - position;
      if (!keeps_shape(t, old)) return false;
      t.uu = dot(t.u, t.u);
      t.uv = dot(t.u, t.v);
      t.vv = dot(t.v, t.v);
      t.area2 = t.uu * t.vv - t.uv * t.uv;
    }
    return true;
  };
  return add(of_kept, removed, kept) && add(of_removed, kept, removed) && n_new_ <= kMaxValence;
}

/// The triangle does not turn over, nor become a sliver. A sliver's own direction says nothing, and
/// a needle may become a thinner one.
bool BlockSimplifier::keeps_shape(const NewTriangle& t, std::uint32_t old) const {
  const auto longest = [](const Vec3f& u, const Vec3f& v) {
    const Vec3f e = v - u;
    return std::max({dot(u, u), dot(v, v), dot(e, e)});
  };
  const Vec3f o = position(old);
  const Vec3f u = position(t.a) - o;
  const Vec3f v = position(t.b) - o;
  const Vec3f n = cross(t.u, t.v);
  const Vec3f before = cross(u, v);
  const float nn = dot(n, n);
  const float area = dot(before, before);
  const float length2 = longest(t.u, t.v);
  const float length_before2 = longest(u, v);
  const float shape = nn / (length2 * length2);
  const float shape_before = area / (length_before2 * length_before2);
  const bool is_needle =
      nn > 0 && shape_before < kSliver && shortest2(t.u, t.v) < kNeedle * length2;
  if (!(shape > least_shape_) && !(shape > shape_before) && !is_needle) return false;
  if (shape_before < 10 * least_shape_) return true;
  const float along = dot(n, before);
  return along > 0 && along * along > 0.04F * nn * area;
}

void BlockSimplifier::join_triangles() {
  marks_.forget();
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    marks_.set(new_triangles_[i].a, i);
    new_triangles_[i].across_a = kNone;
  }
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    const std::uint32_t next = marks_.of(new_triangles_[i].b);
    new_triangles_[i].across_b = next;
    if (next != kNone) new_triangles_[next].across_a = i;
  }
}

bool BlockSimplifier::folds_little() const {
  const auto is_sliver = [](const NewTriangle& t, float area) {
    const float longest2 = std::max(t.uu, t.vv);
    return area < kSliver * longest2 * longest2;
  };
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    const NewTriangle& t = new_triangles_[i];
    if (t.across_b == kNone) continue;
    const NewTriangle& s = new_triangles_[t.across_b];
    const Vec3f m = cross(t.u, t.v);
    const Vec3f n = cross(s.u, s.v);
    const float along = dot(m, n);
    const float mm = dot(m, m);
    const float nn = dot(n, n);
    if (along < 0 && along * along > 0.8F * mm * nn && !is_sliver(t, mm) && !is_sliver(s, nn))
      return false;
  }
  return true;
}

bool BlockSimplifier::attach_points(const Vec3f& position) {
  nearest_point_ = 1e30F;
  for (const std::uint32_t t : dead_) {
    if (t == kNone) continue;
    for (std::uint32_t p = triangles_[t].points; p != kNone; p = next_point_[p])
      if (!attach_point(p, position, 0)) return false;
  }
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    const std::uint32_t t = new_triangles_[i].triangle;
    for (std::uint32_t p = triangles_[t].points; p != kNone; p = next_point_[p])
      if (!attach_point(p, position, i)) return false;
  }
  // Between original vertices the surface may be nearer than these.
  return nearest_point_ <= limits_.distance * limits_.distance + limits_.area;
}

/// Walks round the star to a triangle close to the point.
bool BlockSimplifier::attach_point(std::uint32_t point, const Vec3f& position,
                                   std::uint32_t start) {
  const Vec3f q = points_[point] - position;
  // Across a sliver the distance stays what it is, but for rounding.
  constexpr float kFarther = 1.0001F;
  const float limit = limits_.distance * limits_.distance;
  const float qq = dot(q, q);
  nearest_point_ = std::min(nearest_point_, qq);
  std::uint32_t best = start;
  float least = 1e30F;
  std::uint32_t i = start;
  for (std::uint32_t step = 0; step <= n_new_; ++step) {
    const NewTriangle& t = new_triangles_[i];
    const float qu = dot(q, t.u);
    const float qv = dot(q, t.v);
    const float s = t.vv * qu - t.uv * qv;
    const float r = t.uu * qv - t.uv * qu;
    std::uint32_t next = kNone;
    float here = 0;
    if (r < 0 || s < 0) {
      // Beyond a spoke, the one that it is farther beyond.
      const bool is_beyond_a = r * t.vv < s * t.uu;
      const float along = is_beyond_a ? qu / t.uu : qv / t.vv;
      const Vec3f d = q - (is_beyond_a ? t.u : t.v) * std::clamp(along, 0.0F, 1.0F);
      here = dot(d, d);
      next = is_beyond_a ? t.across_a : t.across_b;
    } else if (s + r <= t.area2) {
      here = qq - (s * qu + r * qv) / t.area2;
    } else {
      here = squared_distance_to_segment(q, t.u, t.v - t.u);
    }
    if (here < least) {
      least = here;
      best = i;
    } else if (step > 0 && here > kFarther * least) {
      break;
    }
    if (next == kNone) break;
    i = next;
  }
  if (least > limit) return false;
  moves_.push_back({point, best});
  return true;
}

}  // namespace lode::simplification
