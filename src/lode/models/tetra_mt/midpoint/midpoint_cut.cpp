#include "lode/models/tetra_mt/midpoint/midpoint_cut.h"

#include <algorithm>
#include <array>
#include <functional>

#include "lode/models/tetra_mt/region_masks.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// By place of the base's vertices; none yet for the others that there can be.
std::vector<std::uint32_t> count_corners(const ForestHead& head) {
  std::vector<std::uint32_t> counts(head.n_labels() + std::size_t{1}, 0);
  for (const Tetrahedron& t : head.base)
    for (const std::uint32_t v : t) ++counts[v];
  std::vector<std::uint32_t> by_place;
  for (const std::uint32_t root : head.roots) by_place.push_back(counts[root]);
  // One more while a node is undone.
  by_place.resize(std::max<std::size_t>(head.n_vertices, by_place.size()) + 1, 0);
  return by_place;
}

}  // namespace

MidpointCut::MidpointCut(const Forest& forest, std::size_t field, WorldErrors world_errors)
    : forest_(&forest),
      head_(&forest.head()),
      field_(field),
      world_errors_(world_errors),
      outside_(head_->outside()),
      n_inside_(head_->n_base_cells),
      places_(head_->n_labels(), kNone),
      stars_(count_corners(*head_)) {
  for (std::size_t i = 0; i < head_->roots.size(); ++i)
    add_vertex({head_->roots[i], kNone, forest.root_word(i, field), forest.root_code(i, field)});
  for (std::uint32_t slot = 0; slot < head_->base.size(); ++slot) {
    const std::uint32_t region = head_->base_regions.empty() ? 0 : head_->base_regions[slot];
    cells_.emplace_back();
    place(slot, {head_->base[slot], region});
  }
}

void MidpointCut::add_base(std::vector<NodeId>& out) const {
  for (const std::uint32_t root : head_->roots)
    if (!head_->is_leaf(root)) out.push_back(NodeId{root - head_->n_vertices});
}

void MidpointCut::add_children(NodeId node, std::vector<NodeId>& out) const {
  const auto [first, second] = forest_->children(index(node));
  for (const std::uint32_t child : {first, second})
    if (child != kNone && !head_->is_leaf(child)) out.push_back(NodeId{child - head_->n_vertices});
}

/// Calls visit(label), often more than once for the same.
template <typename Visit>
void MidpointCut::visit_beside(std::uint32_t label, const Visit& visit) const {
  for (const std::uint32_t slot : star(label))
    for (const std::uint32_t v : cells_[slot].corners)
      if (v != label && v != outside_) visit(v);
}

bool MidpointCut::is_star_within(std::uint32_t label, const Bounds& bounds) const {
  bool is_within = bounds.contains({position(label), 0});
  visit_beside(label, [&](std::uint32_t v) {
    is_within = is_within && bounds.contains({position(v), 0});
  });
  return is_within;
}

void MidpointCut::add_parents(NodeId node, std::vector<NodeId>& out) const {
  const std::uint32_t label = label_of(node);
  const auto begin = static_cast<std::ptrdiff_t>(out.size());
  const auto add = [&](std::uint32_t v) {
    if (v != kNone) out.push_back(NodeId{v - head_->n_vertices});
  };
  if (!has_vertex(label)) return add(forest_->parent(index(node)));
  const auto add_parent = [&](std::uint32_t v) { add(vertices_[places_[v]].parent); };
  visit_beside(label, [&](std::uint32_t v) {
    if (v > label) add(v);
  });
  if (out.begin() + begin == out.end()) {
    add_parent(label);
    visit_beside(label, add_parent);
  }
  std::sort(out.begin() + begin, out.end());
  out.erase(std::unique(out.begin() + begin, out.end()), out.end());
}

std::uint32_t MidpointCut::word_of(NodeId node) const {
  const std::uint32_t label = label_of(node);
  return has_vertex(label) ? vertices_[places_[label]].facts : forest_->facts(index(node), field_);
}

