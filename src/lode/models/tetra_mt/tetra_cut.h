#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "lode/core/uninitialized_array.h"
#include "lode/models/tetra_mt/packed_hierarchy.h"
#include "lode/refine/model.h"

namespace lode::tetra_mt {

/// A hierarchy opened for refinement (RefinableModel): the mesh of the nodes applied so far, at
/// first none. The hierarchy must outlive it. `field`: whose facts nodes have.
class TetraCut {
 public:
  struct Cell {
    Tetrahedron corners;  ///< Those of one that is gone begin with kNone.
    /// By corner, the slot across from it; kNone where a face has more than two tetrahedra, which
    /// are of the vertex outside, at edges where the boundary is no manifold.
    std::array<std::uint32_t, 4> across;
    std::uint32_t maker;  ///< The node that made it, kNone for the reference mesh's.
    /// Place in HierarchyHead::region_ids; outside patch_mark() of its face.
    std::uint32_t region;
    std::uint32_t visit;  ///< The last one that came here.
    std::array<std::uint32_t, 5> unused;
  };
  static_assert(sizeof(Cell) == 64, "one line of the cache");

  explicit TetraCut(const PackedHierarchy& hierarchy, std::size_t field = 0);

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const {
    return hierarchy_->facts(index(node), field_);
  }
  [[nodiscard]] Bounds bounds(NodeId node) const { return hierarchy_->bounds(index(node)); }
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
  /// Neither gone nor to the vertex outside.
  [[nodiscard]] bool is_inside(const Cell& cell) const;
  /// The corners of those inside.
  [[nodiscard]] std::vector<Tetrahedron> cells() const;
  /// Fails where pages could not be loaded, or what they say of nodes does not fit together: then
  /// the mesh is no cut, and what asks for it should stop.
  [[nodiscard]] Result<void> check() const;
  [[nodiscard]] bool is_damaged() const { return is_damaged_; }

 private:
  /// What is put in order by vertices: a face, or an edge and kNone.
  struct Placed {
    std::uint64_t first;  ///< The smallest corner, and the next one.
    std::uint64_t last;   ///< The largest, and the place in region_ or outline_.
  };
  /// A tetrahedron that a node replaces.
  struct Face {
    std::uint32_t slot;
    std::uint32_t place;  ///< Of the target among the corners.
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
    std::array<Item, kMaxBrought + 4> items;
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

  /// What is read of a node: parents and children are asked for before it is applied.
  struct Read {
    std::uint32_t node = kNone;
    std::vector<std::uint32_t> children;  ///< And kNone.
    std::vector<std::uint32_t> parents;
    std::optional<NodePage::Links> rest;  ///< Of its links, from makers on.
  };

  /// At their begin.
  [[nodiscard]] NodePage::Links links_of(std::uint32_t node) const {
    if (!links_ || links_of_ != node) links_ = hierarchy_->links(node);
    links_of_ = node;
    return *links_;
  }
  [[nodiscard]] const Read& read(std::uint32_t node) const;
  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  void place_key(const FaceKey& key, std::size_t place);
  void start_visit();
  bool visit(std::uint32_t slot, bool is_wanted);
  void fetch_beside(const Cell& cell) const;
  void find_region(std::uint32_t node, std::uint32_t target);
  void find_star(std::uint32_t slot, std::uint32_t vertex);
  void set_across(std::uint32_t slot, std::uint32_t from, std::uint32_t to);
  void place_edges(std::uint32_t vertex, std::uint32_t target);
  void join_edges();
  void find_regions(NodePage::Links& links);
  std::uint32_t take_slot();

  const PackedHierarchy* hierarchy_;
  std::size_t field_;
  std::uint32_t outside_;
  UninitializedArray<Cell> cells_;
  std::vector<std::uint32_t> free_;
  /// By node: a tetrahedron that it made, where there is one; when it is applied, one that it
  /// brought.
  std::vector<std::uint32_t> slot_of_;
  std::uint32_t n_visits_ = 0;
  mutable std::optional<NodePage::Links> links_;
  mutable std::uint32_t links_of_ = kNone;
  mutable Read read_;
  bool is_damaged_ = false;
  mutable std::uint64_t n_asked_ = 0;  ///< For parents, since a node was applied.
  Few<Face> region_;
  Few<Edge> outline_;
  Few<Gone> gone_;
  Few<Placed> order_;  ///< Of region_ or outline_.
};

}  // namespace lode::tetra_mt
