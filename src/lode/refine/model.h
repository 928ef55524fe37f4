#pragma once

// What the engine needs from a multiresolution model. The engine never learns what a node is.

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "lode/core/vec.h"

namespace lode {

/// A node of a model; the order of ids breaks ties between equal demands.
enum class NodeId : std::uint64_t {};

/// Minimum and maximum of the full-resolution field; empty (low > high) where there is none.
struct Range {
  double low = 0;
  double high = 0;

  friend bool operator==(const Range&, const Range&) = default;
  [[nodiscard]] bool is_empty() const { return low > high; }
  /// Whether an isosurface may pass: samples of at least the isovalue are inside it.
  [[nodiscard]] bool crosses(double isovalue) const { return low < isovalue && isovalue <= high; }
  [[nodiscard]] bool meets(const Range& r) const { return low <= r.high && r.low <= high; }
  [[nodiscard]] bool contains(const Range& r) const {
    return r.is_empty() || (low <= r.low && r.high <= high);
  }
};

/// World units.
struct Ball {
  Vec3d centre;
  double radius = 0;

  friend bool operator==(const Ball&, const Ball&) = default;
};

/// World units: what is within a distance of a box, so that balls and boxes are bounds alike.
struct Bounds {
  Vec3d centre;
  double radius = 0;  ///< The distance.
  Vec3d half{};       ///< The box's edges; 0 for a ball.

  friend bool operator==(const Bounds&, const Bounds&) = default;
  [[nodiscard]] bool contains(const Bounds& b) const {
    return beyond(b.centre, b.half) + b.radius <= radius;
  }
  /// How far from the bounds' box a point is, or one that has `inner` round it reaches out.
  [[nodiscard]] double beyond(const Vec3d& p, const Vec3d& inner = {}) const {
    Vec3d way;
    for (std::size_t i = 0; i < 3; ++i)
      way[i] = std::max(std::abs(p[i] - centre[i]) + inner[i] - half[i], 0.0);
    return length(way);
  }
  /// How far from the centre they reach in a direction of length 1, and against it.
  [[nodiscard]] double reach(const Vec3d& direction) const {
    double sum = radius;
    for (std::size_t i = 0; i < 3; ++i) sum += std::abs(direction[i]) * half[i];
    return sum;
  }
};

/// A node's nested attributes, its own joined with all its descendants', as a cut keeps them.
struct StoredFacts {
  float error = 0;                                             ///< Field units, rounded up.
  float world_error = std::numeric_limits<float>::infinity();  ///< World units; an estimate.
  float low = 0;   ///< Range above the model's range_reference(), rounded outward;
  float high = 0;  ///< low > high where there is no field.
  /// Its simplices reach across the end of the data, where a surface must end exactly.
  bool is_at_border = false;

