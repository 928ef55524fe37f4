#include "lode/mappers/collapse_undo.h"

#include <algorithm>

#include "lode/core/point_triangle.h"

namespace lode::simplification {

CollapseUndo::CollapseUndo(CollapseMesh& mesh, std::span<const Vec3f> original, float near)
    : mesh_(mesh), original_(original), near_(near) {
  first_.resize(mesh.positions.size());
  std::fill(first_.begin(), first_.end(), kNone);
  next_.resize(4 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (!mesh.triangles[t].is_dead())
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
    const std::uint32_t later = find_later(c);
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

/// A later collapse at a vertex of the star that this one left. Triangles of the star are only
/// changed by such; so without any it is as it was.
std::uint32_t CollapseUndo::find_later(std::uint32_t collapse) const {
  const std::uint32_t kept = mesh_.collapses[collapse].kept;
  if (mesh_.last[kept] != collapse) return mesh_.last[kept];
  for (std::uint32_t c = first_[kept]; c != kNone; c = next_[c])
    for (const std::uint32_t v : mesh_.triangles[c >> 2].v)
      if (mesh_.last[v] != kNone && mesh_.last[v] > collapse) return mesh_.last[v];
  return kNone;
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
  move_fan(collapse);
  for (const std::uint32_t t : collapse.dead) {
    if (t == kNone) continue;
    mesh_.triangles[t].points = kNone;
    for (std::uint32_t k = 0; k < 3; ++k) link(mesh_.triangles[t].v[k], 4 * t + k);
  }
  std::vector<std::uint32_t> around;
  for (const std::uint32_t v : {collapse.kept, collapse.removed})
    for_each_around(v, [&](std::uint32_t t) { around.push_back(t); });
  for (const std::uint32_t p : points) attach(p, around);
  changed.insert(changed.end(), around.begin(), around.end());
}

/// Gives the removed vertex its triangles back: those between the two dead ones, on its side. A
/// dead triangle that runs from kept to removed to a has them begin beyond the edge removed-a.
void CollapseUndo::move_fan(const Collapse& collapse) {
  std::uint32_t begin = kNone;
  std::uint32_t end = kNone;
  for (const std::uint32_t t : collapse.dead) {
    if (t == kNone) continue;
    const auto& v = mesh_.triangles[t].v;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t next = v[(k + 1) % 3];
      if (v[k] == collapse.kept && next == collapse.removed) begin = v[(k + 2) % 3];
      if (v[k] == collapse.removed && next == collapse.kept) end = v[(k + 2) % 3];
    }
  }
  // Forward, each triangle (kept, x, y) is followed by the one with y = x; backward the other way.
  const bool is_forward = begin != kNone;
  const std::uint32_t stop = is_forward ? end : kNone;
  std::uint32_t at = is_forward ? begin : end;
  while (at != stop) {
    const std::uint32_t corner = find_spoke(collapse.kept, is_forward ? 2 : 1, at);
    if (corner == kNone) break;  // the surface's border
    const auto& v = mesh_.triangles[corner >> 2].v;
    at = v[((corner & 3) + (is_forward ? 1 : 2)) % 3];
    move_corner(corner, collapse.kept, collapse.removed);
  }
}

/// The corner at v of the triangle whose k-th vertex from there is `end`.
std::uint32_t CollapseUndo::find_spoke(std::uint32_t v, std::uint32_t k, std::uint32_t end) const {
  for (std::uint32_t c = first_[v]; c != kNone; c = next_[c])
    if (mesh_.triangles[c >> 2].v[((c & 3) + k) % 3] == end) return c;
  return kNone;
}

void CollapseUndo::move_corner(std::uint32_t corner, std::uint32_t from, std::uint32_t to) {
  std::uint32_t* at = &first_[from];
  while (*at != corner) at = &next_[*at];
  *at = next_[corner];
  mesh_.triangles[corner >> 2].v[corner & 3] = to;
  link(to, corner);
}

void CollapseUndo::attach(std::uint32_t point, std::span<const std::uint32_t> triangles) {
  std::uint32_t best = mesh_.attached_to[point];
  float least = squared_distance_to_triangle(original_[point], corners(mesh_, best));
  for (const std::uint32_t t : triangles) {
    if (least <= near_ * near_) break;
    const float here = squared_distance_to_triangle(original_[point], corners(mesh_, t));
    if (here >= least) continue;
    least = here;
    best = t;
  }
  mesh_.next_point[point] = mesh_.triangles[best].points;
  mesh_.triangles[best].points = point;
  mesh_.attached_to[point] = best;
}

}  // namespace lode::simplification
