// Incremental Delaunay triangulation: A. Bowyer, "Computing Dirichlet tessellations", and D. F.
// Watson, "Computing the n-dimensional Delaunay tessellation", both Computer Journal 24 (2), 1981.
#include "lode/delaunay/lattice_mesh.h"

#include <algorithm>

#include "lode/core/expects.h"
#include "lode/delaunay/grown_nodes.h"
#include "lode/delaunay/tin_links.h"

namespace lode::delaunay {
namespace {

constexpr std::array<std::uint32_t, 3> kNext{1, 2, 0};
constexpr std::array<std::uint32_t, 3> kPrevious{2, 0, 1};

}  // namespace

template <typename Nodes>
NodeMesh<Nodes>::NodeMesh(Nodes nodes, std::span<const std::array<std::uint32_t, 3>> triangles,
                          InsertionRule rule)
    : nodes_(nodes), rule_(rule) {
  triangles_.resize(triangles.size());
  const auto twins = find_twins(triangles);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corner = triangles[t];
    LODE_EXPECTS(doubled_area(nodes_.unpack(corner[0]), nodes_.unpack(corner[1]),
                              nodes_.unpack(corner[2])) > 0);
    triangles_[t] = {corner, twins[t], 0, 0};
  }
  find_size();
}

template <typename Nodes>
NodeMesh<Nodes>::NodeMesh(Nodes nodes, LatticeTriangles linked, InsertionRule rule)
    : nodes_(nodes), rule_(rule), triangles_(std::move(linked)) {
  find_size();
}

template <typename Nodes>
void NodeMesh<Nodes>::find_size() {
  std::int32_t largest = 0;
  for (const LatticeTriangle& triangle : triangles_)
    for (const std::uint32_t corner : triangle.corner) {
      const LatticePoint p = nodes_.unpack(corner);
      largest = std::max({largest, p.x, p.y});
    }
  is_narrow_ = largest < kNarrowLattice;
}

template <typename Nodes>
template <bool kIsNarrow>
void NodeMesh<Nodes>::remove_round(LatticePoint p, std::uint32_t t) {
  const auto relative = [&](std::uint32_t corner) {
    const LatticePoint q = nodes_.unpack(corner);
    return LatticePoint{q.x - p.x, q.y - p.y};
  };
  const LatticeTriangle& start = triangles_[t];
  const LatticePoint a = relative(start.corner[0]);
  const LatticePoint b = relative(start.corner[1]);
  const LatticePoint c = relative(start.corner[2]);
  slots_.assign(1, t);
  border_.clear();
  stack_.assign({{start.twin[2], start.corner[2], c, a},
                 {start.twin[1], start.corner[1], b, c},
                 {start.twin[0], start.corner[0], a, b}});
  while (!stack_.empty()) {
    const InnerEdge edge = stack_.back();
    stack_.pop_back();
    if (edge.twin == kNoHalfEdge) {
      border_.push_back({edge.start, edge.twin});
      continue;
    }
    const LatticeTriangle& outer = triangles_[edge.twin >> 2];
    const std::uint32_t next = kNext[edge.twin & 3];
    const std::uint32_t previous = kPrevious[edge.twin & 3];
    const std::uint32_t apex = outer.corner[previous];
    const LatticePoint across = relative(apex);
    // The outer triangle runs from the edge's end to its start.
    if (!is_origin_in_circle<kIsNarrow>(edge.to, edge.from, across)) {
      border_.push_back({edge.start, edge.twin});
      continue;
    }
    // Of a mesh that is none this could go on for ever.
    if (slots_.size() >= triangles_.size()) return;
    // Edges come from the stack in the order in which they lie round p.
    slots_.push_back(edge.twin >> 2);
    stack_.push_back({outer.twin[previous], apex, across, edge.to});
    stack_.push_back({outer.twin[next], edge.start, edge.from, across});
  }
}

template <typename Nodes>
void NodeMesh<Nodes>::remove_at(LatticePoint p, std::uint32_t t) {
  const LatticeTriangle& start = triangles_[t];
  slots_.assign(1, t);
  border_.clear();
  for (std::uint32_t i = 0; i < 3; ++i) {
    const std::uint32_t from = start.corner[i];
    const std::uint32_t twin = start.twin[i];
    const bool is_on =
        twin != kNoHalfEdge &&
        doubled_area(nodes_.unpack(from), nodes_.unpack(start.corner[kNext[i]]), p) == 0;
    if (!is_on) {
      border_.push_back({from, twin});
      continue;
    }
    // In the edge's place the other two of the triangle behind it, which runs from its end.
    const LatticeTriangle& outer = triangles_[twin >> 2];
    const std::uint32_t next = kNext[twin & 3];
    const std::uint32_t previous = kPrevious[twin & 3];
    slots_.push_back(twin >> 2);
    border_.push_back({from, outer.twin[next]});
    border_.push_back({outer.corner[previous], outer.twin[previous]});
  }
}

