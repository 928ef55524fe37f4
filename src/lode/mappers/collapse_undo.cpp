#include "lode/mappers/collapse_undo.h"

#include <algorithm>

#include "lode/core/point_triangle.h"

namespace lode::simplification {

CollapseUndo::CollapseUndo(CollapseMesh& mesh, const Surface& original,
                           std::span<const std::uint32_t> live, UndoOrder order,
                           const SurfaceBand* band, float near)
    : mesh_(mesh), original_(original), order_(order), band_(band), near_(near) {
  first_.resize(mesh.positions.size());
  std::fill(first_.begin(), first_.end(), kNone);
  next_.resize(4 * mesh.triangles.size());
  for (const std::uint32_t t : live)
    for (std::uint32_t k = 0; k < 3; ++k) link(mesh.triangles[t].v[k], 4 * t + k);
}

void CollapseUndo::link(std::uint32_t v, std::uint32_t corner) {
  next_[corner] = first_[v];
  first_[v] = corner;
}

std::uint32_t CollapseUndo::maker(std::uint32_t triangle) const {
  std::uint32_t latest = kNone;
  for (const std::uint32_t v : mesh_.triangles[triangle].v) {
    const std::uint32_t c = mesh_.last[v];
    if (c != kNone && (latest == kNone || c > latest)) latest = c;
  }
  return latest;
}

std::uint32_t CollapseUndo::undo(std::uint32_t collapse, std::vector<std::uint32_t>& changed) {
  std::uint32_t n = 0;
  pending_.assign(1, collapse);
  while (!pending_.empty()) {
    const std::uint32_t c = pending_.back();
    std::uint32_t later = find_later(c);
    const bool asks_band = order_ == UndoOrder::splits && band_ != nullptr;
    if (later == kNone && asks_band && !may_sweep_back(c)) {
      // With fewer of the others it may, as it might in the end by itself.
      later = find_later_in_star(c);
      is_stuck_ = later == kNone;
      if (is_stuck_) return n;
    }
    if (later != kNone) {
      pending_.push_back(later);
      continue;
    }
    undo_one(mesh_.collapses[c], changed);
    pending_.pop_back();
    ++n;
  }
  return n;
}

/// One that must be taken back before. The vertex is split into the two that were collapsed, of
/// which each takes the triangles of what went into it: that is an inverse of an edge collapse, and
/// so a homeomorphism, if what the two had in common, left and right, still is two vertices.
std::uint32_t CollapseUndo::find_later(std::uint32_t collapse) const {
  const Collapse& c = mesh_.collapses[collapse];
  if (mesh_.last[c.kept] != collapse) return mesh_.last[c.kept];
  if (order_ == UndoOrder::stars) return find_later_in_star(collapse);
  if (c.dead[0] == kNone || c.dead[1] == kNone) return kNone;  // the surface's border
  const std::uint32_t left = apex_of(c.dead[0], c.kept);
  return left == apex_of(c.dead[1], c.kept) ? mesh_.last[left] : kNone;
}

/// Triangles of the star are only changed by collapses at its vertices; so without any it is as it
/// was.
std::uint32_t CollapseUndo::find_later_in_star(std::uint32_t collapse) const {
  for (std::uint32_t c = first_[mesh_.collapses[collapse].kept]; c != kNone; c = next_[c])
    for (const std::uint32_t v : mesh_.triangles[c >> 2].v)
      if (mesh_.last[v] != kNone && mesh_.last[v] > collapse) return mesh_.last[v];
  return kNone;
}

/// Of a triangle that an edge took with it which is now the vertex `kept`.
std::uint32_t CollapseUndo::apex_of(std::uint32_t dead, std::uint32_t kept) const {
  for (const std::uint32_t v : original_.triangles[dead])
    if (const std::uint32_t root = mesh_.root_of(v); root != kept) return root;
  return kept;
}

/// Whether no sample outside the band is in what the split sweeps: the removed vertex goes back to
/// its place with its triangles, then the other one.
bool CollapseUndo::may_sweep_back(std::uint32_t collapse) const {
  const Collapse& c = mesh_.collapses[collapse];
  const Vec3d from = in_band(mesh_.positions[c.kept]);
  const Vec3d kept = in_band(Vec3f{c.kept_position});
  const Vec3d removed = in_band(mesh_.positions[c.removed]);
  const bool stays = mesh_.positions[c.kept].v == c.kept_position;
  for (std::uint32_t corner = first_[c.kept]; corner != kNone; corner = next_[corner]) {
    const std::uint32_t t = corner >> 2;
    const std::uint32_t k = corner & 3;
    const bool is_removed = is_of_removed(original_.triangles[t][k], collapse);
    if (!is_removed && stays) continue;
    const auto& v = mesh_.triangles[t].v;
    if (band_->may_hold_fixed({from, is_removed ? removed : kept,
                               in_band(mesh_.positions[v[(k + 1) % 3]]),
                               in_band(mesh_.positions[v[(k + 2) % 3]])}))
      return false;
  }
  return stays || std::ranges::none_of(c.dead, [&](std::uint32_t t) {
           return t != kNone &&
                  band_->may_hold_fixed(
                      {from, kept, removed, in_band(mesh_.positions[apex_of(t, c.kept)])});
         });
}

/// Of an original vertex that has gone into the collapse's: by which of the two.
bool CollapseUndo::is_of_removed(std::uint32_t vertex, std::uint32_t collapse) const {
  while (mesh_.is_removed(vertex)) {
    if (mesh_.last[vertex] == collapse) return true;
    vertex = mesh_.collapses[mesh_.last[vertex]].kept;
  }
  return false;
}

Vec3d CollapseUndo::in_band(const Vec3f& position) const {
  return band_->own_coordinates(widened(position));
}

void CollapseUndo::undo_one(const Collapse& collapse, std::vector<std::uint32_t>& changed) {
  std::vector<std::uint32_t> points;
  const auto take_points = [&](std::uint32_t t) {
    for (std::uint32_t p = mesh_.triangles[t].points; p != kNone; p = mesh_.next_point[p])
      points.push_back(p);
    mesh_.triangles[t].points = kNone;
  };
  for_each_around(collapse.kept, take_points);
  mesh_.last[collapse.kept] = collapse.last_kept;
  mesh_.last[collapse.removed] = collapse.last_removed;
  mesh_.positions[collapse.kept].v = collapse.kept_position;
  first_[collapse.removed] = kNone;
  split(collapse);
  for (const std::uint32_t t : collapse.dead)
    if (t != kNone) bring_back(t);
  std::vector<std::uint32_t> around;
  for (const std::uint32_t v : {collapse.kept, collapse.removed})
    for_each_around(v, [&](std::uint32_t t) { around.push_back(t); });
  for (const std::uint32_t p : points) attach(p, around);
  changed.insert(changed.end(), around.begin(), around.end());
}

/// Gives the removed vertex its triangles back.
void CollapseUndo::split(const Collapse& collapse) {
  std::uint32_t* at = &first_[collapse.kept];
  while (*at != kNone) {
    const std::uint32_t corner = *at;
    const std::uint32_t t = corner >> 2;
    if (mesh_.root_of(original_.triangles[t][corner & 3]) == collapse.kept) {
      at = &next_[corner];
      continue;
    }
    *at = next_[corner];
    mesh_.triangles[t].v[corner & 3] = collapse.removed;
    link(collapse.removed, corner);
  }
}

void CollapseUndo::bring_back(std::uint32_t triangle) {
  WorkTriangle& t = mesh_.triangles[triangle];
  t.points = kNone;
  for (std::uint32_t k = 0; k < 3; ++k) {
    t.v[k] = mesh_.root_of(original_.triangles[triangle][k]);
    link(t.v[k], 4 * triangle + k);
  }
}

void CollapseUndo::attach(std::uint32_t point, std::span<const std::uint32_t> triangles) {
  std::uint32_t best = mesh_.attached_to[point];
  float least = squared_distance_to_triangle(original_.positions[point], corners(mesh_, best));
  for (const std::uint32_t t : triangles) {
    if (least <= near_ * near_) break;
    const float here = squared_distance_to_triangle(original_.positions[point], corners(mesh_, t));
    if (here >= least) continue;
    least = here;
    best = t;
  }
  mesh_.next_point[point] = mesh_.triangles[best].points;
  mesh_.triangles[best].points = point;
  mesh_.attached_to[point] = best;
}

}  // namespace lode::simplification
