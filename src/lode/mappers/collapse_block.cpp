#include "lode/mappers/collapse_block.h"

#include <algorithm>
#include <cmath>

#include "lode/mappers/point_triangle.h"

namespace lode::simplification {
namespace {

constexpr std::uint8_t kLockedFlag = 1;
constexpr std::uint8_t kBorderFlag = 2;
constexpr std::uint8_t kMovedFlag = 4;
constexpr float kTried = 2e30F;  ///< A cost above all thresholds.

}  // namespace

std::uint32_t BlockSimplifier::run(const Block& block, const Progress& progress) {
  const auto is_open = [&](std::uint32_t t) {
    const auto& v = mesh_.triangles[t].v;
    return (block.is_open[v[0]] | block.is_open[v[1]] | block.is_open[v[2]]) != 0;
  };
  if (!block.is_open.empty() && std::ranges::none_of(block.triangles, is_open)) return 0;
  next_collapse_ = block.first_collapse;
  load(block);
  prepare(block);
  const float unit = limits_.area * limits_.distance * limits_.distance;
  for (const float threshold : {0.001F, 0.01F, 0.1F, 1.0F, 1e9F}) {
    if (progress.is_cancelled()) break;
    sweep(threshold * unit);
  }
  store();
  return next_collapse_ - block.first_collapse;
}

void BlockSimplifier::load(const Block& block) {
  vertices_.clear();
  vertex_ids_.clear();
  last_.clear();
  flags_.clear();
  triangles_.clear();
  triangle_ids_.assign(block.triangles.begin(), block.triangles.end());
  points_.clear();
  point_ids_.clear();
  next_point_.clear();
  next_corner_.assign(4 * block.triangles.size(), kNone);
  centre_ = mesh_.positions[mesh_.triangles[block.triangles.front()].v[0]];
  for (const std::uint32_t t : block.triangles) load_triangle(block, t);
}

void BlockSimplifier::load_triangle(const Block& block, std::uint32_t global) {
  const auto t = static_cast<std::uint32_t>(triangles_.size());
  const WorkTriangle& from = mesh_.triangles[global];
  WorkTriangle to{.v = {}, .points = kNone};
  const auto add_point = [&](std::uint32_t id, const Vec3f& at) {
    next_point_.push_back(to.points);
    to.points = static_cast<std::uint32_t>(points_.size());
    points_.push_back(at);
    point_ids_.push_back(id);
  };
  for (std::uint32_t k = 0; k < 3; ++k) {
    const std::uint32_t v = from.v[k];
    std::uint32_t& local = local_[v];
    if (local == kNone) {
      local = static_cast<std::uint32_t>(vertices_.size());
      const Vec3f at = mesh_.positions[v] - centre_;
      vertices_.push_back({at, kNone});
      vertex_ids_.push_back(v);
      last_.push_back(mesh_.last[v]);
      flags_.push_back(is_locked_[v] != 0 ? kLockedFlag : 0);
      if (block.attaches) add_point(v, at);
    }
    to.v[k] = local;
    next_corner_[4 * t + k] = vertices_[local].corners;
    vertices_[local].corners = 4 * t + k;
  }
  if (!block.attaches) {
    for (std::uint32_t p = from.points; p != kNone; p = mesh_.next_point[p])
      add_point(p, original_[p] - centre_);
  }
  triangles_.push_back(to);
}

void BlockSimplifier::prepare(const Block& block) {
  quadrics_.assign(vertices_.size(), {});
  costs_.assign(vertices_.size(), -1.0F);
  if (!block.is_open.empty())
    for (std::uint32_t v = 0; v < vertices_.size(); ++v)
      if (block.is_open[vertex_ids_[v]] == 0) costs_[v] = kTried;
  for (const WorkTriangle& t : triangles_) {
    const Vec3f a = position(t.v[0]);
    const Vec3f n = cross(position(t.v[1]) - a, position(t.v[2]) - a);
    const float area2 = length(n);
    if (!(area2 > 0)) continue;
    const Quadric q = plane_quadric((1 / area2) * n, a, area2 / 6);
    for (const std::uint32_t v : t.v) quadrics_[v].add(q);
  }
  Star star;
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    if ((flags_[v] & kLockedFlag) != 0) continue;
    if (!gather(v, star)) {
      flags_[v] |= kLockedFlag;
    } else if (star.is_open) {
      flags_[v] |= limits_.is_piece ? kLockedFlag : kBorderFlag;
    }
  }
}

