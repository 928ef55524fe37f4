#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/slot_lists.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it. `field`: whose facts nodes have.
class TetraCut {
 public:
  struct alignas(32) Cell {
    Tetrahedron corners;   ///< Those of one that is gone begin with kNone.
    std::uint32_t maker;   ///< The node that made it, kNone for the reference mesh's.
    std::uint32_t region;  ///< Place in HierarchyHead::region_ids; any where it is outside.
  };

  explicit TetraCut(const PackedHierarchy& hierarchy, std::size_t field = 0);

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    return hierarchy_->facts(index(node), field_);
  }
  [[nodiscard]] Bounds bounds(NodeId node) const { return hierarchy_->bounds(index(node)); }
  [[nodiscard]] double range_reference() const {
    return hierarchy_->head().fields[field_].scale.knots()[0];
  }
  [[nodiscard]] std::uint64_t n_base_cells() const { return hierarchy_->head().n_base_cells; }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  /// By slot, with those to the vertex outside.
  [[nodiscard]] std::span<const Cell> slots() const { return cells_; }
  /// Neither gone nor to the vertex outside.
  [[nodiscard]] bool is_inside(const Cell& cell) const;
  /// The corners of those inside.
  [[nodiscard]] std::vector<Tetrahedron> cells() const;
  /// Fails where pages could not be loaded, or what they say of nodes does not fit together: then
  /// the mesh is no cut, and what asks for it should stop.
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] bool is_damaged() const { return is_damaged_; }

 private:
  /// A tetrahedron to come, by what it has beside the new vertex and, for an edge, the target.
  struct Coming {
    FaceKey key;
    std::array<std::uint32_t, 3> rest;  ///< Turned as it is to be.
    std::uint32_t slot;                 ///< Of what it replaces; kNone for an edge's.
  };

  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  void take_region(std::uint32_t node, std::uint32_t target);
  void find_outline();
  void place(std::uint32_t slot, const Cell& cell);
  void find_regions(NodePage::Links& links);
  std::uint32_t take_slot();

  const PackedHierarchy* hierarchy_;
  std::size_t field_;
  std::uint32_t outside_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> free_;
  SlotLists stars_;
  bool is_damaged_ = false;
  mutable std::uint64_t n_asked_ = 0;  ///< For parents, since a node was applied.
  std::vector<Coming> region_;
  std::vector<Coming> outline_;
  std::vector<std::uint64_t> edges_;     ///< First and second corner, of faces or as outlines go.
  std::vector<std::uint32_t> children_;  ///< Of the node being applied, and kNone.
};

}  // namespace lode::tetra_mt
