#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/models/tetra_mt/small_order.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it. `field`: whose facts nodes have, and world errors
/// where these are known.
class TetraCut {
 public:
  struct Cell {
    Tetrahedron corners;  ///< Those of one that is gone begin with kNone.
    /// By corner, the slot across from it; kNone where a face has more than two tetrahedra, which
    /// are of the vertex outside, at edges where the boundary is no manifold.
    std::array<std::uint32_t, 4> across;
  };
  static_assert(sizeof(Cell) == 32, "half a line of the cache");

  explicit TetraCut(const PackedHierarchy& hierarchy, std::size_t field = 0,
                    WorldErrors world_errors = WorldErrors::unknown);

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    StoredFacts facts = hierarchy_->facts(index(node), field_);
    if (world_errors_ == WorldErrors::known)
      facts.world_error = hierarchy_->world_error(index(node), field_);
    return facts;
  }
  [[nodiscard]] Bounds bounds(NodeId node) const { return hierarchy_->bounds(index(node)); }
  [[nodiscard]] std::uint64_t region_mask(NodeId node) const {
    return hierarchy_->region_mask(index(node));
  }
  [[nodiscard]] double range_reference() const { return hierarchy_->head().fields[field_].low; }
  [[nodiscard]] std::uint32_t n_nodes() const { return hierarchy_->head().shape.n_nodes; }
  [[nodiscard]] std::uint64_t n_base_cells() const { return hierarchy_->head().n_base_cells; }
  /// Asks the memory for what applying a node soon will need.
  void prefetch(NodeId node) const {
    hierarchy_->prefetch(index(node), field_);
    const std::uint32_t slot = slot_of_[index(node)];
    if (slot != kNone) __builtin_prefetch(&cells_[slot], 1);
  }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  [[nodiscard]] const HierarchyHead& head() const { return hierarchy_->head(); }
  /// By slot, with those to the vertex outside.
  [[nodiscard]] std::span<const Cell> slots() const { return cells_; }
  /// The node that made a slot's, kNone for the reference mesh's.
  [[nodiscard]] std::uint32_t maker(std::uint32_t slot) const { return makers_[slot]; }
  /// Of a slot's, place in HierarchyHead::region_ids; outside patch_mark() of its face.
  [[nodiscard]] std::uint32_t region(std::uint32_t slot) const {
    return regions_.empty() ? 0 : regions_[slot];
  }
  /// Which regions those have that the node brought that was applied last; region_bit()s.
  [[nodiscard]] std::uint64_t regions_brought() const;
  /// Neither gone nor to the vertex outside.
  [[nodiscard]] bool is_inside(const Cell& cell) const;
  /// The corners of those inside.
  [[nodiscard]] std::vector<Tetrahedron> cells() const;
  /// Fails where pages could not be loaded, or what they say of nodes does not fit together: then
  /// the mesh is no cut, and what asks for it should stop.
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] bool is_damaged() const { return is_damaged_; }

 private:
  /// A tetrahedron that a node replaces.
  struct Face {
    std::uint32_t slot;
    std::uint32_t place;  ///< Of the target among the corners.
  };
  /// Where it is at the outline.
  struct Side {
    std::uint32_t slot;
    std::uint16_t place;  ///< Of the target,
    std::uint16_t other;  ///< and which of the others is across from it.
  };
  /// A tetrahedron that goes, and places of two of its corners.
  struct Gone {
    std::uint32_t slot;
    std::uint32_t of_vertex;
    std::uint32_t of_target;
  };
  /// What a node replaces or brings, and room for what may prove too much.
  template <typename Item>
  struct Few {
    std::array<Item, SmallOrder::kMost> items;
    std::size_t n = 0;

    [[nodiscard]] const Item* begin() const { return items.data(); }
    [[nodiscard]] const Item* end() const { return items.data() + n; }
    [[nodiscard]] bool is_empty() const { return n == 0; }
  };
  /// A tetrahedron that comes at an edge of the outline.
  struct Edge {
    std::uint32_t first;  ///< Turned as it is to be.
    std::uint32_t second;
    std::uint32_t inner;   ///< What is replaced at it,
    std::uint32_t corner;  ///< there across from this corner,
    std::uint32_t outer;   ///< what is beyond, or kNone,
    std::uint32_t slot;    ///< and itself.
  };

  static constexpr std::uint32_t kReads = 16;
  /// What is read of a node: parents and children are asked for before it is applied.
  struct Read {
    std::uint32_t node = kNone;
    std::uint32_t target = kNone;
    std::uint32_t n_discovered = 0;
    Few<std::uint32_t> children;  ///< Those it discovers, others, and kNone.
    Few<std::uint32_t> parents;
    std::optional<NodePage::Links> rest;  ///< Of its links, from makers on.
  };

  const Read& read(std::uint32_t node) const;
  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  void fetch_beside(std::uint32_t slot) const;
  void find_region(std::uint32_t node, std::uint32_t target);
  void find_star(std::uint32_t slot, std::uint32_t vertex);
  void set_across(std::uint32_t slot, std::uint32_t from, std::uint32_t to);
  void find_outline();
  void place_face(std::size_t i, std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void find_orders();
  void read_makers(const Read& read);
  void set_maker(std::uint32_t slot, std::uint32_t rank);
  void take_slots();
  void place_edges(std::uint32_t vertex, std::uint32_t target);
  void join_edges();
  [[nodiscard]] std::size_t edge_after(const Edge& edge) const;
  void find_regions();

  const PackedHierarchy* hierarchy_;
  std::size_t field_;
  WorldErrors world_errors_;
  std::uint32_t outside_;
  UninitializedArray<Cell> cells_;
  UninitializedArray<std::uint32_t> makers_;   ///< By slot: what walks ask of all they come to.
  UninitializedArray<std::uint32_t> regions_;  ///< Likewise; of nothing where all are of one.
  std::vector<std::uint32_t> free_;
  /// By node: a tetrahedron that it made, where there is one; when it is applied, one that it
  /// brought. The last one is of the reference mesh, and means nothing.
  std::vector<std::uint32_t> slot_of_;
  /// By node, a few: what waits for its parents is asked for again.
  mutable std::array<Read, kReads> reads_;
  bool is_damaged_ = false;
  mutable std::uint64_t n_asked_ = 0;  ///< For parents, since a node was applied.
  Few<Face> region_;
  Few<Side> sides_;
  Few<Edge> outline_;
  Few<Gone> gone_;
  SmallOrder faces_{3};                  ///< Of region_, by the corners that stay,
  SmallOrder edges_{2};                  ///< and of outline_.
  std::optional<NodePage::Links> rest_;  ///< Of the node that is applied, after makers.
  Few<std::uint32_t> brought_;           ///< Makers of faces, then edges, in these orders.
  Few<std::uint32_t> taken_;             ///< Slots for edges, in theirs.
  /// By the last bits of a vertex, the place of an edge that may begin there.
  std::array<std::uint8_t, 1024> edge_at_{};
};

}  // namespace lode::tetra_mt
