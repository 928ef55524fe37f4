#include "lode/models/tetra_mt/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "lode/models/tetra_mt/live_tetrahedra.h"

namespace lode::tetra_mt {
namespace {

/// Above a double, even one that has been rounded itself.
float rounded_up(double x) {
  return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity());
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
    return std::move(result_);
  }

 private:
  /// A tetrahedron that a node brings.
  struct Brought {
    bool has_target;
    std::uint64_t key;
    std::uint32_t maker;
  };

  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(collapses_.collapses.size());
  }
  void number_vertices();
  [[nodiscard]] Result<void> collapse_again(LiveTetrahedra& live);
  [[nodiscard]] Result<void> gather_brought(const LiveTetrahedra& live, std::uint32_t vertex,
                                            std::uint32_t target);
  void note_node();
  void take_base(const LiveTetrahedra& live);
  void find_parents();
  void find_facts();

  const TetraMesh& mesh_;
  const HalfEdgeCollapses& collapses_;
  std::vector<std::uint32_t> numbers_;  ///< Of the mesh's vertices in the hierarchy.
  std::vector<std::uint32_t> makers_;   ///< By slot.
  std::vector<Brought> brought_;
  Hierarchy result_;
};

/// Those of the base as the mesh has them, then those of the nodes; unused ones nowhere.
void HierarchyMaker::number_vertices() {
  std::vector<std::uint8_t> is_used(numbers_.size(), 0);
  for (const Tetrahedron& t : mesh_.tetrahedra)
    for (const std::uint32_t v : t) is_used[v] = 1;
  for (const Collapse& c : collapses_.collapses) is_used[c.removed] = 0;
  std::vector<std::uint32_t> order;
  for (std::uint32_t v = 0; v < numbers_.size(); ++v)
    if (is_used[v] != 0) order.push_back(v);
  result_.n_base_vertices = static_cast<std::uint32_t>(order.size());
  for (std::size_t i = collapses_.collapses.size(); i-- > 0;)
    order.push_back(collapses_.collapses[i].removed);
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    numbers_[order[i]] = i;
    result_.positions.push_back(mesh_.positions[order[i]]);
  }
  for (const MeshField& field : mesh_.fields) {
    MeshField& to = result_.fields.emplace_back(
        MeshField{.name = field.name, .type = field.type, .n_components = 1, .values = {}});
    for (const std::uint32_t v : order) to.values.push_back(field.values[v]);
  }
}

/// From the last node to the first one.
Result<void> HierarchyMaker::collapse_again(LiveTetrahedra& live) {
  result_.targets.resize(n_nodes());
  result_.radii.resize(n_nodes());
  result_.child_begins.push_back(0);
  result_.maker_begins.push_back(0);
  for (std::uint32_t i = 0; i < n_nodes(); ++i) {
    const std::uint32_t node = n_nodes() - 1 - i;
    const std::uint32_t vertex = result_.n_base_vertices + node;
    const std::uint32_t target = numbers_[collapses_.collapses[i].kept];
    result_.targets[node] = target;
    LODE_CHECK(gather_brought(live, vertex, target));
    double radius = 0;
    for (const std::uint32_t slot : live.star(vertex))
      for (const std::uint32_t v : live.corners(slot))
        if (v != live.outside())
          radius = std::max(radius, length(result_.positions[v] - result_.positions[vertex]));
    result_.radii[node] = std::nextafter(static_cast<float>(radius), INFINITY);
    for (const std::uint32_t slot : live.star(vertex)) makers_[slot] = node;
    live.collapse(vertex, target);
    note_node();
  }
  // They came in the order of the collapses.
  const auto reverse = [](std::vector<std::uint64_t>& begins, auto& items) {
    const auto old = items;
    std::vector<std::uint64_t> forward{0};
    std::size_t at = 0;
    for (std::size_t i = begins.size() - 1; i-- > 0;) {
      std::copy(old.begin() + static_cast<std::ptrdiff_t>(begins[i]),
                old.begin() + static_cast<std::ptrdiff_t>(begins[i + 1]),
                items.begin() + static_cast<std::ptrdiff_t>(at));
      at += begins[i + 1] - begins[i];
      forward.push_back(at);
    }
    begins = std::move(forward);
  };
  reverse(result_.child_begins, result_.children);
  reverse(result_.maker_begins, result_.makers);
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
    brought_.push_back({n == 2, canonical_key(rest[0], rest[1], rest[2]), makers_[slot]});
  }
  std::ranges::sort(brought_, [](const Brought& a, const Brought& b) {
    return std::pair(a.has_target, a.key) < std::pair(b.has_target, b.key);
  });
  for (std::size_t i = 1; i < brought_.size(); ++i)
    if (brought_[i].has_target == brought_[i - 1].has_target &&
        brought_[i].key == brought_[i - 1].key)
      return fail("vertex {}: expected tetrahedra with different keys, got two with {}", vertex,
                  brought_[i].key);
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

