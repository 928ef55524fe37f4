// Where a vertex would best go.
#include <algorithm>
#include <bit>

#include "lode/core/point_triangle.h"
#include "lode/mappers/collapse_block.h"

namespace lode::simplification {

BlockSimplifier::Choice BlockSimplifier::choose(std::uint32_t v, const Star& star) const {
  if (star.is_open) return choose_on_border(v, star);
  Choice best;
  best.cost = 1e30F;
  const Quadric& own = quadrics_[v];
  const Vec3f p = position(v);
  for (const Spoke& spoke : star.all()) {
    const std::uint32_t x = spoke.a;
    if (!may_collapse(v, x)) continue;
    Quadric q = own;
    q.add(quadrics_[x]);
    const Vec3f other = position(x);
    const float at_other = q.at(other);
    if (at_other < best.cost) best = {x, at_other, other};
    if ((flags_[x] & kBorderFlag) != 0) continue;
    const Vec3f middle = 0.5F * (p + other);
    const float at_middle = q.at(middle);
    if (at_middle < best.cost && may_lie_at(middle)) best = {x, at_middle, middle};
  }
  return refine(v, best);
}

/// Where on the interior the quadric is least.
BlockSimplifier::Choice BlockSimplifier::refine(std::uint32_t v, Choice choice) const {
  if (choice.other == kNone || (flags_[choice.other] & kBorderFlag) != 0) return choice;
  Quadric q = quadrics_[v];
  q.add(quadrics_[choice.other]);
  const Vec3f a = position(v);
  const Vec3f e = position(choice.other) - a;
  const Vec3f middle = a + 0.5F * e;
  const Vec3f least = minimum_near(q, middle);
  const Vec3f d = least - middle;
  if (dot(d, d) > dot(e, e)) return choice;
  const float cost = q.at(least);
  if (cost < choice.cost && may_lie_at(least)) return {choice.other, cost, least};
  return choice;
}

/// Into neighbours where they are, those of the least cost first.
bool BlockSimplifier::try_others(std::uint32_t v, const Star& star, const Choice& failed,
                                 const Sweep& sweep) {
  if (star.is_open || sweep.n_others == 0) return false;
  std::array<Choice, kMaxValence> others;
  std::size_t n = 0;
  for (const Spoke& spoke : star.all()) {
    if (!may_collapse(v, spoke.a)) continue;
    Quadric q = quadrics_[v];
    q.add(quadrics_[spoke.a]);
    const Vec3f at = position(spoke.a);
    if (spoke.a == failed.other && at == failed.position) continue;
    if (const float cost = q.at(at); cost <= sweep.threshold) others[n++] = {spoke.a, cost, at};
  }
  const auto end = others.begin() + static_cast<std::ptrdiff_t>(n);
  std::sort(others.begin(), end, [](const Choice& a, const Choice& b) { return a.cost < b.cost; });
  n = std::min<std::size_t>(n, sweep.n_others);
  return std::any_of(
      others.begin(), others.begin() + static_cast<std::ptrdiff_t>(n),
      [&](const Choice& choice) { return try_collapse(choice.other, v, star, choice.position); });
}

/// The edge between them.
bool BlockSimplifier::may_collapse(std::uint32_t v, std::uint32_t other) const {
  if ((flags_[other] & kLockedFlag) != 0) return false;
  if (!(limits_.longest2 < std::numeric_limits<float>::infinity())) return true;
  const Vec3f e = position(other) - position(v);
  return dot(e, e) <= limits_.longest2;
}

/// As it will be stored.
bool BlockSimplifier::may_lie_at(const Vec3f& position) const {
  const Vec3f p = centre_ + position;
  if (limits_.domain != nullptr && !limits_.domain->has({{p[0], p[1], p[2]}})) return false;
  if (!limits_.is_piece) return true;
  for (std::size_t i = 0; i < 3; ++i)
    if (!(limits_.lower[i] < p[i] && p[i] < limits_.upper[i])) return false;
  return true;
}

/// A vertex of the border goes into a neighbour on it, if the border keeps to all coordinate planes
/// that it runs in there.
BlockSimplifier::Choice BlockSimplifier::choose_on_border(std::uint32_t v, const Star& star) const {
  std::array<std::uint32_t, 2> ends{kNone, kNone};
  for (const Spoke& spoke : star.all()) {
    bool is_first = true;
    bool is_last = true;
    for (const Spoke& other : star.all()) {
      is_first = is_first && other.b != spoke.a;
      is_last = is_last && other.a != spoke.b;
    }
    if (is_first) ends[0] = spoke.a;
    if (is_last) ends[1] = spoke.b;
  }
  Choice best;
  best.cost = 1e30F;
  if (ends[0] == kNone || ends[1] == kNone || ends[0] == ends[1]) return best;
  const Vec3f p = mesh_.positions[vertex_ids_[v]];  // those of the border have not moved
  const Vec3f a = mesh_.positions[vertex_ids_[ends[0]]];
  const Vec3f b = mesh_.positions[vertex_ids_[ends[1]]];
  int n_planes = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool with_a = p[i] == a[i];
    const bool with_b = p[i] == b[i];
    if (with_a != with_b) return best;
    if (with_a) ++n_planes;
  }
  if (n_planes == 0) return best;
  if (limits_.band != nullptr) {  // at holes the border may turn in its plane
    const unsigned outer = limits_.band->border_planes(in_band_[v]) &
                           limits_.band->border_planes(in_band_[ends[0]]) &
                           limits_.band->border_planes(in_band_[ends[1]]);
    if (std::popcount(outer) < n_planes) return best;
  }
  const float aside = squared_distance_to_segment(p, a, b - a);
  for (const std::uint32_t x : ends) {
    if (!may_collapse(v, x)) continue;
    Quadric q = quadrics_[v];
    q.add(quadrics_[x]);
    const float cost = std::max(0.0F, q.at(position(x))) + aside * limits_.area;
    if (cost < best.cost) best = {x, cost, position(x)};
  }
  return best;
}

}  // namespace lode::simplification