  friend bool operator==(const StoredFacts&, const StoredFacts&) = default;
};

/// Of a domain in regions (blocks, materials): a bit for each that a node's part of it meets, by
/// numbers modulo 64.
inline constexpr std::uint64_t kAllRegions = ~std::uint64_t{0};

/// The same as demands see them.
struct NodeFacts {
  double error = 0;        ///< How wrong the field is on its domain if it is not refined.
  double world_error = 0;  ///< How far an isosurface may be off, an estimate.
  Range range;             ///< Of the full-resolution field over the domain.
  Bounds bounds;           ///< Contain the domain.
  bool is_at_border = false;
  std::uint64_t regions = kAllRegions;  ///< RegionedModel's; all of others.
};

/// `bounds` stay empty: only some demands look at them.
[[nodiscard]] inline NodeFacts without_bounds(const StoredFacts& stored, double range_reference) {
  NodeFacts facts{
      stored.error, stored.world_error, {stored.low, stored.high}, {}, stored.is_at_border};
  if (range_reference != 0 && !facts.range.is_empty()) {
    // At least one unit outward: adding rounds.
    facts.range.low += range_reference;
    facts.range.high += range_reference;
    facts.range.low -= std::abs(facts.range.low) * 0x1p-52;
    facts.range.high += std::abs(facts.range.high) * 0x1p-52;
  }
  return facts;
}

/// A model whose refinements are partially ordered, opened for refinement: it is told of every node
/// that is applied or undone, one at a time, always from one consistent set to another.
/// - add_base: the nodes that nothing comes before, or that discovery starts from.
/// - add_children: the nodes that a node discovers; each node but the base has exactly one such
///   node, on which it depends, directly or not.
/// - add_parents: the nodes a node directly depends on. If some are not applied, those must be
///   first, and asking again afterwards may name others. Once all are applied the list is
///   complete, and the same again after the node has been undone. Implicit and tabulated models
///   know it always; label-encoded ones find it in the mesh of the nodes applied so far.
/// - facts, bounds: nested along add_children.
/// - apply, undo: return how many simplices the mesh has gained or lost by it.
/// One that has `n_nodes()`, a std::uint32_t, says that its ids are below: a cut finds them faster.
template <typename M>
concept RefinableModel = requires(M& model, const M& fixed, NodeId node, std::vector<NodeId>& out) {
  fixed.add_base(out);
  fixed.add_children(node, out);
  fixed.add_parents(node, out);
  { fixed.facts(node) } -> std::same_as<StoredFacts>;
  { fixed.bounds(node) } -> std::same_as<Bounds>;
  { fixed.range_reference() } -> std::convertible_to<double>;
  { fixed.n_base_cells() } -> std::convertible_to<std::uint64_t>;
  { model.apply(node) } -> std::convertible_to<std::uint64_t>;
  { model.undo(node) } -> std::convertible_to<std::uint64_t>;
};

/// One whose domain has regions. `region_mask`: nested along add_children, too.
template <typename M>
concept RegionedModel = RefinableModel<M> && requires(const M& fixed, NodeId node) {
  { fixed.region_mask(node) } -> std::same_as<std::uint64_t>;
};

template <RefinableModel M>
[[nodiscard]] std::uint64_t region_mask_of(const M& model, NodeId node) {
  if constexpr (RegionedModel<M>)
    return model.region_mask(node);
  else
    return kAllRegions;
}

/// What holding the pages of a node has come to.
struct Held {
  enum class State : std::uint8_t {
    held,    ///< They are there.
    absent,  ///< `page` is not, but there is room for it.
    full,    ///< There is no room unless others are let go.
  };
  State state = State::held;
  std::uint32_t page = 0;
};

/// A model whose data come in pages, when they are asked for, and of which no more are kept than
/// fit its memory. A node can be applied when its pages are held; what is known of applied nodes
/// and their children stays known until they are undone.
/// - hold: the pages that applying a node takes; let_go: undoes one that came to `held`.
/// - request, forget_requests: pages by demand; has_arrivals, take_arrivals: those that have come.
/// - n_room: how much may be held. n_free: what is left of it beside pages that are held or
///   promised; a page is promised from when hold() finds it absent until it is held.
/// - may_be_full: whether all pages are more than n_room. is_over: whether those held are, since
///   others have come.
/// - drop_unclaimed: ends promises of pages that have come; false if there are none.
template <typename M>
concept PagedRefinableModel = RefinableModel<M> &&
    requires(M& model, const M& fixed, NodeId node, std::uint32_t page, float demand,
             std::vector<std::uint32_t>& out) {
  { model.hold(node) } -> std::same_as<Held>;
  model.let_go(node);
  model.request(page, demand);
  model.forget_requests();
  { fixed.has_arrivals() } -> std::same_as<bool>;
  model.take_arrivals(out);
  { fixed.may_be_full() } -> std::same_as<bool>;
  { fixed.is_over() } -> std::same_as<bool>;
  { fixed.n_free() } -> std::convertible_to<std::uint64_t>;
  { fixed.n_room() } -> std::convertible_to<std::uint64_t>;
  { model.drop_unclaimed() } -> std::same_as<bool>;
};

template <RefinableModel M>
[[nodiscard]] NodeFacts facts_of(const M& model, NodeId node) {
  NodeFacts facts = without_bounds(model.facts(node), model.range_reference());
  facts.bounds = model.bounds(node);
  facts.regions = region_mask_of(model, node);
  return facts;
}

}  // namespace lode
