#include "lode/models/tetra_mt/tetra_cut.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lode::tetra_mt {
namespace {

/// Of those corners that are a vertex, a bit each.
unsigned places_of(const Tetrahedron& corners, std::uint32_t vertex) {
  unsigned places = 0;
  for (std::size_t i = 0; i < 4; ++i) places |= (corners[i] == vertex ? 1U : 0U) << i;
  return places;
}

/// The first of some; 0 of none.
std::uint32_t first_of(unsigned places) {
  return static_cast<std::uint32_t>(std::countr_zero(places | 16U)) & 3U;
}

/// Of the reference mesh with those to the vertex outside, about; whatever a file claims, no more
/// than its vertices may bring.
std::size_t n_slots_expected(const HierarchyHead& head) {
  constexpr std::uint64_t kMostOfNode = 8;
  const std::uint64_t n_more = std::min(head.n_cells - std::min(head.n_cells, head.n_base_cells),
                                        kMostOfNode * head.shape.n_nodes);
  return head.base.size() + n_more + n_more / 8;
}

}  // namespace

TetraCut::TetraCut(const PackedHierarchy& hierarchy, std::size_t field)
    : hierarchy_(&hierarchy),
      field_(field),
      outside_(hierarchy.head().outside()),
      slot_of_(hierarchy.head().shape.n_nodes, kNone) {
  const HierarchyHead& head = hierarchy.head();
  const auto across = find_across(head.base);
  // Memory that nobody writes to costs nothing. What moves as it grows is cleared, written and read
  // again (decision 0030).
  cells_.reserve(n_slots_expected(head));
  for (std::uint32_t slot = 0; slot < head.base.size(); ++slot) {
    const std::uint32_t region = head.base_regions.empty() ? 0 : head.base_regions[slot];
    const std::uint32_t maker = head.base_makers[slot];
    cells_.push_back({head.base[slot], across[slot], maker, region, 0, {}});
    if (maker != kNone) slot_of_[maker] = slot;
  }
}

void TetraCut::add_base(std::vector<NodeId>& out) const {
  for (const std::uint32_t node : hierarchy_->head().roots) out.push_back(NodeId{node});
}

void TetraCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  NodePage::Links links = links_of(index(node));
  for (std::uint32_t k = links.n_discovered(); k > 0; --k) out.push_back(NodeId{links.next_node()});
}

/// A chain of nodes that wait for one another has no end, nor do those that ask for them.
void TetraCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  if (++n_asked_ > std::uint64_t{hierarchy_->head().shape.n_nodes} * kMaxBrought) return;
  for (const std::uint32_t parent : read(index(node)).parents) out.push_back(NodeId{parent});
}

const TetraCut::Read& TetraCut::read(std::uint32_t node) const {
  if (read_.node == node) return read_;
  // Applying it begins there, and the memory answers while this is read.
  if (slot_of_[node] != kNone) fetch_beside(cells_[slot_of_[node]]);
  NodePage::Links links = links_of(node);
  read_.node = node;
  read_.children.resize(links.n_children() + std::size_t{1});
  for (std::uint32_t k = 0; k < links.n_children(); ++k) read_.children[k] = links.next_node();
  read_.children.back() = kNone;
  read_.parents.resize(links.n_parents());
  for (std::uint32_t& parent : read_.parents) parent = links.next_node();
  links.start_makers();
  read_.rest = links;
  return read_;
}

/// Among those in order so far. They are few.
void TetraCut::place_key(const FaceKey& key, std::size_t place) {
  const Placed one{key.first, std::uint64_t{key.last} << 32 | place};
  const auto is_after = [&one](const Placed& other) {
    return other.first > one.first || (other.first == one.first && other.last > one.last);
  };
  std::size_t at = order_.n++;
  for (; at > 0 && is_after(order_.items[at - 1]); --at) order_.items[at] = order_.items[at - 1];
  order_.items[at] = one;
}

void TetraCut::start_visit() {
  if (++n_visits_ != 0) return;
  for (Cell& cell : cells_) cell.visit = 0;
  n_visits_ = 1;
}

/// What is beside a slot, and will be looked at soon.
void TetraCut::fetch_beside(const Cell& cell) const {
  for (const std::uint32_t next : cell.across)
    __builtin_prefetch(&cells_[next == kNone ? 0 : next], 1);
}