bool BlockSimplifier::gather(std::uint32_t v, Star& star) const {
  star.size = 0;
  std::uint32_t ends = 0;
  for (std::uint32_t c = vertices_[v].corners; c != kNone; c = next_corner_[c]) {
    if (star.size == kMaxValence) return false;
    const std::uint32_t t = c >> 2;
    const WorkTriangle& triangle = triangles_[t];
    const std::uint32_t k = c & 3;
    const std::uint32_t a = triangle.v[k == 2 ? 0 : k + 1];
    const std::uint32_t b = triangle.v[k == 0 ? 2 : k - 1];
    ends ^= a ^ b;
    star.spokes[star.size++] = {t, a, b};
  }
  star.is_open = ends != 0;  // of a closed fan each end comes twice
  return true;
}

BlockSimplifier::Choice BlockSimplifier::choose(std::uint32_t v, const Star& star) const {
  if (star.is_open) return choose_on_border(v, star);
  Choice best;
  best.cost = 1e30F;
  const Quadric& own = quadrics_[v];
  const Vec3f p = position(v);
  for (const Spoke& spoke : star.all()) {
    const std::uint32_t x = spoke.a;
    if ((flags_[x] & kLockedFlag) != 0) continue;
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

/// As it will be stored.
bool BlockSimplifier::may_lie_at(const Vec3f& position) const {
  if (!limits_.is_piece) return true;
  const Vec3f p = centre_ + position;
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
  bool is_in_plane = false;
  for (std::size_t i = 0; i < 3; ++i) {
    const bool with_a = p[i] == a[i];
    const bool with_b = p[i] == b[i];
    if (with_a != with_b) return best;
    is_in_plane = is_in_plane || with_a;
  }
  if (!is_in_plane) return best;
  const float aside = squared_distance_to_segment(p, a, b - a);
  for (const std::uint32_t x : ends) {
    if ((flags_[x] & kLockedFlag) != 0) continue;
    Quadric q = quadrics_[v];
    q.add(quadrics_[x]);
    const float cost = std::max(0.0F, q.at(position(x))) + aside * limits_.area;
    if (cost < best.cost) best = {x, cost, position(x)};
  }
  return best;
}

void BlockSimplifier::sweep(float threshold) {
  Star star;
  const auto n = static_cast<std::uint32_t>(vertices_.size());
  for (std::uint32_t v = 0; v < n; ++v) {
    if (vertices_[v].corners == kNone || (flags_[v] & kLockedFlag) != 0) continue;
    if (costs_[v] > threshold) continue;
    if (!gather(v, star)) continue;
    const Choice choice = choose(v, star);
    costs_[v] = std::max(choice.cost, 0.0F);
    if (choice.other == kNone || choice.cost > threshold) continue;
    if (!try_collapse(choice.other, v, star, choice.position)) costs_[v] = kTried;
  }
}

bool BlockSimplifier::try_collapse(std::uint32_t kept, std::uint32_t removed,
                                   const Star& star_of_removed, const Vec3f& position) {
  if (!gather(kept, other_star_)) return false;
  if (!is_link_simple(kept, other_star_, star_of_removed)) return false;
  if (!make_triangles(kept, removed, other_star_, star_of_removed, position)) return false;
  join_triangles();
  if (!folds_little()) return false;
  moves_.clear();
  if (!attach_points(position)) return false;
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
  const auto has_neighbour = [](const Star& star, std::uint32_t x) {
    for (const Spoke& spoke : star.all())
      if (spoke.a == x || spoke.b == x) return true;
    return false;
  };
  std::uint32_t n_common = 0;
  for (const Spoke& spoke : of_removed.all()) {
    if (spoke.a != kept && has_neighbour(of_kept, spoke.a)) ++n_common;
    if (!of_removed.is_open) continue;
    bool is_last = true;
    for (const Spoke& other : of_removed.all()) is_last = is_last && other.a != spoke.b;
    if (is_last && spoke.b != kept && has_neighbour(of_kept, spoke.b)) ++n_common;
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

/// The triangle does not turn over, nor become a sliver. A sliver's own direction says nothing.
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
  constexpr float kSliver = 1e-3F;
  const float shape = nn / (length2 * length2);
  const float shape_before = area / (length_before2 * length_before2);
  if (!(shape > kSliver) && !(shape > shape_before)) return false;
  if (shape_before < 10 * kSliver) return true;
  const float along = dot(n, before);
  return along > 0 && along * along > 0.04F * nn * area;
}

void BlockSimplifier::join_triangles() {
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    NewTriangle& t = new_triangles_[i];
    t.across_b = kNone;
    for (std::uint32_t j = 0; j < n_new_; ++j)
      if (new_triangles_[j].a == t.b) t.across_b = j;
    t.across_a = kNone;
    for (std::uint32_t j = 0; j < n_new_; ++j)
      if (new_triangles_[j].b == t.a) t.across_a = j;
  }
}

bool BlockSimplifier::folds_little() const {
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    const NewTriangle& t = new_triangles_[i];
    if (t.across_b == kNone) continue;
    const NewTriangle& s = new_triangles_[t.across_b];
    const Vec3f m = cross(t.u, t.v);
    const Vec3f n = cross(s.u, s.v);
    const float along = dot(m, n);
    if (along < 0 && along * along > 0.5F * dot(m, m) * dot(n, n)) return false;
  }
  return true;
}

bool BlockSimplifier::attach_points(const Vec3f& position) {
  nearest_point_ = 1e30F;
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    const std::uint32_t t = new_triangles_[i].triangle;
    for (std::uint32_t p = triangles_[t].points; p != kNone; p = next_point_[p])
      if (!attach_point(p, position, i)) return false;
  }
  for (const std::uint32_t t : dead_) {
    if (t == kNone) continue;
    for (std::uint32_t p = triangles_[t].points; p != kNone; p = next_point_[p])
      if (!attach_point(p, position, 0)) return false;
  }
  // Between original vertices the surface may be nearer than these.
  return nearest_point_ <= limits_.distance * limits_.distance + limits_.area;
}

