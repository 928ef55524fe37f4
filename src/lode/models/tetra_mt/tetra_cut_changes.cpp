// How a cut changes: one node applied or undone.
#include <algorithm>
#include <bit>
#include <cstring>

#include "lode/models/tetra_mt/region_masks.h"
#include "lode/models/tetra_mt/tetra_cut.h"

namespace lode::tetra_mt {
namespace {

using FourNumbers = std::uint32_t __attribute__((vector_size(16)));

/// The maker of what a walk has come to.
constexpr std::uint32_t kOnWalk = kNone - 1;

/// Of its corners that are a vertex, a bit each.
unsigned places_of(const Tetrahedron& corners, std::uint32_t vertex) {
  unsigned places = 0;
  for (std::size_t i = 0; i < 4; ++i) places |= (corners[i] == vertex ? 1U : 0U) << i;
  return places;
}

/// Where one number is among four, another one.
void replace(std::array<std::uint32_t, 4>& numbers, std::uint32_t from, std::uint32_t to) {
  FourNumbers four;
  std::memcpy(&four, numbers.data(), sizeof four);
  const auto is_old = FourNumbers(four == FourNumbers{from, from, from, from});
  four = (four & ~is_old) | (FourNumbers{to, to, to, to} & is_old);
  std::memcpy(numbers.data(), &four, sizeof four);
}

std::uint32_t next_of(std::uint32_t k) { return k < 2 ? k + 1 : 0; }

/// The first of some; 0 of none.
std::uint32_t first_of(unsigned places) {
  return static_cast<std::uint32_t>(std::countr_zero(places | 16U)) & 3U;
}

}  // namespace

/// What is beside a slot, and will be looked at soon.
void TetraCut::fetch_beside(std::uint32_t slot) const {
  for (const std::uint32_t next : cells_[slot].across) {
    __builtin_prefetch(&makers_[next == kNone ? slot : next], 1);
    __builtin_prefetch(&cells_[next == kNone ? slot : next], 1);
  }
}

/// What the target has round it because of the node, from one to the next, and its outline. What
/// comes is written anyway, and counted if it counts: which it is no processor can guess. Those
/// seen are of kOnWalk until they get their makers.
void TetraCut::find_region(std::uint32_t node, std::uint32_t target) {
  std::size_t n_region = 0;
  std::size_t n_outline = 0;
  const auto add = [&](std::uint32_t slot) {
    const std::uint32_t maker = makers_[slot];
    region_.items[n_region].slot = slot;
    n_region += static_cast<std::size_t>(maker == node);
    makers_[slot] = maker == node ? kOnWalk : maker;
    return (maker == node) | (maker == kOnWalk);
  };
  if (slot_of_[node] != kNone) add(slot_of_[node]);
  std::size_t i = 0;
  for (; i < n_region && n_region + n_outline <= kMaxBrought; ++i) {
    const std::uint32_t slot = region_.items[i].slot;
    const Cell& cell = cells_[slot];
    const unsigned places = places_of(cell.corners, target);
    is_damaged_ = is_damaged_ | (places == 0);
    const std::uint32_t place = first_of(places);
    region_.items[i].place = place;
    const auto& at = kOtherPlaces[place];
    place_face(i, cell.corners[at[0]], cell.corners[at[1]], cell.corners[at[2]]);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t next = cell.across[at[k]];
      sides_.items[n_outline] = {slot, static_cast<std::uint16_t>(place),
                                 static_cast<std::uint16_t>(k)};
      // This one is no new one.
      const bool is_of_node = add(next == kNone ? slot : next) & (next != kNone);
      n_outline += static_cast<std::size_t>(!is_of_node);
    }
    fetch_beside(region_.items[std::min(i + 2, n_region - 1)].slot);
  }
  region_.n = n_region;
  sides_.n = n_outline;
  is_damaged_ = is_damaged_ || n_region == 0 || n_region + n_outline > kMaxBrought;
  if (i == n_region) return;
  // Too many: what has been seen is as it was.
  for (const Face& face : region_) makers_[face.slot] = node;
  region_.n = 0;
}

