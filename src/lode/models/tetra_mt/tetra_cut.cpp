#include "lode/models/tetra_mt/tetra_cut.h"

#include <algorithm>
#include <utility>

namespace lode::tetra_mt {
namespace {

std::vector<std::uint32_t> count_base(const HierarchyHead& head) {
  std::vector<std::uint32_t> counts(head.n_vertices(), 0);
  for (const Tetrahedron& t : head.base)
    for (const std::uint32_t v : t)
      if (v != head.outside()) ++counts[v];
  return counts;
}

template <typename Coming>
void sort_by_key(std::vector<Coming>& coming) {
  for (std::size_t i = 1; i < coming.size(); ++i) {
    const Coming one = coming[i];
    std::size_t at = i;
    for (; at > 0 && coming[at - 1].key > one.key; --at) coming[at] = coming[at - 1];
    coming[at] = one;
  }
}

}  // namespace

TetraCut::TetraCut(const PackedHierarchy& hierarchy, std::size_t field)
    : hierarchy_(&hierarchy),
      field_(field),
      outside_(hierarchy.head().outside()),
      stars_(count_base(hierarchy.head())) {
  const HierarchyHead& head = hierarchy.head();
  for (std::uint32_t slot = 0; slot < head.base.size(); ++slot) {
    const std::uint32_t region = head.base_regions.empty() ? 0 : head.base_regions[slot];
    cells_.push_back({head.base[slot], head.base_makers[slot], region});
    for (const std::uint32_t v : head.base[slot])
      if (v != outside_) stars_.add(v, slot);
  }
}

void TetraCut::add_base(std::vector<NodeId>& out) const {
  for (const std::uint32_t node : hierarchy_->head().roots) out.push_back(NodeId{node});
}

void TetraCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  NodePage::Links links = hierarchy_->links(index(node));
  for (std::uint32_t k = links.n_discovered(); k > 0; --k) out.push_back(NodeId{links.next_node()});
}

/// A chain of nodes that wait for one another has no end, nor do those that ask for them.
void TetraCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  if (++n_asked_ > std::uint64_t{hierarchy_->head().shape.n_nodes} * kMaxBrought) return;
  NodePage::Links links = hierarchy_->links(index(node));
  links.skip_nodes(links.n_children());
  for (std::uint32_t k = links.n_parents(); k > 0; --k) out.push_back(NodeId{links.next_node()});
}

/// What the target has round it because of the node, and takes it away from there.
void TetraCut::take_region(std::uint32_t node, std::uint32_t target) {
  region_.clear();
  stars_.remove_if(target, [&](std::uint32_t slot) {
    const Cell& cell = cells_[slot];
    if (cell.maker != node) return false;
    const Tetrahedron& t = cell.corners;
    std::size_t at = 0;
    while (t[at] != target) ++at;
    const auto face = others(t, at);
    region_.push_back({face_key(face[0], face[1], face[2]), face, slot});
    return true;
  });
}

/// Edges of the faces across from the target that only one of them has.
void TetraCut::find_outline() {
  edges_.clear();
  for (const Coming& face : region_)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint64_t a = face.rest[k];
      const std::uint64_t b = face.rest[(k + 1) % 3];
      const auto reverse = std::ranges::find(edges_, a << 32 | b);
      if (reverse != edges_.end()) {
        *reverse = edges_.back();
        edges_.pop_back();
      } else {
        edges_.push_back(b << 32 | a);
      }
    }
  outline_.clear();
  for (const std::uint64_t edge : edges_) {
    const auto a = static_cast<std::uint32_t>(edge >> 32);
    const auto b = static_cast<std::uint32_t>(edge);
    outline_.push_back({face_key(a, b, kNone), {a, b, kNone}, kNone});
  }
}

std::uint32_t TetraCut::take_slot() {
  if (free_.empty()) {
    cells_.emplace_back();
    return static_cast<std::uint32_t>(cells_.size() - 1);
  }
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slot;
}