void HierarchyMaker::take_base(const LiveTetrahedra& live) {
  for (std::uint32_t slot = 0; slot < live.n_slots(); ++slot) {
    if (live.is_gone(slot)) continue;
    const Tetrahedron& t = live.corners(slot);
    result_.base.push_back(t);
    result_.base_makers.push_back(makers_[slot]);
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
}

/// Children come after their parents: from the last node on each passes what it has to the last of
/// its parents, which discovers it.
void HierarchyMaker::find_facts() {
  const std::size_t n_fields = result_.fields.size();
  result_.facts.resize(n_nodes() * n_fields);
  for (const MeshField& field : mesh_.fields)
    result_.range_references.push_back(field.values.empty() ? 0 : std::ranges::min(field.values));
  for (std::uint32_t node = 0; node < n_nodes(); ++node)
    for (std::size_t f = 0; f < n_fields; ++f) {
      const CollapseFacts& own = collapses_.facts[(n_nodes() - 1 - node) * n_fields + f];
      const double reference = result_.range_references[f];
      StoredFacts& facts = result_.facts[node * n_fields + f];
      facts.error = own.error == 0 ? 0 : rounded_up(own.error);
      facts.low = -rounded_up(reference - own.low);
      facts.high = rounded_up(own.high - reference);
    }
  for (std::uint32_t node = n_nodes(); node-- > 0;) {
    if (result_.parents_of(node).empty()) continue;
    const std::uint32_t parent = result_.parents_of(node).back();
    for (std::size_t f = 0; f < n_fields; ++f) {
      StoredFacts& to = result_.facts[parent * n_fields + f];
      const StoredFacts& from = result_.facts[node * n_fields + f];
      to.error = std::max(to.error, from.error);
      to.low = std::min(to.low, from.low);
      to.high = std::max(to.high, from.high);
    }
    const auto position = [&](std::uint32_t of) {
      return result_.positions[result_.n_base_vertices + of];
    };
    const double reach =
        length(position(node) - position(parent)) + static_cast<double>(result_.radii[node]);
    result_.radii[parent] =
        std::max(result_.radii[parent], std::nextafter(static_cast<float>(reach), INFINITY));
  }
}

/// Spreads a vertex's number, so that sums of different ones differ.
std::uint64_t spread(std::uint32_t vertex) {
  std::uint64_t z = vertex * 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 32)) * 0xbf58476d1ce4e5b9U;
  return z ^ (z >> 29);
}

}  // namespace

std::uint64_t canonical_key(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return spread(a) + spread(b) + spread(c);
}

Result<Hierarchy> make_hierarchy(const TetraMesh& mesh, const HalfEdgeCollapses& collapses,
                                 Threads threads) {
  return HierarchyMaker(mesh, collapses).run(threads);
}

}  // namespace lode::tetra_mt
