#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/midpoint/hierarchy.h"
#include "lode/models/tetra_mt/midpoint/star_order.h"
#include "lode/models/tetra_mt/slot_lists.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt::midpoint {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it.
///
/// What must come before a node is read off the mesh. A tetrahedron was made by the collapse that
/// made its greatest label. So a vertex whose label is the greatest of all beside it has round it
/// only tetrahedra that its own collapse left, and, as they close round it, all of those: it may be
/// split. Else those beside it with larger labels must be split first, and before that whatever
/// these wait for. Once it may be split the list is that of the vertices whose splits made what is
/// beside it: ancestors all, and among them all that it directly depends on.
class MidpointCut {
 public:
  struct Cell {
    Tetrahedron corners;   ///< Labels; those of one that is gone begin with kNone.
    std::uint32_t region;  ///< As Hierarchy::base_regions says.
  };

  explicit MidpointCut(const Hierarchy& hierarchy);

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    return hierarchy_->codes.facts(NodeCodes::parts(hierarchy_->nodes[index(node)].facts));
  }
  [[nodiscard]] Bounds bounds(NodeId node) const;
  [[nodiscard]] double range_reference() const { return hierarchy_->codes.knots()[0]; }
  [[nodiscard]] std::uint64_t n_base_cells() const { return hierarchy_->n_base_cells; }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  /// By labels alone, as in the paper's section 5.2: whether a node's vertex is there and all
  /// beside it have smaller labels;
  [[nodiscard]] bool may_split(NodeId node) const;
  /// whether its edge is there, and all beside the ends are of the base or made by a larger label.
  [[nodiscard]] bool may_collapse(NodeId node) const;

  [[nodiscard]] const Hierarchy& hierarchy() const { return *hierarchy_; }
  /// By slot, with those to the vertex outside.
  [[nodiscard]] std::span<const Cell> slots() const { return cells_; }
  /// Neither gone nor to the vertex outside.
  [[nodiscard]] bool is_inside(const Cell& cell) const;
  /// The corners of those inside.
  [[nodiscard]] std::vector<Tetrahedron> cells() const;
  /// The node that made a cell, or kNone of one of the reference mesh.
  [[nodiscard]] std::uint32_t maker(const Cell& cell) const;
  /// Of a vertex of the mesh.
  [[nodiscard]] Vec3d position(std::uint32_t label) const {
    return hierarchy_->position(label, vertices_[places_[label]].code);
  }
  [[nodiscard]] double value(std::uint32_t label) const {
    return hierarchy_->value(label, vertices_[places_[label]].code);
  }

 private:
  struct Vertex {
    std::uint32_t label;
    Code code;
  };

  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  [[nodiscard]] std::uint32_t label_of(NodeId node) const {
    return hierarchy_->n_vertices + index(node);
  }
  [[nodiscard]] bool has_vertex(std::uint32_t label) const { return places_[label] != kNone; }
  [[nodiscard]] std::span<const std::uint32_t> star(std::uint32_t label) const {
    return stars_.of(places_[label]);
  }
  template <typename Visit>
  void visit_beside(std::uint32_t label, const Visit& visit) const;
  void add_vertex(std::uint32_t label, const Code& code);
  void end_vertex(std::uint32_t label);
  void take_star(std::uint32_t label, std::uint32_t node);
  void find_edges();
  std::uint32_t take_slot();
  void place(std::uint32_t slot, const Cell& cell);

  const Hierarchy* hierarchy_;
  std::uint32_t outside_;
  std::vector<std::uint32_t> places_;  ///< By label: of its vertex, or kNone.
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> free_vertices_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> free_cells_;
  SlotLists stars_;  ///< By place.
  std::vector<StarTriangle> star_;
  /// A face between tetrahedra of both ends: its edge's labels, as the first end's have it.
  struct Between {
    std::uint64_t key;
    std::uint32_t a;
    std::uint32_t b;
    std::uint32_t slot;
  };
  std::vector<Between> between_;
};

}  // namespace lode::tetra_mt::midpoint