void TetraCut::place(std::uint32_t slot, const Cell& cell) {
  cells_[slot] = cell;
  for (const std::uint32_t v : cell.corners)
    if (v != outside_) stars_.add(v, slot);
}

/// Of the tetrahedra with an edge, once they are in their places.
void TetraCut::find_regions(NodePage::Links& links) {
  const bool is_stored = links.start_regions();
  std::uint32_t common = 0;
  for (const Coming& face : region_)
    if (is_inside(cells_[face.slot])) common = cells_[face.slot].region;
  for (const Coming& edge : outline_)
    cells_[edge.slot].region =
        is_stored ? std::min(links.next_region(), hierarchy_->head().shape.n_regions - 1) : common;
}

std::uint64_t TetraCut::apply(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  NodePage::Links links = hierarchy_->links(node);
  const std::uint32_t target = links.target();
  children_.clear();
  for (std::uint32_t k = links.n_children(); k > 0; --k) children_.push_back(links.next_node());
  children_.push_back(kNone);
  links.skip_nodes(links.n_parents());
  links.start_makers();
  const auto next_maker = [&] {
    return children_[std::min<std::size_t>(links.next_maker(), children_.size() - 1)];
  };
  n_asked_ = 0;
  take_region(node, target);
  find_outline();
  is_damaged_ = is_damaged_ || region_.empty() || region_.size() + outline_.size() > kMaxBrought;
  sort_by_key(region_);
  sort_by_key(outline_);
  for (const Coming& face : region_) {
    Cell& cell = cells_[face.slot];
    std::ranges::replace(cell.corners, target, vertex);
    cell.maker = next_maker();
    stars_.add(vertex, face.slot);
  }
  std::uint64_t n_new = 0;
  for (Coming& edge : outline_) {
    edge.slot = take_slot();
    place(edge.slot, {{vertex, edge.rest[0], edge.rest[1], target}, next_maker(), 0});
    if (edge.rest[0] != outside_ && edge.rest[1] != outside_) ++n_new;
  }
  if (hierarchy_->head().shape.n_regions > 1) find_regions(links);
  return n_new;
}

std::uint64_t TetraCut::undo(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  const std::uint32_t target = hierarchy_->links(node).target();
  std::uint64_t n_gone = 0;
  for (const std::uint32_t slot : stars_.of(vertex)) {
    Cell& cell = cells_[slot];
    if (std::ranges::find(cell.corners, target) == cell.corners.end()) {
      std::ranges::replace(cell.corners, vertex, target);
      cell.maker = node;
      continue;
    }
    bool is_outer = false;
    for (const std::uint32_t v : cell.corners) {
      is_outer = is_outer || v == outside_;
      if (v != vertex && v != outside_) stars_.remove(v, slot);
    }
    cell.corners[0] = kNone;
    free_.push_back(slot);
    if (!is_outer) ++n_gone;
  }
  const std::size_t n = stars_.of(vertex).size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t slot = stars_.of(vertex)[i];
    if (cells_[slot].corners[0] != kNone) stars_.add(target, slot);
  }
  stars_.end(vertex);
  return n_gone;
}

bool TetraCut::is_inside(const Cell& cell) const {
  const Tetrahedron& t = cell.corners;
  return t[0] != kNone && std::ranges::find(t, outside_) == t.end();
}

std::vector<Tetrahedron> TetraCut::cells() const {
  std::vector<Tetrahedron> cells;
  for (const Cell& cell : cells_)
    if (is_inside(cell)) cells.push_back(cell.corners);
  return cells;
}

Result<void> TetraCut::check() const {
  LODE_CHECK(hierarchy_->check());
  if (is_damaged_)
    return fail("hierarchy: expected nodes that replace tetrahedra of the mesh, got one of none");
  return {};
}

}  // namespace lode::tetra_mt
