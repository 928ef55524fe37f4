#include "lode/models/tetra_mt/midpoint/measured_fields.h"

#include <algorithm>

#include "lode/models/tetra_mt/midpoint/repeated_collapses.h"

namespace lode::tetra_mt::midpoint {
namespace {

/// The collapses that nodes undo, as they may be done again.
struct Collapses {
  std::vector<EdgeCollapse> collapses;  ///< By node,
  std::vector<Children> children;       ///< likewise.
  std::vector<bool> is_turned;          ///< Likewise: the first child is the end that goes.
};

/// A vertex has the slot of the smallest of the mesh's that went into it.
Result<Collapses> collapses_of(const Forest& forest, std::span<const std::uint32_t> mesh_vertices) {
  const ForestHead& head = forest.head();
  std::vector<std::uint32_t> slots(mesh_vertices.begin(), mesh_vertices.end());  // by label
  Collapses made;
  for (std::uint32_t node = 0; node < head.n_nodes(); ++node) {
    const Split split = forest.split(node);
    if (split.children.first == kNone) break;
    const std::uint32_t first = slots[split.children.first];
    const std::uint32_t second = slots[split.children.second];
    const bool is_turned = second < first;
    const Place place = split.placement.position;
    slots.push_back(std::min(first, second));
    made.collapses.push_back(
        {slots.back(), std::max(first, second), is_turned ? turned(place) : place});
    made.children.push_back(split.children);
    made.is_turned.push_back(is_turned);
  }
  LODE_CHECK(forest.check());
  return made;
}

}  // namespace

Result<std::vector<FieldRecords>> measure_fields(const Forest& forest,
                                                 std::span<const std::uint32_t> mesh_vertices,
                                                 const TetraMesh& mesh, Threads threads,
                                                 Progress& progress) {
  const ForestHead& head = forest.head();
  LODE_TRY(const Collapses made, collapses_of(forest, mesh_vertices));
  const RepeatRules rules{.boundary_tolerance = head.record.boundary_tolerance,
                          .has_world_errors = head.fields[0].base_world_error.has_value()};
  LODE_TRY(const RepeatedCollapses repeated,
           repeat_collapses(mesh, made.collapses, rules, threads, progress));
  FieldTrees trees{mesh_vertices, made.children, head.roots, head.n_base_leaves};
  if (rules.has_world_errors) trees.world_codes = WorldCodes(head.box.lower, head.box.upper);
  const std::size_t n_fields = mesh.fields.size();
  std::vector<FieldRecords> fields;
  for (std::size_t f = 0; f < n_fields; ++f) {
    std::vector<EdgeFacts> facts;
    for (std::uint32_t node = 0; node < head.n_nodes(); ++node) {
      facts.push_back(repeated.facts[node * n_fields + f]);
      if (made.is_turned[node]) facts.back().value = turned(facts.back().value);
    }
    const MeshField& field = mesh.fields[f];
    fields.push_back(
        make_field(trees, field, facts, base_error_of(repeated.errors, f, n_fields, field)));
  }
  return fields;
}

}  // namespace lode::tetra_mt::midpoint