Bounds MidpointCut::bounds(NodeId node) const {
  const std::uint32_t label = label_of(node);
  const Code code =
      has_vertex(label) ? vertices_[places_[label]].code : forest_->code_of(index(node), field_);
  return {head_->scales.position(code),
          head_->radii.radius(NodeCodes::parts(word_of(node)).radius)};
}

std::uint64_t MidpointCut::regions_round(std::uint32_t label) const {
  std::uint64_t mask = 0;
  for (const std::uint32_t slot : star(label))
    if (is_inside(cells_[slot])) mask |= region_bit(cells_[slot].region);
  return mask;
}

/// Of one that is not in the mesh what it came of says, which has more perhaps, or all that it has
/// become.
std::uint64_t MidpointCut::region_mask(NodeId node) const {
  if (head_->region_ids.size() <= 1) return kAllRegions;
  for (std::uint32_t at = label_of(node); at != kNone; at = forest_->parent(at - head_->n_vertices))
    if (has_vertex(at)) return regions_round(at);
  std::uint64_t mask = 0;
  std::vector<std::uint32_t> open{label_of(node)};
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    open.pop_back();
    if (at == kNone) continue;
    if (has_vertex(at)) {
      mask |= regions_round(at);
    } else if (!head_->is_leaf(at)) {
      const auto [first, second] = forest_->children(at - head_->n_vertices);
      open.insert(open.end(), {first, second});
    }
  }
  return mask;
}

StoredFacts MidpointCut::facts(NodeId node, std::size_t field) const {
  if (field == field_) return facts(node);
  const std::uint32_t word = forest_->facts(index(node), field);
  return head_->fields[field].codes.facts(NodeCodes::parts(word));
}

/// Of vertices of the mesh all that were split, descending.
std::vector<std::uint32_t> MidpointCut::ancestors_of(std::span<const std::uint32_t> labels) const {
  std::vector<bool> is_known(head_->n_labels(), false);
  std::vector<std::uint32_t> found;
  for (const std::uint32_t label : labels) {
    std::uint32_t at = vertices_[places_[label]].parent;
    while (at != kNone && !is_known[at]) {
      is_known[at] = true;
      found.push_back(at);
      at = forest_->parent(at - head_->n_vertices);
    }
  }
  std::ranges::sort(found, std::greater());
  return found;
}

Result<std::vector<double>> MidpointCut::values(std::span<const std::uint32_t> labels,
                                                std::size_t field) const {
  std::vector<std::int32_t> codes(head_->n_labels(), 0);
  for (std::size_t i = 0; i < head_->roots.size(); ++i)
    codes[head_->roots[i]] = forest_->root_code(i, field)[3];
  for (const std::uint32_t label : ancestors_of(labels)) {
    const Split split = forest_->split(label - head_->n_vertices, field);
    if (split.children.first == kNone) break;  // check() says why
    const EndNumbers ends = parted(codes[label], split.difference[3], split.placement.value);
    codes[split.children.first] = ends.first;
    codes[split.children.second] = ends.second;
  }
  LODE_CHECK(check());
  std::vector<double> found;
  found.reserve(labels.size());
  for (const std::uint32_t label : labels) {
    if (codes[label] < 0)
      return fail("midpoints: expected values of {} of 31 bits, got {}", head_->fields[field].name,
                  codes[label]);
    found.push_back(forest_->value(label, {0, 0, 0, codes[label]}, field));
  }
  LODE_CHECK(check());
  return found;
}

void MidpointCut::add_vertex(const Vertex& vertex) {
  std::uint32_t at = static_cast<std::uint32_t>(vertices_.size());
  if (free_vertices_.empty()) {
    vertices_.emplace_back();
  } else {
    at = free_vertices_.back();
    free_vertices_.pop_back();
  }
  vertices_[at] = vertex;
  places_[vertex.label] = at;
}

void MidpointCut::end_vertex(std::uint32_t label) {
  stars_.end(places_[label]);
  free_vertices_.push_back(places_[label]);
  places_[label] = kNone;
}