/// Marks a slot as seen if it is one of those wanted. Returns whether it is for the first time.
bool TetraCut::visit(std::uint32_t slot, bool is_wanted) {
  Cell& cell = cells_[slot];
  const bool is_new = is_wanted && cell.visit != n_visits_;
  cell.visit = is_wanted ? n_visits_ : cell.visit;
  return is_new;
}

/// What the target has round it because of the node, from one to the next, and its outline. What
/// comes is written anyway, and counted if it counts: which it is no processor can guess.
void TetraCut::find_region(std::uint32_t node, std::uint32_t target) {
  start_visit();
  std::size_t n_region = 0;
  std::size_t n_outline = 0;
  const auto add = [&](std::uint32_t slot) {
    const Cell& cell = cells_[slot];
    const unsigned places = places_of(cell.corners, target);
    const bool is_of_node = cell.maker == node && places != 0;
    region_.items[n_region] = {slot, first_of(places)};
    const bool is_new = visit(slot, is_of_node);
    n_region += is_new ? 1 : 0;
    if (is_new) fetch_beside(cell);
    return is_of_node;
  };
  if (slot_of_[node] != kNone) add(slot_of_[node]);
  for (std::size_t i = 0; i < n_region && n_region + n_outline <= kMaxBrought; ++i) {
    const auto [slot, place] = region_.items[i];
    const Cell& cell = cells_[slot];
    const auto& at = kOtherPlaces[place];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t next = cell.across[at[k]];
      // A face has its edges turned one way, what is beyond them the other.
      outline_.items[n_outline] = {
          cell.corners[at[(k + 2) % 3]], cell.corners[at[(k + 1) % 3]], slot, at[k], next, kNone};
      n_outline += next == kNone || !add(next) ? 1 : 0;
    }
  }
  region_.n = n_region;
  outline_.n = n_outline;
}

std::uint32_t TetraCut::take_slot() {
  if (free_.empty()) {
    cells_.push_back({});
    return static_cast<std::uint32_t>(cells_.size() - 1);
  }
  const std::uint32_t slot = free_.back();
  free_.pop_back();
  return slot;
}

/// Where something is across, something else.
void TetraCut::set_across(std::uint32_t slot, std::uint32_t from, std::uint32_t to) {
  if (slot == kNone) return;
  for (std::uint32_t& next : cells_[slot].across) next = next == from ? to : next;
}

/// Between what is replaced, which has the vertex now, and what is beyond.
void TetraCut::place_edges(std::uint32_t vertex, std::uint32_t target) {
  for (const Placed& next : order_) {
    Edge& edge = outline_.items[static_cast<std::uint32_t>(next.last)];
    edge.slot = take_slot();
    Cell& cell = cells_[edge.slot];
    cell.corners = {vertex, edge.first, edge.second, target};
    cell.across = {edge.outer, kNone, kNone, edge.inner};
    cells_[edge.inner].across[edge.corner] = edge.slot;
    set_across(edge.outer, edge.inner, edge.slot);
  }
}

/// Those that come at edges, round the outline.
void TetraCut::join_edges() {
  for (const Edge& edge : outline_) {
    const auto* const next = std::find_if(outline_.begin(), outline_.end(), [&](const Edge& other) {
      return other.first == edge.second;
    });
    if (next == outline_.end()) {
      is_damaged_ = true;
      continue;
    }
    cells_[edge.slot].across[1] = next->slot;
    cells_[next->slot].across[2] = edge.slot;
  }
}

/// Of the tetrahedra with an edge, once they are in their places.
void TetraCut::find_regions(NodePage::Links& links) {
  const bool is_stored = links.start_regions();
  std::array<std::uint32_t, 2> common{};  // of those outside, and inside
  for (const Face& face : region_) {
    const Cell& cell = cells_[face.slot];
    common[is_inside(cell) ? 1 : 0] = cell.region;
  }
  const HierarchyHead& head = hierarchy_->head();
  const std::array<std::size_t, 2> last{head.patches.size(),
                                        std::max<std::size_t>(head.region_ids.size(), 1) - 1};
  for (const Placed& next : order_) {
    Cell& cell = cells_[outline_.items[static_cast<std::uint32_t>(next.last)].slot];
    const std::size_t side = is_inside(cell) ? 1 : 0;
    cell.region = is_stored ? std::min(links.next_region(), static_cast<std::uint32_t>(last[side]))
                            : common[side];
  }
}

