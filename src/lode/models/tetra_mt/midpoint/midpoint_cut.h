#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lode/models/tetra_mt/midpoint/forest.h"
#include "lode/models/tetra_mt/midpoint/star_order.h"
#include "lode/models/tetra_mt/slot_lists.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt::midpoint {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it. `field`: whose facts nodes have, and world errors
/// where these are known, and whose values vertices.
///
/// What must come before a node is read off the mesh. A tetrahedron was made by the collapse that
/// made its greatest label. So a vertex whose label is the greatest of all beside it has round it
/// only tetrahedra that its own collapse left, and, as they close round it, all of those: it may be
/// split. Else those beside it with larger labels must be split first, and before that whatever
/// these wait for. Once it may be split the list is that of the vertices whose splits made what is
/// beside it: ancestors all, and among them all that it directly depends on.
///
/// Of what is in the mesh all is known that a query asks before it splits it, so only pages are
/// looked at that have a node which is split, or was.
class MidpointCut {
 public:
  struct Cell {
    Tetrahedron corners;   ///< Labels; those of one that is gone begin with kNone.
    std::uint32_t region;  ///< As Hierarchy::base_regions says.
  };

  explicit MidpointCut(const Forest& forest, std::size_t field = 0,
                       WorldErrors world_errors = WorldErrors::unknown);

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    StoredFacts facts = codes().facts(NodeCodes::parts(word_of(node)));
    if (world_errors_ == WorldErrors::known)
      facts.world_error = forest_->world_error(index(node), field_);
    return facts;
  }
  [[nodiscard]] Bounds bounds(NodeId node) const;
  /// Read off the mesh: a vertex has the same regions round it in all cuts, as collapses keep all
  /// that lies between regions, and so those of the reference round all that it splits into.
  [[nodiscard]] std::uint64_t region_mask(NodeId node) const;
  [[nodiscard]] double range_reference() const { return codes().knots()[0]; }
  [[nodiscard]] std::uint64_t n_base_cells() const { return head_->n_base_cells; }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  /// By labels alone, as in the paper's section 5.2: whether a node's vertex is there and all
  /// beside it have smaller labels;
  [[nodiscard]] bool may_split(NodeId node) const;
  /// whether its edge is there, and all beside the ends are of the base or made by a larger label.
  [[nodiscard]] bool may_collapse(NodeId node) const;

  [[nodiscard]] const ForestHead& head() const { return *head_; }
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
    return forest_->position(label, vertices_[places_[label]].code);
  }
  [[nodiscard]] double value(std::uint32_t label) const {
    return forest_->value(label, vertices_[places_[label]].code, field_);
  }
  /// What is known of a node whose vertex is in the mesh, of any field: it is in the pages of nodes
  /// that are applied, and the base.
  [[nodiscard]] StoredFacts facts(NodeId node, std::size_t field) const;
  /// Values of any field of vertices of the mesh, likewise: found from the base down, in one pass.
  /// Fails as check() does.
  [[nodiscard]] Result<std::vector<double>> values(std::span<const std::uint32_t> labels,
                                                   std::size_t field) const;
  /// Whether a vertex of the mesh, and what shares tetrahedra with it, are within bounds.
  [[nodiscard]] bool is_star_within(std::uint32_t label, const Bounds& bounds) const;
  /// Which regions the tetrahedra round a vertex of the mesh have; region_bit()s.
  [[nodiscard]] std::uint64_t regions_round(std::uint32_t label) const;
  /// Whether a vertex is in the mesh.
  [[nodiscard]] bool has_vertex(std::uint32_t label) const { return places_[label] != kNone; }
  /// Fails where pages could not be loaded, or what they say of nodes does not fit together: then
  /// the mesh is no cut, and what asks for it should stop.
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] bool is_damaged() const { return is_damaged_; }

 private:
  /// With what its parent's page says of it.
  struct Vertex {
    std::uint32_t label;
    std::uint32_t parent;  ///< kNone of the base's.
    std::uint32_t facts;   ///< A word of NodeCodes, 0 of leaves.
    Code code;
  };

  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  [[nodiscard]] std::uint32_t label_of(NodeId node) const {
    return head_->n_vertices + index(node);
  }
  [[nodiscard]] std::vector<std::uint32_t> ancestors_of(
      std::span<const std::uint32_t> labels) const;
  [[nodiscard]] std::uint32_t word_of(NodeId node) const;
  [[nodiscard]] const NodeCodes& codes() const { return head_->fields[field_].codes; }
  [[nodiscard]] std::span<const std::uint32_t> star(std::uint32_t label) const {
    return stars_.of(places_[label]);
  }
  template <typename Visit>
  void visit_beside(std::uint32_t label, const Visit& visit) const;
  void add_vertex(const Vertex& vertex);
  void end_vertex(std::uint32_t label);
  void take_star(std::uint32_t label, std::uint64_t mask);
  [[nodiscard]] bool may_apply(std::uint32_t label, const Split& split);
  [[nodiscard]] std::uint32_t region_within(const Cell& cell) const;
  void find_edges();
  std::uint32_t take_slot();
  void place(std::uint32_t slot, const Cell& cell);

  const Forest* forest_;
  const ForestHead* head_;
  std::size_t field_;
  WorldErrors world_errors_;
  std::uint32_t outside_;
  bool is_damaged_ = false;
  std::uint64_t n_inside_ = 0;         ///< Cells.
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
