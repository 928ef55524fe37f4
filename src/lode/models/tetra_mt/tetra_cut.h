#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/hierarchy.h"
#include "lode/models/tetra_mt/slot_lists.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it. `field`: whose facts nodes have.
class TetraCut {
 public:
  explicit TetraCut(const Hierarchy& hierarchy, std::size_t field = 0);

  void add_base(std::vector<NodeId>& out) const;
  /// Those of which the node is the last parent.
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const;
  [[nodiscard]] Ball bounds(NodeId node) const;
  [[nodiscard]] double range_reference() const { return hierarchy_->range_references[field_]; }
  [[nodiscard]] std::uint64_t n_base_cells() const { return hierarchy_->n_base_cells; }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  /// Tetrahedra by slot, with those to the vertex outside; gone ones begin with kNone.
  [[nodiscard]] std::span<const Tetrahedron> slots() const { return tetrahedra_; }
  /// By slot: the node that made it, kNone for the reference mesh's.
  [[nodiscard]] std::span<const std::uint32_t> makers() const { return makers_; }
  /// Without those to the vertex outside.
  [[nodiscard]] std::vector<Tetrahedron> cells() const;

 private:
  /// A tetrahedron to come, by what it has beside the new vertex and, for an edge, the target.
  struct Coming {
    std::uint64_t key;
    std::array<std::uint32_t, 3> rest;  ///< Turned as it is to be.
    std::uint32_t slot;                 ///< Of what it replaces; kNone for an edge's.
  };

  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  [[nodiscard]] std::uint32_t maker(std::uint32_t node, std::size_t place) const;
  void take_region(std::uint32_t node, std::uint32_t target);
  void find_outline();
  void place(std::uint32_t slot, const Tetrahedron& corners, std::uint32_t maker);
  std::uint32_t take_slot();

  const Hierarchy* hierarchy_;
  std::size_t field_;
  std::vector<Tetrahedron> tetrahedra_;
  std::vector<std::uint32_t> makers_;
  std::vector<std::uint32_t> free_;
  SlotLists stars_;
  std::vector<Coming> region_;
  std::vector<Coming> outline_;
  std::vector<std::uint64_t> edges_;  ///< First and second corner, of faces or as outlines go.
};

}  // namespace lode::tetra_mt
