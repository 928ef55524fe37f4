#include "lode/models/tetra_mt/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "lode/models/tetra_mt/box_codes.h"
#include "lode/models/tetra_mt/brought_tetrahedra.h"
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

/// Makes a hierarchy of collapses and the stars that they had.
class HierarchyMaker {
 public:
  HierarchyMaker(const TetraMesh& mesh, const HalfEdgeCollapses& collapses)
      : mesh_(mesh), collapses_(collapses), numbers_(mesh.positions.size(), kNone) {}

  Result<Hierarchy> run(Threads threads) {
    number_vertices();
    {
      BroughtTetrahedra brought(mesh_, collapses_, numbers_, nodes_, result_, threads);
      LODE_CHECK(brought.run());
      boxes_ = brought.take_boxes();
    }
    find_parents();
    find_facts();
    find_boxes();
    if (!result_.region_masks.empty()) find_region_masks();
    return std::move(result_);
  }

 private:
  [[nodiscard]] std::uint32_t n_nodes() const {
    return static_cast<std::uint32_t>(collapses_.collapses.size());
  }
  void number_vertices();
  void find_parents();
  void find_facts();
  void find_boxes();
  void find_region_masks();

  const TetraMesh& mesh_;
  const HalfEdgeCollapses& collapses_;
  std::vector<std::uint32_t> numbers_;  ///< Of the mesh's vertices in the hierarchy.
  std::vector<std::uint32_t> nodes_;    ///< By collapse.
  std::vector<Box3d> boxes_;            ///< By node: of its tetrahedra, then of all it discovers.
  Hierarchy result_;
};

void HierarchyMaker::number_vertices() {
  NodeOrder order = order_nodes(mesh_, collapses_);
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
  result_.region_names = mesh_.region_names;
  result_.patches = mesh_.patches;
  result_.boundary_deviation = collapses_.boundary_deviation;
  result_.has_errors_everywhere = collapses_.has_errors_everywhere;
  result_.has_world_errors = collapses_.has_world_errors;
  for (const MeshField& field : mesh_.fields) {
    MeshField& to = result_.fields.emplace_back(
        MeshField{.name = field.name, .type = field.type, .n_components = 1, .values = {}});
    for (const std::uint32_t v : vertices) to.values.push_back(field.values[v]);
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
      if (collapses_.has_world_errors)
        facts.world_error = own.world_error == 0 ? 0 : rounded_up(own.world_error);
    }
  for (const std::uint32_t node : nodes_) {
    const std::uint32_t parent = result_.discoverers[node];
    if (parent == kNone) continue;
    for (std::size_t f = 0; f < n_fields; ++f) {
      StoredFacts& to = result_.facts[parent * n_fields + f];
      const StoredFacts& from = result_.facts[node * n_fields + f];
      to.error = std::max(to.error, from.error);
      to.world_error = std::max(to.world_error, from.world_error);
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

/// Likewise.
void HierarchyMaker::find_region_masks() {
  auto& masks = result_.region_masks;
  for (const std::uint32_t node : nodes_)
    if (const std::uint32_t parent = result_.discoverers[node]; parent != kNone)
      masks[parent] |= masks[node];
}

}  // namespace

Result<Hierarchy> make_hierarchy(const TetraMesh& mesh, const HalfEdgeCollapses& collapses,
                                 Threads threads) {
  return HierarchyMaker(mesh, collapses).run(threads);
}

}  // namespace lode::tetra_mt
