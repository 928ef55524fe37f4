#include "lode/models/tetra_mt/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lode/models/tetra_mt/box_codes.h"
#include "lode/models/tetra_mt/live_tetrahedra.h"
#include "lode/models/tetra_mt/node_order.h"

namespace lode::tetra_mt {
namespace {

/// Above a double, even one that has been rounded itself.
float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
}

void grow(Box3d& box, const Box3d& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    box.lower[i] = std::min(box.lower[i], other.lower[i]);
    box.upper[i] = std::max(box.upper[i], other.upper[i]);
  }
}

/// Does the collapses again, with vertices numbered as the hierarchy does.
class HierarchyMaker {
 public:
  HierarchyMaker(const TetraMesh& mesh, const HalfEdgeCollapses& collapses)
      : mesh_(mesh), collapses_(collapses), numbers_(mesh.positions.size(), kNone) {}

  Result<Hierarchy> run(Threads threads) {
    number_vertices();
    std::vector<Tetrahedron> tetrahedra = mesh_.tetrahedra;
    for (Tetrahedron& t : tetrahedra)
      for (std::uint32_t& v : t) v = numbers_[v];
    LODE_CHECK(close_boundary(result_.outside(), tetrahedra, threads));
    makers_.assign(tetrahedra.size(), kNone);
    LiveTetrahedra live(result_.outside(), result_.outside(), std::move(tetrahedra));
    LODE_CHECK(collapse_again(live));
    take_base(live);
    find_parents();
    find_facts();
    find_boxes();
    return std::move(result_);
  }

 private:
  /// A tetrahedron that a node brings.
  struct Brought {
    bool has_target;
    FaceKey key;
    std::uint32_t maker;
    std::uint32_t slot;
  };

  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(collapses_.collapses.size());
  }
  void number_vertices();
  [[nodiscard]] Result<void> collapse_again(LiveTetrahedra& live);
  [[nodiscard]] Result<void> gather_brought(const LiveTetrahedra& live, std::uint32_t vertex,
                                            std::uint32_t target);
  /// Of a slot; kNone of tetrahedra to the vertex outside.
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const {
    return slot < mesh_.regions.size() ? mesh_.regions[slot] : kNone;
  }
  void note_regions();
  void note_node();
  void take_base(const LiveTetrahedra& live);
  void find_parents();
  void find_facts();
  void find_boxes();

  const TetraMesh& mesh_;
  const HalfEdgeCollapses& collapses_;
  std::vector<std::uint32_t> numbers_;  ///< Of the mesh's vertices in the hierarchy.
  std::vector<std::uint32_t> nodes_;    ///< By collapse.
  std::vector<std::uint32_t> makers_;   ///< By slot.
  std::vector<Box3d> boxes_;            ///< By node: of its tetrahedra, then of all it discovers.
  std::vector<Brought> brought_;
  Hierarchy result_;
};

void HierarchyMaker::number_vertices() {
  NodeOrder order = order_nodes(mesh_, collapses_.collapses);
  nodes_ = std::move(order.nodes);
  std::vector<std::uint32_t>& vertices = order.base_vertices;
  result_.n_base_vertices = static_cast<std::uint32_t>(vertices.size());
  vertices.resize(vertices.size() + nodes_.size());
  result_.order.resize(nodes_.size());
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    vertices[result_.n_base_vertices + nodes_[i]] = collapses_.collapses[i].removed;
    result_.order[nodes_.size() - 1 - i] = nodes_[i];
  }
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    numbers_[vertices[i]] = i;
    result_.positions.push_back(mesh_.positions[vertices[i]]);
  }
  result_.mesh_vertices = vertices;
  result_.region_ids = mesh_.region_ids;
  result_.boundary_deviation = collapses_.boundary_deviation;
  for (const MeshField& field : mesh_.fields) {
    MeshField& to = result_.fields.emplace_back(
        MeshField{.name = field.name, .type = field.type, .n_components = 1, .values = {}});
    for (const std::uint32_t v : vertices) to.values.push_back(field.values[v]);
  }
}