std::uint64_t TetraCut::apply(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  const std::uint32_t target = links_of(node).target();
  const std::vector<std::uint32_t>& children = read(node).children;
  NodePage::Links links = *read_.rest;
  n_asked_ = 0;
  find_region(node, target);
  is_damaged_ = is_damaged_ || region_.is_empty() || region_.n + outline_.n > kMaxBrought;
  if (region_.is_empty()) return 0;
  const auto set_maker = [&](std::uint32_t slot) {
    const std::size_t place = std::min<std::size_t>(links.next_maker(), children.size() - 1);
    cells_[slot].maker = children[place];
    if (children[place] != kNone) slot_of_[children[place]] = slot;
  };
  order_.n = 0;
  for (std::size_t i = 0; i < region_.n; ++i) {
    const auto& [slot, place] = region_.items[i];
    const auto face = others(cells_[slot].corners, place);
    place_key(face_key(face[0], face[1], face[2]), i);
  }
  for (const Placed& next : order_) {
    const Face& face = region_.items[static_cast<std::uint32_t>(next.last)];
    cells_[face.slot].corners[face.place] = vertex;
    set_maker(face.slot);
  }
  order_.n = 0;
  for (std::size_t i = 0; i < outline_.n; ++i)
    place_key(face_key(outline_.items[i].first, outline_.items[i].second, kNone), i);
  place_edges(vertex, target);
  join_edges();
  std::uint64_t n_new = 0;
  for (const Placed& next : order_) {
    const Edge& edge = outline_.items[static_cast<std::uint32_t>(next.last)];
    set_maker(edge.slot);
    if (edge.first != outside_ && edge.second != outside_) ++n_new;
  }
  if (hierarchy_->head().shape.n_labels > 1) find_regions(links);
  slot_of_[node] = region_.items[0].slot;
  return n_new;
}

/// All that has a vertex, from one to the next.
void TetraCut::find_star(std::uint32_t slot, std::uint32_t vertex) {
  start_visit();
  region_.n = 0;
  const auto add = [&](std::uint32_t next) {
    const unsigned places = places_of(cells_[next].corners, vertex);
    region_.items[region_.n] = {next, first_of(places)};
    const bool is_new = visit(next, places != 0);
    region_.n += is_new ? 1 : 0;
    if (is_new) fetch_beside(cells_[next]);
  };
  if (slot != kNone) add(slot);
  for (std::size_t i = 0; i < region_.n && region_.n <= kMaxBrought; ++i) {
    const Cell& cell = cells_[region_.items[i].slot];
    for (const std::uint8_t k : kOtherPlaces[region_.items[i].place])
      if (cell.across[k] != kNone) add(cell.across[k]);
  }
}

std::uint64_t TetraCut::undo(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  const std::uint32_t target = links_of(node).target();
  find_star(slot_of_[node], vertex);
  gone_.n = 0;
  std::uint32_t left = kNone;
  for (const auto& [slot, place] : region_) {
    Cell& cell = cells_[slot];
    const unsigned of_target = places_of(cell.corners, target);
    gone_.items[gone_.n] = {slot, place, first_of(of_target)};
    gone_.n += of_target != 0 ? 1 : 0;
    cell.corners[place] = target;
    cell.maker = node;
    left = of_target != 0 ? left : slot;
  }
  slot_of_[node] = left;
  std::uint64_t n_inside = 0;
  for (const auto& [slot, of_vertex, of_target] : gone_) {
    Cell& cell = cells_[slot];
    const std::uint32_t inner = cell.across[of_target];
    const std::uint32_t outer = cell.across[of_vertex];
    set_across(inner, slot, outer);
    set_across(outer, slot, inner);
    n_inside += places_of(cell.corners, outside_) == 0 ? 1 : 0;
    cell.corners[0] = kNone;
    free_.push_back(slot);
  }
  return n_inside;
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
