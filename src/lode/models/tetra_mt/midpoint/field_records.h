#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "lode/core/tetra_mesh.h"
#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/state.h"

namespace lode::tetra_mt::midpoint {

/// What fields need to know of a hierarchy's trees.
struct FieldTrees {
  std::span<const std::uint32_t> mesh_vertices;  ///< By leaf.
  std::span<const Children> children;            ///< By node.
  std::span<const std::uint32_t> roots;          ///< ForestHead's,
  std::uint32_t n_base_leaves = 0;               ///< likewise.
  std::optional<WorldCodes> world_codes{};       ///< Of the mesh, where collapses have such errors.
};

/// What a hierarchy has of a field.
struct FieldRecords {
  ForestField head;
  FurtherField records;
  WorldPage world_codes{};  ///< By node of all; empty where there are none.
};

/// From values at the vertices of the mesh, bit for bit, and what is known of collapses: `facts` by
/// node, whose places are of the first and the second child. Facts are nested along the trees.
/// `base_error`: base_error_of() it.
[[nodiscard]] FieldRecords make_field(const FieldTrees& trees, const MeshField& field,
                                      std::span<const EdgeFacts> facts, double base_error);

/// The largest of errors by vertex and field, shares of the field's range, in its unit, rounded up.
[[nodiscard]] double base_error_of(std::span<const float> errors, std::size_t field,
                                   std::size_t n_fields, const MeshField& of);

}  // namespace lode::tetra_mt::midpoint