template <typename Nodes>
std::size_t NodeMesh<Nodes>::split_edge(LatticePoint p) const {
  for (std::size_t i = 0; i < border_.size(); ++i) {
    if (border_[i].twin != kNoHalfEdge) continue;
    const LatticePoint a = nodes_.unpack(border_[i].from);
    const LatticePoint b = nodes_.unpack(border_[i + 1 < border_.size() ? i + 1 : 0].from);
    if (doubled_area(a, b, p) == 0) return i;
  }
  return border_.size();
}

template <typename Nodes>
void NodeMesh<Nodes>::fill_fan(std::uint32_t p, std::size_t split) {
  const std::size_t n = border_.size();
  const bool is_closed = split == n;
  const std::size_t n_made = is_closed ? n : n - 1;
  const auto n_before = static_cast<std::uint32_t>(triangles_.size());
  LODE_EXPECTS(slots_.size() <= n_made);
  const std::size_t n_added = n_made - slots_.size();
  triangles_.resize(n_before + n_added);
  for (std::uint32_t i = 0; i < n_added; ++i) slots_.push_back(n_before + i);

  // After the edge that p splits, once round.
  for (std::size_t k = 0, i = is_closed || split + 1 == n ? 0 : split + 1; k < n_made; ++k) {
    const BorderEdge& edge = border_[i];
    const std::size_t after = i + 1 < n ? i + 1 : 0;
    const std::uint32_t slot = slots_[k];
    const bool has_next = is_closed || k + 1 < n_made;
    const bool has_previous = is_closed || k > 0;
    const std::uint32_t next = slots_[k + 1 < n_made ? k + 1 : 0];
    const std::uint32_t previous = slots_[k > 0 ? k - 1 : n_made - 1];
    LatticeTriangle& made = triangles_[slot];
    made.corner = {edge.from, border_[after].from, p};
    made.twin = {edge.twin, has_next ? 4 * next + 2 : kNoHalfEdge,
                 has_previous ? 4 * previous + 1 : kNoHalfEdge};
    if (edge.twin != kNoHalfEdge) triangles_[edge.twin >> 2].twin[edge.twin & 3] = 4 * slot;
    i = after;
  }
}

template <typename Nodes>
std::span<const std::uint32_t> NodeMesh<Nodes>::insert(std::uint32_t p, std::uint32_t t) {
  const LatticePoint point = nodes_.unpack(p);
  remove_for(point, t);
  const std::size_t split = split_edge(point);
  if (cuts_.empty())
    fill_fan(p, split);
  else
    fill_beside_cuts(p, split);
  return slots_;
}

/// As fill_fan(), where edges of the border may be cuts; of one that p lies on also behind it.
template <typename Nodes>
void NodeMesh<Nodes>::fill_beside_cuts(std::uint32_t p, std::size_t split) {
  const std::uint32_t behind = split < border_.size() ? split_cut(p, split) : kNoHalfEdge;
  const std::size_t n_removed = slots_.size();
  fill_fan(p, split);
  find_cuts();
  if (behind == kNoHalfEdge) return;
  const std::vector<std::uint32_t> before = slots_;
  const LatticePoint point = nodes_.unpack(p);
  remove_for(point, behind >> 2);
  const std::size_t n_removed_behind = slots_.size();
  fill_fan(p, split_edge(point));
  find_cuts();
  // Numbers of removed ones come first.
  slots_.insert(slots_.begin() + static_cast<std::ptrdiff_t>(n_removed_behind),
                before.begin() + static_cast<std::ptrdiff_t>(n_removed), before.end());
  slots_.insert(slots_.begin(), before.begin(),
                before.begin() + static_cast<std::ptrdiff_t>(n_removed));
}

/// Behind the border's edge, where it is a cut.
template <typename Nodes>
std::uint32_t NodeMesh<Nodes>::behind_cut(std::size_t split) const {
  const std::uint32_t from = border_[split].from;
  const std::uint32_t to = border_[split + 1 < border_.size() ? split + 1 : 0].from;
  const auto found = cuts_.find(cut_key(from, to));
  return found == cuts_.end() ? kNoHalfEdge : found->second[from < to ? 1 : 0];
}