std::uint32_t MidpointCut::take_slot() {
  if (free_cells_.empty()) {
    cells_.emplace_back();
    return static_cast<std::uint32_t>(cells_.size() - 1);
  }
  const std::uint32_t slot = free_cells_.back();
  free_cells_.pop_back();
  return slot;
}

void MidpointCut::place(std::uint32_t slot, const Cell& cell) {
  cells_[slot] = cell;
  for (const std::uint32_t v : cell.corners)
    if (v != outside_) stars_.add(places_[v], slot);
}

/// The tetrahedra round a vertex in their order, each with the end that it goes to.
void MidpointCut::take_star(std::uint32_t label, std::uint64_t mask) {
  star_.clear();
  for (const std::uint32_t slot : star(label)) {
    const Tetrahedron& t = cells_[slot].corners;
    std::size_t at = 0;
    while (t[at] != label) ++at;
    const auto face = others(t, at);
    star_.push_back({star_key(face), face, slot, false});
  }
  sort_star(star_);
  for (std::size_t i = 0; i < star_.size() && i < kMaxStar; ++i)
    star_[i].is_second = (mask >> i & 1) != 0;
}

/// The faces at the vertex that lie between tetrahedra of both ends, by the edges across from it.
void MidpointCut::find_edges() {
  between_.clear();
  for (const StarTriangle& t : star_) {
    if (t.is_second) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t.corners[k];
      const std::uint32_t b = t.corners[(k + 1) % 3];
      between_.push_back({edge_key(a, b), a, b, kNone});
    }
  }
  // Edges of two of the first end's go, those of one are the outline.
  std::ranges::sort(between_, {}, &Between::key);
  std::size_t n = 0;
  for (std::size_t i = 0; i < between_.size(); ++i) {
    if (i + 1 < between_.size() && between_[i].key == between_[i + 1].key) {
      ++i;
    } else {
      between_[n++] = between_[i];
    }
  }
  between_.resize(n);
}

/// What a hierarchy's splits all are; a file's may be others.
bool MidpointCut::may_apply(std::uint32_t label, const Split& split) {
  const auto [first, second] = split.children;
  if (first == kNone || !has_vertex(label) || has_vertex(first) || has_vertex(second)) return false;
  const std::size_t n_first =
      static_cast<std::size_t>(std::ranges::count(star_, false, &StarTriangle::is_second));
  // No tetrahedron is without a place, and the outline is that of a disc.
  return star_.size() <= kMaxStar && between_.size() <= n_first + 2 &&
         (split.regions.empty() || split.regions.size() == between_.size());
}

/// Of a cell that comes: what is no region, or no patch, is none of a hierarchy's.
std::uint32_t MidpointCut::region_within(const Cell& cell) const {
  const std::size_t n = is_inside(cell) ? std::max<std::size_t>(head_->region_ids.size(), 1)
                                        : head_->patches.size() + 1;
  return cell.region < n ? cell.region : kNone;
}

std::uint64_t MidpointCut::apply(NodeId id) {
  const std::uint32_t label = label_of(id);
  const Split split = forest_->split(index(id), field_);
  if (!has_vertex(label) || split.children.first == kNone) {
    is_damaged_ = true;
    return 0;
  }
  const auto [first, second] = split.children;
  take_star(label, split.mask);
  find_edges();
  const Vertex vertex = vertices_[places_[label]];
  const Ends ends = parted(vertex.code, split.difference, split.placement);
  const bool is_right = may_apply(label, split) && vertex.parent == forest_->parent(index(id)) &&
                        std::ranges::min(ends.first) >= 0 && std::ranges::min(ends.second) >= 0;
  if (!is_right) {
    is_damaged_ = true;
    return 0;
  }
  end_vertex(label);
  add_vertex({first, label, split.child_facts[0], ends.first});
  add_vertex({second, label, split.child_facts[1], ends.second});
  std::array<std::uint32_t, 2> common{};  // of those outside, and inside
  for (const StarTriangle& t : star_) {
    Cell& cell = cells_[t.slot];
    const std::uint32_t end = t.is_second ? second : first;
    std::ranges::replace(cell.corners, label, end);
    stars_.add(places_[end], t.slot);
    common[is_inside(cell) ? 1 : 0] = cell.region;
  }
  std::uint64_t n_inside = 0;
  for (std::size_t i = 0; i < between_.size(); ++i) {
    const Between& edge = between_[i];
    Cell cell{{first, edge.b, edge.a, second}, 0};
    cell.region = i < split.regions.size() ? split.regions[i] : common[is_inside(cell) ? 1 : 0];
    if (region_within(cell) == kNone) {
      is_damaged_ = true;
      cell.region = 0;
    }
    place(take_slot(), cell);
    if (is_inside(cell)) ++n_inside;
  }
  n_inside_ += n_inside;
  is_damaged_ = is_damaged_ || n_inside_ > head_->n_cells;
  return n_inside;
}