/// Walks round the star to a triangle close to the point.
bool BlockSimplifier::attach_point(std::uint32_t point, const Vec3f& position,
                                   std::uint32_t start) {
  const Vec3f q = points_[point] - position;
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
    } else if (step > 0) {
      break;
    }
    if (next == kNone) break;
    i = next;
  }
  if (least > limit) return false;
  moves_.push_back({point, best});
  return true;
}

void BlockSimplifier::apply(std::uint32_t kept, std::uint32_t removed, const Vec3f& position) {
  const auto global = [&](std::uint32_t t) { return t == kNone ? kNone : triangle_ids_[t]; };
  mesh_.collapses[next_collapse_] = {
      .kept = vertex_ids_[kept],
      .removed = vertex_ids_[removed],
      .dead = {global(dead_[0]), global(dead_[1])},
      .kept_position = ((flags_[kept] & kMovedFlag) != 0 ? centre_ + this->position(kept)
                                                         : mesh_.positions[vertex_ids_[kept]])
                           .v,
      .last_kept = last_[kept],
      .last_removed = last_[removed]};
  for (std::uint32_t i = 0; i < n_new_; ++i) triangles_[new_triangles_[i].triangle].points = kNone;
  for (const auto& [point, i] : moves_) {
    std::uint32_t& first = triangles_[new_triangles_[i].triangle].points;
    next_point_[point] = first;
    first = point;
  }
  for (const std::uint32_t t : dead_) {
    if (t == kNone) continue;
    for (const std::uint32_t v : triangles_[t].v)
      if (v != removed) unlink(v, t);
    triangles_[t].points = kDead;
  }
  std::uint32_t* tail = &vertices_[kept].corners;
  while (*tail != kNone) tail = &next_corner_[*tail];
  for (std::uint32_t c = vertices_[removed].corners; c != kNone;) {
    const std::uint32_t next = next_corner_[c];
    WorkTriangle& t = triangles_[c >> 2];
    if (!t.is_dead()) {
      t.v[c & 3] = kept;
      *tail = c;
      tail = &next_corner_[c];
    }
    c = next;
  }
  *tail = kNone;
  last_[kept] = last_[removed] = next_collapse_++;
  vertices_[removed].corners = kNone;
  if (!(vertices_[kept].position == position)) {
    vertices_[kept].position = position;
    flags_[kept] |= kMovedFlag;
  }
  quadrics_[kept].add(quadrics_[removed]);
  costs_[kept] = -1;
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    costs_[new_triangles_[i].a] = -1;
    costs_[new_triangles_[i].b] = -1;
  }
}

void BlockSimplifier::unlink(std::uint32_t v, std::uint32_t triangle) {
  std::uint32_t* at = &vertices_[v].corners;
  while (*at >> 2 != triangle) at = &next_corner_[*at];
  *at = next_corner_[*at];
}

void BlockSimplifier::store() {
  for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
    const std::uint32_t id = vertex_ids_[v];
    local_[id] = kNone;
    mesh_.last[id] = last_[v];
    if ((flags_[v] & kMovedFlag) != 0) mesh_.positions[id] = centre_ + position(v);
  }
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const WorkTriangle& from = triangles_[t];
    WorkTriangle& to = mesh_.triangles[triangle_ids_[t]];
    for (std::size_t k = 0; k < 3; ++k) to.v[k] = vertex_ids_[from.v[k]];
    to.points = from.points;
    if (from.is_dead()) continue;
    std::uint32_t* tail = &to.points;
    for (std::uint32_t p = from.points; p != kNone; p = next_point_[p]) {
      *tail = point_ids_[p];
      mesh_.attached_to[point_ids_[p]] = triangle_ids_[t];
      tail = &mesh_.next_point[point_ids_[p]];
    }
    *tail = kNone;
  }
}

}  // namespace lode::simplification