/// Replaces the cut along the border's edge, if it is one, by two that meet at p. Returns the
/// half-edge behind it, else kNoHalfEdge.
template <typename Nodes>
std::uint32_t NodeMesh<Nodes>::split_cut(std::uint32_t p, std::size_t split) {
  const std::uint32_t behind = behind_cut(split);
  if (behind == kNoHalfEdge) return behind;
  const std::uint32_t from = border_[split].from;
  const std::uint32_t to = border_[split + 1 < border_.size() ? split + 1 : 0].from;
  cuts_.erase(cut_key(from, to));
  for (const std::uint32_t end : {from, to}) cuts_[cut_key(end, p)] = {kNoHalfEdge, kNoHalfEdge};
  return behind;
}

/// Takes down where the cuts beside new triangles are.
template <typename Nodes>
void NodeMesh<Nodes>::find_cuts() {
  for (const std::uint32_t slot : slots_)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const LatticeTriangle& triangle = triangles_[slot];
      if (triangle.twin[i] != kNoHalfEdge) continue;
      const std::uint32_t from = triangle.corner[i];
      const std::uint32_t to = triangle.corner[kNext[i]];
      if (const auto found = cuts_.find(cut_key(from, to)); found != cuts_.end())
        found->second[from < to ? 0 : 1] = 4 * slot + i;
    }
}

template <typename Nodes>
void NodeMesh<Nodes>::cut(std::span<const std::array<std::uint32_t, 2>> edges) {
  for (const auto& edge : edges) cuts_[cut_key(edge[0], edge[1])] = {kNoHalfEdge, kNoHalfEdge};
  for (std::uint32_t t = 0; t < triangles_.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t from = triangles_[t].corner[i];
      const std::uint32_t to = triangles_[t].corner[kNext[i]];
      const auto found = cuts_.find(cut_key(from, to));
      if (found == cuts_.end()) continue;
      found->second[from < to ? 0 : 1] = 4 * t + i;
      triangles_[t].twin[i] = kNoHalfEdge;
    }
  std::erase_if(cuts_, [](const auto& cut) {
    return cut.second[0] == kNoHalfEdge || cut.second[1] == kNoHalfEdge;
  });
}

template <typename Nodes>
std::uint32_t NodeMesh<Nodes>::behind(std::uint32_t t, std::uint32_t edge) const {
  const LatticeTriangle& triangle = triangles_[t];
  if (triangle.twin[edge] != kNoHalfEdge || cuts_.empty()) return triangle.twin[edge];
  const std::uint32_t from = triangle.corner[edge];
  const std::uint32_t to = triangle.corner[kNext[edge]];
  const auto found = cuts_.find(cut_key(from, to));
  return found == cuts_.end() ? kNoHalfEdge : found->second[from < to ? 1 : 0];
}

template <typename Nodes>
std::vector<std::array<std::uint32_t, 2>> NodeMesh<Nodes>::heal() {
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const auto& [key, sides] : cuts_) {
    for (const std::size_t i : {0U, 1U})
      triangles_[sides[i] >> 2].twin[sides[i] & 3] = sides[1 - i];
    edges.push_back({static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)});
  }
  cuts_.clear();
  std::ranges::sort(edges);
  return edges;
}

template <typename Nodes>
bool NodeMesh<Nodes>::is_disk_round(LatticePoint p, std::size_t split) {
  const std::size_t n = border_.size();
  if (n != slots_.size() + 2) return false;
  sorted_ = slots_;
  std::ranges::sort(sorted_);
  if (std::ranges::adjacent_find(sorted_) != sorted_.end()) return false;
  for (std::size_t i = 0; i < n; ++i) {
    if (i == split) continue;
    const LatticePoint a = nodes_.unpack(border_[i].from);
    const LatticePoint b = nodes_.unpack(border_[i + 1 < n ? i + 1 : 0].from);
    if (doubled_area(a, b, p) <= 0) return false;
  }
  return true;
}

/// Of what p replaces behind the border's edge, if that is a cut.
template <typename Nodes>
bool NodeMesh<Nodes>::is_disk_behind(LatticePoint p, std::size_t split) {
  const std::uint32_t behind = behind_cut(split);
  if (behind == kNoHalfEdge) return true;
  remove_for(p, behind >> 2);
  const std::size_t split_behind = split_edge(p);
  return split_behind < border_.size() && is_disk_round(p, split_behind);
}

