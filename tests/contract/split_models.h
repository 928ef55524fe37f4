#pragma once

// One Multi-Tessellation as two models, which differ in how dependencies are known: from tables, or
// from nothing but vertex labels, Cignoni et al. 2004, section 5.2 (after El-Sana and Varshney).
// A node's id is the label of the vertex that it splits.

#include <cstdint>
#include <utility>
#include <vector>

#include "lode/refine/model.h"
#include "tests/contract/split_hierarchy.h"

namespace lode::test {

[[nodiscard]] inline Label label_of(NodeId node) { return static_cast<Label>(node); }
[[nodiscard]] inline NodeId node_of(Label v) { return NodeId{v}; }

/// What both have in common: everything but add_parents. Must not outlive the hierarchy.
class SplitModel {
 public:
  explicit SplitModel(const SplitHierarchy& hierarchy)
      : hierarchy_(&hierarchy), mesh_(hierarchy.vertices.size(), hierarchy.base) {}

  /// The forest's roots.
  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    return hierarchy_->facts[hierarchy_->place(label_of(node))];
  }
  [[nodiscard]] Bounds bounds(NodeId node) const {
    return hierarchy_->bounds[hierarchy_->place(label_of(node))];
  }
  [[nodiscard]] double range_reference() const { return 0; }
  [[nodiscard]] std::uint64_t n_base_cells() const { return hierarchy_->base.size(); }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  [[nodiscard]] const SplitHierarchy& hierarchy() const { return *hierarchy_; }
  /// Of the nodes applied so far.
  [[nodiscard]] const SplitMesh& mesh() const { return mesh_; }

 private:
  const SplitHierarchy* hierarchy_;
  SplitMesh mesh_;
};

/// By split: the labels of those that make a triangle which it replaces. The forest's parent, which
/// discovers a node, need not be one of them: then it is further up.
using ParentTable = std::vector<std::vector<Label>>;
[[nodiscard]] ParentTable find_parents(const SplitHierarchy& hierarchy);

/// Answers from the table, whatever the mesh is.
class SplitTable : public SplitModel {
 public:
  SplitTable(const SplitHierarchy& hierarchy, const ParentTable& parents)
      : SplitModel(hierarchy), parents_(&parents) {}

  void add_parents(NodeId node, std::vector<NodeId>& out) const;

 private:
  const ParentTable* parents_;
};

/// Answers from the labels in the mesh. A triangle was made by the collapse that made its greatest
/// label. So a vertex with the greatest label among its neighbours has around it only triangles
/// that its own collapse left, and, as they close round it, all of those: its split is possible.
/// The complete list, those that made the star's vertices, is then the same every time.
///
/// The list is longer than the table's: what made a neighbour may lie further back than what made
/// the last triangle between it and the vertex. But it names ancestors only, and among them all
/// that the table names, so the same splits and the same collapses are possible.
///
/// Of an applied node, whose star is gone, it knows no more than the forest's parent.
class SplitLabels : public SplitModel {
 public:
  using SplitModel::SplitModel;

  void add_parents(NodeId node, std::vector<NodeId>& out) const;

  /// Section 5.2, property 1.
  [[nodiscard]] bool can_split(NodeId node) const;
  /// Section 5.2, property 2.
  [[nodiscard]] bool can_collapse(NodeId node) const;
};

}  // namespace lode::test
