#include "lode/models/terrain/insertions/local_mesh.h"

#include <algorithm>

#include "lode/delaunay/tin_links.h"
#include "lode/models/terrain/insertions/extract.h"

namespace lode::insertions {
namespace {

using delaunay::InsertionRule;
using delaunay::LatticePoint;

std::vector<std::array<std::uint32_t, 3>> corners_of_base(const History& base) {
  std::vector<std::array<std::uint32_t, 3>> corners;
  corners.reserve(base.triangles.size());
  for (const Triangle& triangle : base.triangles) corners.push_back(triangle.corner);
  return corners;
}

}  // namespace

LocalMesh::LocalMesh(const HistoryFile& file, std::uint32_t end)
    : pages_(file),
      deaths_(pages_),
      end_(end),
      rule_(rule_of(file.base().model)),
      points_(file.base().vertices),
      heights_(file.base().heights),
      mesh_(delaunay::GrownNodes(points_), corners_of_base(file.base()), rule_) {
  if (rule_ == InsertionRule::delaunay) mesh_.cut(file.base().lines);
  for (const Triangle& triangle : file.base().triangles) {
    const std::uint32_t t = n_triangles();
    triangles_.push_back({.corner = triangle.corner, .place = t, .error = triangle.error});
    slot_of_.push_back(t);
    at_slot_.push_back(t);
  }
  first_made_ = {n_triangles()};
}

LatticeCorners LocalMesh::corners_of(std::uint32_t t) const {
  const auto& [a, b, c] = triangles_[t].corner;
  return {points_[a], points_[b], points_[c]};
}

std::array<double, 3> LocalMesh::heights_of(std::uint32_t t) const {
  const auto& [a, b, c] = triangles_[t].corner;
  return {heights_[a], heights_[b], heights_[c]};
}

Result<FileNode> LocalMesh::death_of(std::uint32_t t) { return death_before(t, end_); }

Result<FileNode> LocalMesh::death_before(std::uint32_t t, std::uint32_t end) {
  LocalTriangle& triangle = triangles_[t];
  if (triangle.death.time == kNone && triangle.looked_to < end) {
    LODE_TRY(triangle.death, deaths_.find(corners_of(t), triangle.looked_to, end));
    triangle.looked_to = end;
  }
  return triangle.death.time < end ? triangle.death : FileNode{};
}

Error LocalMesh::not_insertable(const FileNode& node, LatticePoint p) const {
  return fail(
      "{}: page {}, node {}: expected column {}, row {} in a triangle of its time that it can be "
      "inserted into",
      file().path(), node.page, node.time, p.x, p.y);
}

Result<void> LocalMesh::apply_death_of(std::uint32_t t) {
  wanted_.assign(1, t);
  while (!wanted_.empty()) {
    const std::uint32_t last = wanted_.back();
    if (triangles_[last].removed_by != kNone) {
      wanted_.pop_back();
      continue;
    }
    LODE_TRY(const FileNode node, death_of(last));
    LODE_TRY(const bool ready, is_ready(node, last));
    if (!ready) continue;
    LODE_CHECK(insert(node));
    // Else a file that lies would go on for ever.
    if (triangles_[last].removed_by == kNone) return not_insertable(node, points_.back());
  }
  return {};
}

/// Finds what the node removes, with triangle t, which it does. If other nodes come before it,
/// triangles that they remove are wanted to be: times only fall, so this ends.
Result<bool> LocalMesh::is_ready(const FileNode& node, std::uint32_t t) {
  LODE_TRY(const OpenPage* const page, pages_.page(node.page));
  const LatticePoint p = page->nodes().points[node.at];
  find_removed(p, t);
  const std::size_t n_before = wanted_.size();
  for (const std::uint32_t removed : removed_) {
    LODE_TRY(const FileNode death, death_of(removed));
    if (death == node) continue;
    if (death > node) return not_insertable(node, p);
    wanted_.push_back(removed);
  }
  if (rule_ == InsertionRule::delaunay && wanted_.size() == n_before)
    for (const std::uint32_t removed : removed_) LODE_CHECK(want_neighbours(node, p, removed));
  return wanted_.size() == n_before;
}

/// What is beside something that is removed may not be, but what is there in its place by then.
Result<void> LocalMesh::want_neighbours(const FileNode& node, LatticePoint p, std::uint32_t t) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    const delaunay::LatticeTriangle& triangle = mesh_.triangles()[slot_of_[t]];
    if (triangle.twin[i] == delaunay::kNoHalfEdge) continue;
    const std::uint32_t outer = at_slot_[triangle.twin[i] / 4];
    if (std::ranges::find(removed_, outer) != removed_.end()) continue;
    LODE_TRY(const bool gets,
             gets_removed(node, p, outer,
                          {points_[triangle.corner[i]], points_[triangle.corner[(i + 1) % 3]]}));
    if (gets) wanted_.push_back(outer);
  }
  return {};
}