std::uint64_t MidpointCut::undo(NodeId id) {
  const std::uint32_t label = label_of(id);
  const Split split = forest_->split(index(id), field_);
  const auto [first, second] = split.children;
  if (first == kNone || has_vertex(label) || !has_vertex(first) || !has_vertex(second)) {
    is_damaged_ = true;
    return 0;
  }
  const Code code =
      merged(vertices_[places_[first]].code, vertices_[places_[second]].code, split.placement);
  add_vertex({label, forest_->parent(index(id)), forest_->facts(index(id), field_), code});
  std::uint64_t n_gone = 0;
  for (const std::uint32_t end : {first, second}) {
    const std::uint32_t other = end == first ? second : first;
    for (const std::uint32_t slot : star(end)) {
      Cell& cell = cells_[slot];
      if (std::ranges::find(cell.corners, other) == cell.corners.end()) {
        std::ranges::replace(cell.corners, end, label);
        continue;
      }
      if (is_inside(cell)) ++n_gone;
      for (const std::uint32_t v : cell.corners)
        if (v != end && v != outside_) stars_.remove(places_[v], slot);
      cell.corners[0] = kNone;
      free_cells_.push_back(slot);
    }
    const std::size_t n = star(end).size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t slot = star(end)[i];
      if (cells_[slot].corners[0] != kNone) stars_.add(places_[label], slot);
    }
    end_vertex(end);
  }
  n_inside_ -= n_gone;
  return n_gone;
}

bool MidpointCut::may_split(NodeId node) const {
  const std::uint32_t label = label_of(node);
  if (!has_vertex(label)) return false;
  bool may = true;
  visit_beside(label, [&](std::uint32_t v) { may = may && v < label; });
  return may;
}

bool MidpointCut::may_collapse(NodeId node) const {
  const std::uint32_t label = label_of(node);
  const Children ends = forest_->children(index(node));
  if (ends.first == kNone || !has_vertex(ends.first) || !has_vertex(ends.second)) return false;
  bool is_edge = false;
  bool may = true;
  const auto look_at = [&](std::uint32_t v) {
    is_edge = is_edge || v == ends.second;
    may = may && vertices_[places_[v]].parent >= label;  // kNone is above all
  };
  visit_beside(ends.first, look_at);
  visit_beside(ends.second, look_at);
  return is_edge && may;
}

Result<void> MidpointCut::check() const {
  LODE_CHECK(forest_->check());
  if (is_damaged_) return fail("midpoints: expected nodes that fit together, got others");
  return {};
}

bool MidpointCut::is_inside(const Cell& cell) const {
  const Tetrahedron& t = cell.corners;
  return t[0] != kNone && std::ranges::find(t, outside_) == t.end();
}

std::vector<Tetrahedron> MidpointCut::cells() const {
  std::vector<Tetrahedron> cells;
  for (const Cell& cell : cells_)
    if (is_inside(cell)) cells.push_back(cell.corners);
  return cells;
}

std::uint32_t MidpointCut::maker(const Cell& cell) const {
  const std::uint32_t last = std::ranges::max(cell.corners);
  return head_->is_leaf(last) ? kNone : last - head_->n_vertices;
}

}  // namespace lode::tetra_mt::midpoint