/// From lists in the order of the collapses to lists by node.
template <typename Item>
void sort_lists(std::span<const std::uint32_t> nodes, std::vector<std::uint64_t>& begins,
                std::vector<Item>& items) {
  const std::vector<std::uint64_t> old_begins = begins;
  const std::vector<Item> old = items;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    begins[nodes[i] + std::size_t{1}] = old_begins[i + 1] - old_begins[i];
  for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
  for (std::size_t i = 0; i < nodes.size(); ++i)
    std::copy(old.begin() + static_cast<std::ptrdiff_t>(old_begins[i]),
              old.begin() + static_cast<std::ptrdiff_t>(old_begins[i + 1]),
              items.begin() + static_cast<std::ptrdiff_t>(begins[nodes[i]]));
}

/// From the last node to the first one.
Result<void> HierarchyMaker::collapse_again(LiveTetrahedra& live) {
  result_.targets.resize(n_nodes());
  boxes_.resize(n_nodes());
  result_.child_begins.push_back(0);
  result_.maker_begins.push_back(0);
  result_.region_begins.push_back(0);
  for (std::uint32_t i = 0; i < n_nodes(); ++i) {
    const std::uint32_t node = nodes_[i];
    const std::uint32_t vertex = result_.n_base_vertices + node;
    const std::uint32_t target = numbers_[collapses_.collapses[i].kept];
    result_.targets[node] = target;
    LODE_CHECK(gather_brought(live, vertex, target));
    boxes_[node] = {result_.positions[vertex], result_.positions[vertex]};
    for (const std::uint32_t slot : live.star(vertex))
      for (const std::uint32_t v : live.corners(slot))
        if (v != live.outside()) grow(boxes_[node], {result_.positions[v], result_.positions[v]});
    for (const std::uint32_t slot : live.star(vertex)) makers_[slot] = node;
    note_regions();
    live.collapse(vertex, target);
    note_node();
  }
  sort_lists(nodes_, result_.child_begins, result_.children);
  sort_lists(nodes_, result_.maker_begins, result_.makers);
  sort_lists(nodes_, result_.region_begins, result_.regions);
  return {};
}

Result<void> HierarchyMaker::gather_brought(const LiveTetrahedra& live, std::uint32_t vertex,
                                            std::uint32_t target) {
  brought_.clear();
  for (const std::uint32_t slot : live.star(vertex)) {
    std::array<std::uint32_t, 3> rest{kNone, kNone, kNone};
    std::size_t n = 0;
    for (const std::uint32_t v : live.corners(slot))
      if (v != vertex && v != target) rest[n++] = v;
    brought_.push_back({n == 2, face_key(rest[0], rest[1], rest[2]), makers_[slot], slot});
  }
  std::ranges::sort(brought_, [](const Brought& a, const Brought& b) {
    return std::pair(a.has_target, a.key) < std::pair(b.has_target, b.key);
  });
  for (std::size_t i = 1; i < brought_.size(); ++i)
    if (brought_[i].key == brought_[i - 1].key)
      return fail("vertex {}: expected different tetrahedra, got two of the same corners", vertex);
  return {};
}

void HierarchyMaker::note_node() {
  const std::size_t first = result_.children.size();
  for (const Brought& b : brought_)
    if (b.maker != kNone) result_.children.push_back(b.maker);
  const auto begin = result_.children.begin() + static_cast<std::ptrdiff_t>(first);
  std::sort(begin, result_.children.end());
  result_.children.erase(std::unique(begin, result_.children.end()), result_.children.end());
  for (const Brought& b : brought_) {
    const auto at = std::lower_bound(begin, result_.children.end(), b.maker);
    result_.makers.push_back(b.maker == kNone ? Hierarchy::kReference
                                              : static_cast<std::uint8_t>(at - begin));
  }
  result_.child_begins.push_back(result_.children.size());
  result_.maker_begins.push_back(result_.makers.size());
}

/// A collapse leaves tetrahedra their slots, which are the mesh's: so their regions are known.
void HierarchyMaker::note_regions() {
  std::uint32_t common = kNone;  // of those with a face, which stay
  for (const Brought& b : brought_)
    if (!b.has_target && common == kNone) common = region(b.slot);
  const bool is_common = std::ranges::all_of(brought_, [&](const Brought& b) {
    return region(b.slot) == common || region(b.slot) == kNone;
  });
  if (!mesh_.regions.empty() && !is_common)
    for (const Brought& b : brought_)
      if (b.has_target) result_.regions.push_back(region(b.slot) == kNone ? 0 : region(b.slot));
  result_.region_begins.push_back(result_.regions.size());
}

