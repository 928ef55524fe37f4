#pragma once

#include <string>

#include "lode/core/progress.h"
#include "lode/models/diamond/model.h"

namespace lode::diamond {

/// One property over many nodes, and the worst that breaks it.
struct AttributeFinding {
  std::uint64_t n_checked = 0;
  std::uint64_t n_wrong = 0;
  std::string worst;  ///< Where and by how much; empty when all hold.
};

struct AttributeReport {
  AttributeFinding own_errors;  ///< Largest |F - F'| at the samples of a node's domain <= stored.
  AttributeFinding own_ranges;  ///< Samples of a node's domain lie in its stored range.
  AttributeFinding nesting;     ///< A node's stored values cover its children's.
  AttributeFinding tightness;   ///< Stored values exceed the smallest nested ones by rounding only.
  AttributeFinding worlds;      ///< Stored world errors are what their definition says.
};

/// Recomputes the attributes of all nodes from the model's samples by their definitions, sharing
/// nothing with the build but the lattice: every interpolant is evaluated at every sample from
/// barycentric coordinates. O(samples · levels · D). Where holes are, infinite errors make
/// tightness meaningless; it is then checked for nodes whose stored error is finite only. World
/// errors, of models that have some, are found by WorldErrorRule, node by node.
template <int D>
[[nodiscard]] Result<AttributeReport> check_attributes(const Model<D>& model, Threads threads,
                                                       Progress& progress);

}  // namespace lode::diamond
