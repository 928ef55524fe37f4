#include "lode/mappers/collapse_block.h"

#include <algorithm>

namespace lode::simplification {
namespace {

constexpr float kTried = 2e30F;  ///< A cost above all thresholds.
/// What a full-resolution surface of tetrahedra is full of, slivers, must be able to turn into
/// other slivers on its way: only late sweeps refuse them, and try others where the best choice
/// fails. On engine within a voxel 1e-3 in all sweeps leaves 83,210 triangles, 1e-5 in the first
/// 36,634.
constexpr std::array<Sweep, 5> kSweeps = {{{.threshold = 0.001F, .shape = 1e-5F, .n_others = 0},
                                           {.threshold = 0.01F, .shape = 1e-5F, .n_others = 0},
                                           {.threshold = 0.1F, .shape = 1e-5F, .n_others = 0},
                                           {.threshold = 1.0F, .shape = 1e-3F, .n_others = 2},
                                           {.threshold = 1e9F, .shape = 1e-3F, .n_others = 2}}};

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
  const float unit = limits_.area * limits_.reach * limits_.reach;
  for (const Sweep& sweep : kSweeps) {
    if (progress.is_cancelled()) break;
    run_sweep({sweep.threshold * unit, sweep.shape, sweep.n_others});
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
  marks_.resize(vertices_.size());
  quadrics_.assign(vertices_.size(), {});
  costs_.assign(vertices_.size(), -1.0F);
  if (limits_.band != nullptr) {
    in_band_.resize(vertices_.size());
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) in_band_[v] = find_in_band(v);
  }
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

void BlockSimplifier::run_sweep(const Sweep& sweep) {
  least_shape_ = sweep.shape;
  Star star;
  const auto n = static_cast<std::uint32_t>(vertices_.size());
  for (std::uint32_t v = 0; v < n; ++v) {
    if (vertices_[v].corners == kNone || (flags_[v] & kLockedFlag) != 0) continue;
    if (costs_[v] > sweep.threshold) continue;
    if (!gather(v, star)) continue;
    const Choice choice = choose(v, star);
    costs_[v] = std::max(choice.cost, 0.0F);
    if (choice.other == kNone || choice.cost > sweep.threshold) continue;
    if (try_collapse(choice.other, v, star, choice.position)) continue;
    if (!try_others(v, star, choice, sweep)) costs_[v] = kTried;
  }
}

void BlockSimplifier::apply(std::uint32_t kept, std::uint32_t removed, const Vec3f& position) {
  const auto global = [&](std::uint32_t t) { return t == kNone ? kNone : triangle_ids_[t]; };
  mesh_.collapses[next_collapse_] = {.kept = vertex_ids_[kept],
                                     .removed = vertex_ids_[removed],
                                     .dead = {global(dead_[0]), global(dead_[1])},
                                     .kept_position = stored_position(kept).v,
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
    if (limits_.band != nullptr) in_band_[kept] = find_in_band(kept);
  }
  quadrics_[kept].add(quadrics_[removed]);
  costs_[kept] = -1;
  for (std::uint32_t i = 0; i < n_new_; ++i) {
    costs_[new_triangles_[i].a] = -1;
    costs_[new_triangles_[i].b] = -1;
  }
}

/// What store() will leave of it.
Vec3f BlockSimplifier::stored_position(std::uint32_t v) const {
  return (flags_[v] & kMovedFlag) != 0 ? centre_ + position(v) : mesh_.positions[vertex_ids_[v]];
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
