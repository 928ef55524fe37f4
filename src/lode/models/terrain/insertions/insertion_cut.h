#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "lode/core/box.h"
#include "lode/models/terrain/insertions/extract.h"
#include "lode/models/terrain/insertions/history.h"
#include "lode/refine/model.h"

namespace lode::insertions {

/// What the engine asks of insertions. A node is discovered by the latest of those that it depends
/// on; error, range and bounds are those of the triangles that it removes, joined with those of all
/// nodes that it discovers. 80 bytes a node. Bounds are in the world, z included.
class InsertionFacts {
 public:
  /// The history must outlive it. O(triangles).
  explicit InsertionFacts(const History& history);

  [[nodiscard]] const History& history() const { return *history_; }
  /// Those that depend on the base alone.
  [[nodiscard]] const std::vector<std::uint32_t>& roots() const { return roots_; }
  [[nodiscard]] std::span<const std::uint32_t> discovered_by(std::uint32_t node) const {
    return std::span(discovered_)
        .subspan(first_discovered_[node], first_discovered_[node + 1] - first_discovered_[node]);
  }
  [[nodiscard]] const StoredFacts& facts(std::uint32_t node) const { return facts_[node]; }
  [[nodiscard]] Bounds bounds(std::uint32_t node) const;

 private:
  void find_discovered();

  const History* history_;
  std::vector<std::uint32_t> discoverer_;  ///< kNone of roots.
  std::vector<std::uint32_t> roots_;
  std::vector<std::uint32_t> discovered_;
  std::vector<std::uint32_t> first_discovered_;
  std::vector<StoredFacts> facts_;
  std::vector<Box3d> boxes_;
};

/// A history opened for refinement (RefinableModel), at first at its base. The facts must outlive
/// it.
class InsertionCut {
 public:
  explicit InsertionCut(const InsertionFacts& facts)
      : facts_(&facts), applied_(facts.history().n_nodes()) {}

  void add_base(std::vector<NodeId>& out) const;
  void add_children(NodeId node, std::vector<NodeId>& out) const;
  void add_parents(NodeId node, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId node) const { return facts_->facts(index(node)); }
  [[nodiscard]] Bounds bounds(NodeId node) const { return facts_->bounds(index(node)); }
  [[nodiscard]] double range_reference() const { return facts_->history().range.lower; }
  [[nodiscard]] std::uint32_t n_nodes() const { return facts_->history().n_nodes(); }
  [[nodiscard]] std::uint64_t n_base_cells() const { return facts_->history().n_base_triangles(); }
  std::uint64_t apply(NodeId node);
  std::uint64_t undo(NodeId node);

  /// For tin_of().
  [[nodiscard]] const AppliedNodes& applied() const { return applied_; }

 private:
  [[nodiscard]] static std::uint32_t index(NodeId node) { return static_cast<std::uint32_t>(node); }
  [[nodiscard]] std::uint64_t growth(std::uint32_t node) const;

  const InsertionFacts* facts_;
  AppliedNodes applied_;
};

static_assert(RefinableModel<InsertionCut>);

}  // namespace lode::insertions
