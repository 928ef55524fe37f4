#include "lode/models/tetra_mt/tetra_cut.h"

#include <algorithm>

namespace lode::tetra_mt {
namespace {

/// Of the reference mesh with those to the vertex outside, about; whatever a file claims, no more
/// than its vertices may bring.
std::size_t n_slots_expected(const HierarchyHead& head) {
  constexpr std::uint64_t kMostOfNode = 8;
  const std::uint64_t n_more = std::min(head.n_cells - std::min(head.n_cells, head.n_base_cells),
                                        kMostOfNode * head.shape.n_nodes);
  return head.base.size() + n_more + n_more / 8;
}

}  // namespace

TetraCut::TetraCut(const PackedHierarchy& hierarchy, std::size_t field, WorldErrors world_errors)
    : hierarchy_(&hierarchy),
      field_(field),
      world_errors_(world_errors),
      outside_(hierarchy.head().outside()),
      slot_of_(hierarchy.head().shape.n_nodes + std::size_t{1}, kNone) {
  const HierarchyHead& head = hierarchy.head();
  const auto across = find_across(head.base);
  // Memory that nobody writes to costs nothing. What moves as it grows is cleared, written and read
  // again (decision 0030).
  cells_.reserve(n_slots_expected(head));
  makers_.reserve(n_slots_expected(head));
  for (std::uint32_t slot = 0; slot < head.base.size(); ++slot) {
    const std::uint32_t maker = head.base_makers[slot];
    cells_.push_back({head.base[slot], across[slot]});
    makers_.push_back(maker);
    if (maker != kNone) slot_of_[maker] = slot;
  }
  if (head.shape.n_labels == 1) return;
  regions_.reserve(n_slots_expected(head));
  regions_.resize(head.base.size(), 0);
  if (!head.base_regions.empty())
    std::copy_n(head.base_regions.begin(), head.base.size(), regions_.begin());
}

void TetraCut::add_base(std::vector<NodeId>& out) const {
  for (const std::uint32_t node : hierarchy_->head().roots) out.push_back(NodeId{node});
}

void TetraCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  if (const Read& known = reads_[index(node) % kReads]; known.node == index(node)) {
    for (std::uint32_t k = 0; k < known.n_discovered; ++k)
      out.push_back(NodeId{known.children.items[k]});
    return;
  }
  NodePage::Links links = hierarchy_->links(index(node));
  for (std::uint32_t k = links.n_discovered(); k > 0; --k) out.push_back(NodeId{links.next_node()});
}

/// A chain of nodes that wait for one another has no end, nor do those that ask for them.
void TetraCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  if (++n_asked_ > std::uint64_t{hierarchy_->head().shape.n_nodes} * kMaxBrought) return;
  for (const std::uint32_t parent : read(index(node)).parents) out.push_back(NodeId{parent});
}

/// Until others are read in its place.
const TetraCut::Read& TetraCut::read(std::uint32_t node) const {
  // Applying it begins there, and the memory answers while this is read.
  if (slot_of_[node] != kNone) fetch_beside(slot_of_[node]);
  Read& read = reads_[node % kReads];
  if (read.node == node) return read;
  NodePage::Links links = hierarchy_->links(node);
  read.node = node;
  read.n_discovered = links.n_discovered();
  const std::uint32_t n_children = links.n_children();
  for (std::uint32_t k = 0; k < n_children; ++k) read.children.items[k] = links.next_node();
  read.children.items[n_children] = kNone;
  read.children.n = n_children + std::size_t{1};
  read.parents.n = links.n_parents();
  for (std::size_t k = 0; k < read.parents.n; ++k) read.parents.items[k] = links.next_node();
  const auto place = links.target_parent();
  read.target = place ? head().shape.n_base_vertices + read.parents.items[*place] : links.target();
  links.start_makers();
  read.rest = links;
  return read;
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
