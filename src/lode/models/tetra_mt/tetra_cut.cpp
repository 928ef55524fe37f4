#include "lode/models/tetra_mt/tetra_cut.h"

#include <algorithm>
#include <utility>

namespace lode::tetra_mt {
namespace {

std::vector<std::uint32_t> count_base(const Hierarchy& hierarchy) {
  std::vector<std::uint32_t> counts(hierarchy.positions.size(), 0);
  for (const Tetrahedron& t : hierarchy.base)
    for (const std::uint32_t v : t)
      if (v != hierarchy.outside()) ++counts[v];
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

TetraCut::TetraCut(const Hierarchy& hierarchy, std::size_t field)
    : hierarchy_(&hierarchy),
      field_(field),
      tetrahedra_(hierarchy.base),
      makers_(hierarchy.base_makers),
      stars_(count_base(hierarchy)) {
  for (std::uint32_t slot = 0; slot < tetrahedra_.size(); ++slot)
    for (const std::uint32_t v : tetrahedra_[slot])
      if (v != hierarchy.outside()) stars_.add(v, slot);
}

void TetraCut::add_base(std::vector<NodeId>& out) const {
  for (std::uint32_t node = 0; node < hierarchy_->n_nodes(); ++node)
    if (hierarchy_->parents_of(node).empty()) out.push_back(NodeId{node});
}

void TetraCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  for (const std::uint32_t child : hierarchy_->children_of(index(node)))
    if (hierarchy_->parents_of(child).back() == index(node)) out.push_back(NodeId{child});
}

void TetraCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  for (const std::uint32_t parent : hierarchy_->parents_of(index(node)))
    out.push_back(NodeId{parent});
}

StoredFacts TetraCut::facts(NodeId node) const {
  return hierarchy_->facts[index(node) * hierarchy_->fields.size() + field_];
}

Ball TetraCut::bounds(NodeId node) const {
  return {hierarchy_->positions[hierarchy_->n_base_vertices + index(node)],
          static_cast<double>(hierarchy_->radii[index(node)])};
}

std::uint32_t TetraCut::maker(std::uint32_t node, std::size_t place) const {
  const std::uint8_t child = hierarchy_->makers_of(node)[place];
  return child == Hierarchy::kReference ? kNone : hierarchy_->children_of(node)[child];
}

/// What the target has round it because of the node, and takes it away from there.
void TetraCut::take_region(std::uint32_t node, std::uint32_t target) {
  region_.clear();
  stars_.remove_if(target, [&](std::uint32_t slot) {
    if (makers_[slot] != node) return false;
    const Tetrahedron& t = tetrahedra_[slot];
    std::size_t at = 0;
    while (t[at] != target) ++at;
    const auto face = others(t, at);
    region_.push_back({canonical_key(face[0], face[1], face[2]), face, slot});
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
    outline_.push_back({canonical_key(a, b, kNone), {a, b, kNone}, kNone});
  }
}

std::uint32_t TetraCut::take_slot() {
  if (free_.empty()) {
    tetrahedra_.push_back({kNone, kNone, kNone, kNone});
    makers_.push_back(kNone);
    return static_cast<std::uint32_t>(tetrahedra_.size() - 1);
  }
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slot;
}

void TetraCut::place(std::uint32_t slot, const Tetrahedron& corners, std::uint32_t maker) {
  tetrahedra_[slot] = corners;
  makers_[slot] = maker;
  for (const std::uint32_t v : corners)
    if (v != hierarchy_->outside()) stars_.add(v, slot);
}

std::uint64_t TetraCut::apply(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t target = hierarchy_->targets[node];
  const std::uint32_t vertex = hierarchy_->n_base_vertices + node;
  take_region(node, target);
  find_outline();
  sort_by_key(region_);
  sort_by_key(outline_);
  std::size_t n = 0;
  for (const Coming& face : region_) {
    std::ranges::replace(tetrahedra_[face.slot], target, vertex);
    makers_[face.slot] = maker(node, n++);
    stars_.add(vertex, face.slot);
  }
  std::uint64_t n_new = 0;
  for (const Coming& edge : outline_) {
    place(take_slot(), {vertex, edge.rest[0], edge.rest[1], target}, maker(node, n++));
    if (edge.rest[0] != hierarchy_->outside() && edge.rest[1] != hierarchy_->outside()) ++n_new;
  }
  return n_new;
}

std::uint64_t TetraCut::undo(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t target = hierarchy_->targets[node];
  const std::uint32_t vertex = hierarchy_->n_base_vertices + node;
  std::uint64_t n_gone = 0;
  for (const std::uint32_t slot : stars_.of(vertex)) {
    Tetrahedron& t = tetrahedra_[slot];
    if (std::ranges::find(t, target) != t.end()) {
      bool is_outer = false;
      for (const std::uint32_t v : t) {
        is_outer = is_outer || v == hierarchy_->outside();
        if (v != vertex && v != hierarchy_->outside()) stars_.remove(v, slot);
      }
      t[0] = kNone;
      free_.push_back(slot);
      if (!is_outer) ++n_gone;
    } else {
      std::ranges::replace(t, vertex, target);
      makers_[slot] = node;
    }
  }
  const std::size_t n = stars_.of(vertex).size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t slot = stars_.of(vertex)[i];
    if (tetrahedra_[slot][0] != kNone) stars_.add(target, slot);
  }
  stars_.end(vertex);
  return n_gone;
}

std::vector<Tetrahedron> TetraCut::cells() const {
  std::vector<Tetrahedron> cells;
  for (const Tetrahedron& t : tetrahedra_)
    if (t[0] != kNone && std::ranges::find(t, hierarchy_->outside()) == t.end()) cells.push_back(t);
  return cells;
}

}  // namespace lode::tetra_mt