void HierarchyMaker::take_base(const LiveTetrahedra& live) {
  for (std::uint32_t slot = 0; slot < live.n_slots(); ++slot) {
    if (live.is_gone(slot)) continue;
    const Tetrahedron& t = live.corners(slot);
    result_.base.push_back(t);
    result_.base_makers.push_back(makers_[slot]);
    if (result_.region_ids.size() > 1)
      result_.base_regions.push_back(region(slot) == kNone ? 0 : region(slot));
    if (std::ranges::find(t, live.outside()) == t.end()) ++result_.n_base_cells;
  }
}

void HierarchyMaker::find_parents() {
  auto& begins = result_.parent_begins;
  begins.assign(std::size_t{n_nodes()} + 1, 0);
  for (const std::uint32_t child : result_.children) ++begins[child + std::size_t{1}];
  for (std::size_t i = 1; i < begins.size(); ++i) begins[i] += begins[i - 1];
  std::vector<std::uint64_t> ends(begins.begin(), begins.end() - 1);
  result_.parents.resize(result_.children.size());
  for (std::uint32_t node = 0; node < n_nodes(); ++node)
    for (const std::uint32_t child : result_.children_of(node))
      result_.parents[ends[child]++] = node;
  result_.discoverers.assign(n_nodes(), kNone);
  for (const std::uint32_t node : result_.order)
    for (const std::uint32_t child : result_.children_of(node)) result_.discoverers[child] = node;
}

/// From the last node on each passes what it has to the one that discovers it.
void HierarchyMaker::find_facts() {
  const std::size_t n_fields = result_.fields.size();
  result_.facts.resize(n_nodes() * n_fields);
  for (const MeshField& field : mesh_.fields)
    result_.range_references.push_back(field.values.empty() ? 0 : std::ranges::min(field.values));
  for (std::uint32_t i = 0; i < n_nodes(); ++i)
    for (std::size_t f = 0; f < n_fields; ++f) {
      const std::uint32_t node = nodes_[i];
      const CollapseFacts& own = collapses_.facts[i * n_fields + f];
      const double reference = result_.range_references[f];
      StoredFacts& facts = result_.facts[node * n_fields + f];
      facts.error = own.error == 0 ? 0 : rounded_up(own.error);
      facts.low = -rounded_up(reference - own.low);
      facts.high = rounded_up(own.high - reference);
    }
  for (const std::uint32_t node : nodes_) {
    const std::uint32_t parent = result_.discoverers[node];
    if (parent == kNone) continue;
    for (std::size_t f = 0; f < n_fields; ++f) {
      StoredFacts& to = result_.facts[parent * n_fields + f];
      const StoredFacts& from = result_.facts[node * n_fields + f];
      to.error = std::max(to.error, from.error);
      to.low = std::min(to.low, from.low);
      to.high = std::max(to.high, from.high);
    }
  }
}

/// Boxes are joined as they will be known.
void HierarchyMaker::find_boxes() {
  Box3d all;
  if (!result_.positions.empty()) all = {result_.positions[0], result_.positions[0]};
  for (const Vec3d& p : result_.positions) grow(all, {p, p});
  const BoxCodes codes(all.lower, all.upper);
  result_.boxes.resize(n_nodes());
  for (const std::uint32_t node : nodes_) {
    const Vec3d& vertex = result_.positions[result_.n_base_vertices + node];
    result_.boxes[node] = codes.code(vertex, boxes_[node]);
    if (result_.discoverers[node] != kNone)
      grow(boxes_[result_.discoverers[node]], codes.box(vertex, result_.boxes[node]));
  }
}

}  // namespace

Result<Hierarchy> make_hierarchy(const TetraMesh& mesh, const HalfEdgeCollapses& collapses,
                                 Threads threads) {
  return HierarchyMaker(mesh, collapses).run(threads);
}

}  // namespace lode::tetra_mt