template <typename Nodes>
bool NodeMesh<Nodes>::try_insert(std::uint32_t p, std::uint32_t t,
                                 std::span<const std::uint32_t>& slots) {
  const LatticePoint point = nodes_.unpack(p);
  remove_for(point, t);
  const std::size_t split = split_edge(point);
  if (!is_disk_round(point, split)) return false;
  if (cuts_.empty()) {
    fill_fan(p, split);
  } else {
    if (split < border_.size()) {
      if (!is_disk_behind(point, split)) return false;
      remove_for(point, t);
    }
    fill_beside_cuts(p, split);
  }
  slots = slots_;
  return true;
}

/// Whether the corner across lies in the triangle's circle.
template <typename Nodes>
bool NodeMesh<Nodes>::is_turned_better(std::uint32_t half_edge) const {
  const LatticeTriangle& triangle = triangles_[half_edge >> 2];
  const std::uint32_t twin = triangle.twin[half_edge & 3];
  if (twin == kNoHalfEdge) return false;
  const LatticePoint across = nodes_.unpack(triangles_[twin >> 2].corner[kPrevious[twin & 3]]);
  const auto& corner = triangle.corner;
  return is_in_circle(nodes_.unpack(corner[0]), nodes_.unpack(corner[1]), nodes_.unpack(corner[2]),
                      across);
}

/// Of the two triangles (a, b, c) and (b, a, d) beside an edge it makes (a, d, c) and (d, b, c).
template <typename Nodes>
void NodeMesh<Nodes>::turn(std::uint32_t half_edge) {
  const std::uint32_t t = half_edge >> 2;
  const std::uint32_t i = half_edge & 3;
  const LatticeTriangle left = triangles_[t];
  const std::uint32_t u = left.twin[i] >> 2;
  const std::uint32_t j = left.twin[i] & 3;
  const LatticeTriangle right = triangles_[u];
  const std::uint32_t c = left.corner[kPrevious[i]];
  const std::uint32_t d = right.corner[kPrevious[j]];
  triangles_[t].corner = {left.corner[i], d, c};
  triangles_[t].twin = {right.twin[kNext[j]], 4 * u + 2, left.twin[kPrevious[i]]};
  triangles_[u].corner = {d, right.corner[j], c};
  triangles_[u].twin = {right.twin[kPrevious[j]], left.twin[kNext[i]], 4 * t + 1};
  const auto link = [&](std::uint32_t own) {
    const std::uint32_t twin = triangles_[own >> 2].twin[own & 3];
    if (twin != kNoHalfEdge) triangles_[twin >> 2].twin[twin & 3] = own;
  };
  for (const std::uint32_t own : {4 * t, 4 * t + 2, 4 * u, 4 * u + 1}) link(own);
}

template <typename Nodes>
std::vector<std::uint32_t> NodeMesh<Nodes>::make_delaunay(std::vector<std::uint32_t> suspects) {
  std::vector<std::uint32_t> changed;
  while (!suspects.empty()) {
    const std::uint32_t half_edge = suspects.back();
    suspects.pop_back();
    if (!is_turned_better(half_edge)) continue;
    const std::uint32_t t = half_edge >> 2;
    const std::uint32_t u = triangles_[t].twin[half_edge & 3] >> 2;
    turn(half_edge);
    changed.insert(changed.end(), {t, u});
    suspects.insert(suspects.end(), {4 * t, 4 * t + 2, 4 * u, 4 * u + 1});
  }
  return changed;
}

template <typename Nodes>
bool NodeMesh<Nodes>::is_delaunay() const {
  for (const LatticeTriangle& triangle : triangles_)
    for (const std::uint32_t twin : triangle.twin) {
      if (twin == kNoHalfEdge) continue;
      const LatticePoint across = nodes_.unpack(triangles_[twin >> 2].corner[kPrevious[twin & 3]]);
      const auto& corner = triangle.corner;
      if (is_in_circle(nodes_.unpack(corner[0]), nodes_.unpack(corner[1]), nodes_.unpack(corner[2]),
                       across))
        return false;
    }
  return true;
}

template <typename Nodes>
std::uint32_t NodeMesh<Nodes>::growth(std::uint32_t p, std::uint32_t t) const {
  const LatticeTriangle& triangle = triangles_[t];
  const LatticePoint point = nodes_.unpack(p);
  for (std::uint32_t i = 0; i < 3; ++i)
    if (triangle.twin[i] == kNoHalfEdge &&
        doubled_area(nodes_.unpack(triangle.corner[i]), nodes_.unpack(triangle.corner[kNext[i]]),
                     point) == 0)
      return cuts_.contains(cut_key(triangle.corner[i], triangle.corner[kNext[i]])) ? 2 : 1;
  return 2;
}

template class NodeMesh<LatticePacking>;
template class NodeMesh<ListedNodes>;
template class NodeMesh<GrownNodes>;

}  // namespace lode::delaunay