/// What is at the outline.
void TetraCut::find_outline() {
  outline_.n = 0;
  for (const auto& [slot, place, k] : sides_) {
    const Cell& cell = cells_[slot];
    const auto& at = kOtherPlaces[place];
    // A face has its edges turned one way, what is beyond them the other.
    const std::uint32_t first = cell.corners[at[next_of(next_of(k))]];
    const std::uint32_t second = cell.corners[at[next_of(k)]];
    edges_.set_key(outline_.n, {std::min(first, second), std::max(first, second), 0});
    outline_.items[outline_.n++] = {first, second, slot, at[k], cell.across[at[k]], kNone};
  }
}

/// For what comes at edges.
void TetraCut::take_slots() {
  taken_.n = outline_.n;
  std::size_t n = 0;
  for (; n < taken_.n && !free_.empty(); ++n) {
    taken_.items[n] = free_.back();
    free_.pop_back();
  }
  const std::size_t n_slots = cells_.size();
  cells_.resize(n_slots + taken_.n - n);
  makers_.resize(cells_.size());
  if (!regions_.empty()) regions_.resize(cells_.size());
  for (std::size_t slot = n_slots; n < taken_.n; ++n, ++slot)
    taken_.items[n] = static_cast<std::uint32_t>(slot);
}

/// Where something is across, something else.
void TetraCut::set_across(std::uint32_t slot, std::uint32_t from, std::uint32_t to) {
  if (slot != kNone) replace(cells_[slot].across, from, to);
}

void TetraCut::place_face(std::size_t i, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::uint32_t low = std::min(a, b);
  const std::uint32_t high = std::max(a, b);
  faces_.set_key(i, {std::min(low, c), std::min(high, std::max(low, c)), std::max(high, c)});
}

/// Of what is replaced and what comes at edges, by vertices.
void TetraCut::find_orders() {
  bool differ = faces_.find_ranks(region_.n);
  differ = edges_.find_ranks(outline_.n) && differ;
  is_damaged_ = is_damaged_ || !differ;
}

void TetraCut::read_makers(const Read& read) {
  brought_.n = region_.n + outline_.n;
  const auto last = static_cast<std::uint32_t>(read.children.n - 1);
  rest_ = read.rest;
  // How many there are to be the mesh says, not the file.
  if (!rest_->have_makers(brought_.n)) {
    is_damaged_ = true;
    std::fill_n(brought_.items.begin(), brought_.n, kNone);
    return;
  }
  for (std::size_t i = 0; i < brought_.n; ++i)
    brought_.items[i] = read.children.items[std::min(rest_->next_maker(), last)];
}

/// `rank`: in the order of makers.
void TetraCut::set_maker(std::uint32_t slot, std::uint32_t rank) {
  const std::uint32_t maker = brought_.items[rank];
  makers_[slot] = maker;
  slot_of_[std::min<std::size_t>(maker, slot_of_.size() - 1)] = slot;
}

/// Between what is replaced, which has the vertex now, and what is beyond.
void TetraCut::place_edges(std::uint32_t vertex, std::uint32_t target) {
  for (std::size_t i = 0; i < outline_.n; ++i) {
    Edge& edge = outline_.items[i];
    const std::uint32_t rank = edges_.rank(i);
    edge.slot = taken_.items[rank];
    Cell& cell = cells_[edge.slot];
    cell.corners = {vertex, edge.first, edge.second, target};
    cell.across = {edge.outer, kNone, kNone, edge.inner};
    set_maker(edge.slot, static_cast<std::uint32_t>(region_.n) + rank);
    cells_[edge.inner].across[edge.corner] = edge.slot;
    set_across(edge.outer, edge.inner, edge.slot);
  }
}

/// The place of the edge that begins where one ends; outline_.n where there is none.
std::size_t TetraCut::edge_after(const Edge& edge) const {
  const auto begins_there = [&](const Edge& other) { return other.first == edge.second; };
  const std::size_t guess = edge_at_[edge.second % edge_at_.size()];
  if (guess < outline_.n && begins_there(outline_.items[guess])) return guess;
  return static_cast<std::size_t>(std::find_if(outline_.begin(), outline_.end(), begins_there) -
                                  outline_.begin());
}

/// Those that come at edges, round the outline.
void TetraCut::join_edges() {
  for (std::size_t i = 0; i < outline_.n; ++i)
    edge_at_[outline_.items[i].first % edge_at_.size()] = static_cast<std::uint8_t>(i);
  for (const Edge& edge : outline_) {
    const std::size_t next = edge_after(edge);
    if (next == outline_.n) {
      is_damaged_ = true;
      continue;
    }
    cells_[edge.slot].across[1] = outline_.items[next].slot;
    cells_[outline_.items[next].slot].across[2] = edge.slot;
  }
}