/// Whether the node removes what is by then behind an edge, where now there is `outer`. As the edge
/// stays, each node that removes the triangle there makes one of the edge and its own vertex.
Result<bool> LocalMesh::gets_removed(const FileNode& node, LatticePoint p, std::uint32_t outer,
                                     const std::array<LatticePoint, 2>& edge) {
  LODE_TRY(FileNode death, death_before(outer, node.time));
  if (death.time == kNone) return false;
  LatticePoint apex{};
  while (death.time != kNone) {
    LODE_TRY(const OpenPage* const page, pages_.page(death.page));
    apex = page->nodes().points[death.at];
    if (delaunay::doubled_area(edge[1], edge[0], apex) <= 0) return not_insertable(death, apex);
    LODE_TRY(death, deaths_.find({edge[1], edge[0], apex}, death.time + 1, node.time));
  }
  return delaunay::is_in_circle(edge[1], edge[0], apex, p);
}

/// The triangles that a vertex removes, from one of them on.
void LocalMesh::find_removed(LatticePoint p, std::uint32_t t) {
  removed_.assign(1, t);
  for (std::size_t i = 0; i < removed_.size(); ++i) add_removed_behind(p, slot_of_[removed_[i]]);
}

void LocalMesh::add_removed_behind(LatticePoint p, std::uint32_t slot) {
  const delaunay::LatticeTriangle& triangle = mesh_.triangles()[slot];
  for (std::uint32_t i = 0; i < 3; ++i) {
    std::uint32_t twin = triangle.twin[i];
    const bool is_on = delaunay::doubled_area(points_[triangle.corner[i]],
                                              points_[triangle.corner[(i + 1) % 3]], p) == 0;
    // Behind fixed edges only where it lies on them.
    if (twin == delaunay::kNoHalfEdge && is_on) twin = mesh_.behind(slot, i);
    if (twin == delaunay::kNoHalfEdge) continue;
    const std::uint32_t other = at_slot_[twin / 4];
    const auto& [a, b, c] = corners_of(other);
    const bool is_removed =
        rule_ == InsertionRule::delaunay ? delaunay::is_in_circle(a, b, c, p) : is_on;
    if (is_removed && std::ranges::find(removed_, other) == removed_.end())
      removed_.push_back(other);
  }
}

/// Of what is removed, where the kernel is to begin; kNone where p is in none of it.
std::uint32_t LocalMesh::find_seed(LatticePoint p, bool begins_later) const {
  std::uint32_t seed = kNone;
  for (const std::uint32_t t : removed_) {
    if (!holds(corners_of(t), p)) continue;
    if (seed == kNone || (triangles_[t].order() > triangles_[seed].order()) == begins_later)
      seed = t;
  }
  return seed;
}

Result<void> LocalMesh::insert(const FileNode& node) {
  LODE_TRY(const OpenPage* const page, pages_.page_with_errors(node.page));
  const PageNodes& nodes = page->nodes();
  const LatticePoint p = nodes.points[node.at];
  const std::uint32_t seed = find_seed(p, nodes.begins_later[node.at]);
  const auto vertex = static_cast<std::uint32_t>(points_.size());
  points_.push_back(p);
  heights_.push_back(nodes.heights[node.at]);
  std::span<const std::uint32_t> slots;
  const std::size_t n_before = mesh_.triangles().size();
  if (seed == kNone || !mesh_.try_insert(vertex, slot_of_[seed], slots))
    return not_insertable(node, p);
  const std::uint32_t first = nodes.first_made[node.at];
  const std::uint32_t n_made = nodes.first_made[node.at + 1] - first;
  if (slots.size() != n_made)
    return fail("{}: page {}, node {}: expected it to make {} triangles, got {}", file().path(),
                node.page, node.time, n_made, slots.size());
  const std::uint32_t applied = n_applied();
  const std::size_t n_removed = slots.size() - (mesh_.triangles().size() - n_before);
  for (const std::uint32_t slot : slots.first(n_removed))
    triangles_[at_slot_[slot]].removed_by = applied;
  at_slot_.resize(mesh_.triangles().size());
  for (std::uint32_t i = 0; i < n_made; ++i) {
    at_slot_[slots[i]] = n_triangles();
    slot_of_.push_back(slots[i]);
    triangles_.push_back({.corner = mesh_.triangles()[slots[i]].corner,
                          .birth = node.time,
                          .place = i,
                          .error = page->errors[first + i],
                          .looked_to = node.time + 1});
  }
  first_made_.push_back(n_triangles());
  return {};
}

delaunay::Tin LocalMesh::to_tin(std::vector<std::uint32_t> triangles,
                                delaunay::TinLinks links) const {
  std::ranges::sort(triangles, {}, [&](std::uint32_t t) { return triangles_[t].order(); });
  delaunay::Tin tin;
  for (const std::uint32_t t : triangles) {
    tin.triangles.push_back(triangles_[t].corner);
    if (links == delaunay::TinLinks::kept) tin.errors.push_back(triangles_[t].error);
  }
  place_vertices(points_, heights_, tin);
  if (links == delaunay::TinLinks::kept) tin.twins = delaunay::find_twins(tin.triangles);
  return tin;
}

}  // namespace lode::insertions