/// Of the tetrahedra with an edge, once they are in their places.
void TetraCut::find_regions() {
  NodePage::Links& links = *rest_;
  bool is_stored = links.start_regions();
  if (is_stored && !links.have_regions(taken_.n)) {
    is_damaged_ = true;
    is_stored = false;
  }
  std::array<std::uint32_t, 2> common{};  // of those outside, and inside
  for (const Face& face : region_) {
    common[is_inside(cells_[face.slot]) ? 1 : 0] = regions_[face.slot];
  }
  const HierarchyHead& head = hierarchy_->head();
  const std::array<std::size_t, 2> last{head.patches.size(),
                                        std::max<std::size_t>(head.region_ids.size(), 1) - 1};
  for (const std::uint32_t slot : taken_) {
    const std::size_t side = is_inside(cells_[slot]) ? 1 : 0;
    regions_[slot] = is_stored
                         ? std::min(links.next_region(), static_cast<std::uint32_t>(last[side]))
                         : common[side];
  }
}

std::uint64_t TetraCut::apply(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  const Read& read = this->read(node);
  const std::uint32_t target = read.target;
  n_asked_ = 0;
  find_region(node, target);
  if (region_.is_empty()) return 0;
  find_outline();
  find_orders();
  read_makers(read);
  for (std::size_t i = 0; i < region_.n; ++i) {
    const auto& [slot, place] = region_.items[i];
    cells_[slot].corners[place] = vertex;
    set_maker(slot, faces_.rank(i));
  }
  take_slots();
  place_edges(vertex, target);
  join_edges();
  if (hierarchy_->head().shape.n_labels > 1) find_regions();
  slot_of_[node] = region_.items[0].slot;
  std::uint64_t n_new = 0;
  for (const Edge& edge : outline_)
    n_new += static_cast<std::uint64_t>((edge.first != outside_) & (edge.second != outside_));
  return n_new;
}

std::uint64_t TetraCut::regions_brought() const {
  std::uint64_t mask = 0;
  const auto add = [&](std::uint32_t slot) {
    if (is_inside(cells_[slot])) mask |= region_bit(region(slot));
  };
  for (const Face& face : region_) add(face.slot);
  for (const std::uint32_t slot : taken_) add(slot);
  return mask;
}

/// All that has a vertex, from one to the next: what is across from other corners has it, too.
/// They are of kOnWalk then.
void TetraCut::find_star(std::uint32_t slot, std::uint32_t vertex) {
  std::size_t n = 0;
  const auto add = [&](std::uint32_t next) {
    region_.items[n].slot = next;
    n += static_cast<std::size_t>(makers_[next] != kOnWalk);
    makers_[next] = kOnWalk;
  };
  if (slot != kNone) add(slot);
  std::size_t i = 0;
  for (; i < n && n <= kMaxBrought; ++i) {
    const std::uint32_t at = region_.items[i].slot;
    const Cell& cell = cells_[at];
    const std::uint32_t place = first_of(places_of(cell.corners, vertex));
    region_.items[i].place = place;
    for (const std::uint8_t k : kOtherPlaces[place])
      add(cell.across[k] == kNone ? at : cell.across[k]);
    fetch_beside(region_.items[std::min(i + 2, n - 1)].slot);
  }
  region_.n = i;
  is_damaged_ = is_damaged_ || i < n;
  for (; i < n; ++i) makers_[region_.items[i].slot] = kNone;
}

std::uint64_t TetraCut::undo(NodeId id) {
  const std::uint32_t node = index(id);
  const std::uint32_t vertex = hierarchy_->head().shape.n_base_vertices + node;
  const std::uint32_t target = hierarchy_->links(node).target();
  find_star(slot_of_[node], vertex);
  gone_.n = 0;
  std::uint32_t left = kNone;
  for (const auto& [slot, place] : region_) {
    Cell& cell = cells_[slot];
    const unsigned of_target = places_of(cell.corners, target);
    gone_.items[gone_.n] = {slot, place, first_of(of_target)};
    gone_.n += of_target != 0 ? 1 : 0;
    cell.corners[place] = target;
    makers_[slot] = node;
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

}  // namespace lode::tetra_mt
