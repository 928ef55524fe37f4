#pragma once

#include <array>

#include "lode/models/diamond/world_error.h"
#include "lode/refine/one_shot.h"

namespace lode::diamond {

/// A node's id: which axes are odd, and the coordinates without their bit h, the first marked with
/// it; so level and tier are read off.
template <int D>
[[nodiscard]] constexpr NodeId id_of(const Diamond<D>& d) {
  std::uint64_t id = static_cast<std::uint64_t>(d.centre[0] | d.h());
  for (std::size_t i = 1; i < as_size(D); ++i)
    id |= static_cast<std::uint64_t>((d.centre[i] & ~d.h()) >> 1) << (19 * i + 1);
  return NodeId{id << 3 | d.odd};
}

template <int D>
[[nodiscard]] constexpr NodeId id_of(const Index<D>& centre) {
  return id_of<D>(diamond_at<D>(centre));
}

template <int D>
[[nodiscard]] constexpr Diamond<D> diamond_of(NodeId id) {
  const std::uint64_t bits = static_cast<std::uint64_t>(id);
  Diamond<D> d;
  d.odd = static_cast<std::uint32_t>(bits & 7U);
  d.tier = D - std::popcount(d.odd);
  const auto first = static_cast<std::int32_t>((bits >> 3) & 0xFFFFFU);
  d.level = std::countr_zero(static_cast<std::uint32_t>(first));
  d.centre[0] = d.is_odd(0) ? first : first & ~d.h();
  for (int i = 1; i < D; ++i) {
    const auto half = static_cast<std::int32_t>((bits >> (19 * i + 4)) & 0x7FFFFU);
    d.centre[as_size(i)] = 2 * half | (d.is_odd(i) ? d.h() : 0);
  }
  return d;
}

/// How ids change along an axis by 2h, for a node of this level.
template <int D>
[[nodiscard]] constexpr std::uint64_t id_step(int axis, int level) {
  return axis == 0 ? std::uint64_t{16} << level : std::uint64_t{16} << (19 * axis + level);
}

/// Calls body(id) for parents<D>(d, root), in their order.
template <int D, typename Body>
constexpr void for_each_parent(NodeId id, const Diamond<D>& d, std::int32_t root,
                               const Body& body) {
  const auto bits = static_cast<std::uint64_t>(id);
  if (d.tier > 0) {
    for (int i = 0; i < D; ++i) {
      if (d.is_odd(i)) continue;
      const std::uint64_t upper = bits | std::uint64_t{1} << i;
      body(NodeId{upper - id_step<D>(i, d.level)});
      body(NodeId{upper});
    }
    return;
  }
  if (2 * d.h() >= root) return;
  const Index<D> even = axis_ends<D>(d)[0];
  for (int i = 0; i < D; ++i) {
    Diamond<D> parent{even, d.level + 1, D - 1, 1U << i};
    parent.centre[as_size(i)] = 2 * d.centre[as_size(i)] - even[as_size(i)];
    body(id_of<D>(parent));
  }
}

/// Calls body(id) for the children of a node with all its relations whose first parent it is:
/// that is the one on the lower side of the first even axis; of cubes, the one whose axis is 0.
template <int D, typename Body>
constexpr void for_each_discovered(NodeId id, const Diamond<D>& d, const Body& body) {
  const auto bits = static_cast<std::uint64_t>(id);
  if (d.tier < D - 1) {
    for (int i = 0; i < D && d.is_odd(i); ++i)
      body(NodeId{bits - (std::uint64_t{1} << i) + id_step<D>(i, d.level)});
    return;
  }
  if (d.level == 0 || !d.is_odd(0)) return;
  Diamond<D> lowest{d.centre, d.level - 1, 0, (1U << D) - 1};
  for (std::size_t i = 0; i < as_size(D); ++i) lowest.centre[i] -= lowest.h();
  const auto first = static_cast<std::uint64_t>(id_of<D>(lowest));
  for (int corner = 0; corner < (1 << D); ++corner) {
    std::uint64_t child = first;
    for (int i = 0; i < D; ++i)
      if (((corner >> i) & 1) != 0) child += id_step<D>(i, lowest.level);
    body(NodeId{child});
  }
}

/// The diamond hierarchy as the engine sees it: everything but the stored attributes follows from
/// a node's centre. Nodes whose domain misses the data do not exist. `Field` is a LatticeField that
/// also gives attributes.
template <int D, typename Field = Model<D>>
class Refinable {
 public:
  /// Where world errors come from: none, and nodes have infinite ones; or the pages that nodes are
  /// in.
  enum class Worlds : std::uint8_t { none, of_pages };
  explicit Refinable(const Field& model, Worlds worlds = Worlds::none);
  /// Or, of a model in memory, compute_world_errors().
  Refinable(const Field& model, const WorldErrors& worlds) : Refinable(model, Worlds::none) {
    world_errors_ = &worlds;
  }

  [[nodiscard]] const Field& model() const { return model_; }

  void add_base(std::vector<NodeId>& out) const;
  /// Of a node's children those whose first existing parent it is.
  void add_children(NodeId id, std::vector<NodeId>& out) const;
  void add_parents(NodeId id, std::vector<NodeId>& out) const;
  [[nodiscard]] StoredFacts facts(NodeId id) const;
  /// Asks the memory for a node's facts.
  void prefetch(NodeId id) const;
  /// Contains the domains of all nodes below; its radius depends on level and odd axes only.
  [[nodiscard]] Bounds bounds(NodeId id) const;
  [[nodiscard]] double range_reference() const { return model_.range_reference(); }
  [[nodiscard]] std::uint64_t n_base_cells() const;
  std::uint64_t apply(NodeId id) const { return n_simplices(id); }
  std::uint64_t undo(NodeId id) const { return n_simplices(id); }

  /// Field error and range of any node; those of level 0 and tiers above 0 are found from the
  /// samples. No bounds.
  [[nodiscard]] NodeFacts facts_at(const Diamond<D>& node) const {
    return without_bounds(facts(id_of<D>(node)), range_reference());
  }
  /// All children in the data, whoever discovers them.
  void add_all_children(NodeId id, std::vector<NodeId>& out) const;

  /// The simplices of a cut that meet the data, in depth-first order. They may reach across its
  /// end: demands know nothing of the lattice.
  [[nodiscard]] std::vector<Simplex<D>> leaves(const Cut& cut) const;
  /// Calls visit(simplex) for each of them, but none of what lies in a simplex that
  /// enters(simplex) is false for.
  template <typename Enters, typename Visit>
  void for_each_leaf(const Cut& cut, const Enters& enters, const Visit& visit) const;

 private:
  struct Finest {
    double error = 0;
    Range range;
  };

  [[nodiscard]] bool exists(const Index<D>& centre) const;
  [[nodiscard]] bool exists(NodeId id) const { return exists(diamond_of<D>(id).centre); }
  /// Whether all nodes related to this one exist.
  [[nodiscard]] bool is_deep(const Diamond<D>& node) const;
  [[nodiscard]] std::uint64_t n_simplices(NodeId id) const;
  template <typename Samples>
  void join_finest(const Diamond<D>& node, const Index<D>& centre, const Samples& samples,
                   Finest& facts) const;
  void add_finest(const Diamond<D>& node, StoredFacts& facts) const;
  void find_radii();
  [[nodiscard]] float world_error(int level, WorldCode code) const {
    return decode_world(code) * longest_edges_[as_size(level)];
  }

  const Field& model_;
  Worlds worlds_;
  const WorldErrors* world_errors_ = nullptr;
  std::array<float, 21> longest_edges_{};                    ///< By level, of its simplices.
  std::array<std::array<double, power(2, D)>, 21> radii_{};  ///< By level and odd axes.
  Mat3 to_world_;
  WorldScales<D> world_scales_;
};

template <int D, typename Field>
template <typename Enters, typename Visit>
void Refinable<D, Field>::for_each_leaf(const Cut& cut, const Enters& enters,
                                        const Visit& visit) const {
  if (!model_.shape.has_cells()) return;
  std::vector<Simplex<D>> open = kuhn_simplices<D>({}, model_.shape.root_side());
  while (!open.empty()) {
    const Simplex<D> simplex = open.back();
    open.pop_back();
    if (!model_.shape.overlaps_data(bounds_of(simplex)) || !enters(simplex)) continue;
    if (is_finest(simplex) || !cut.contains(id_of<D>(simplex.bisection_point()))) {
      visit(simplex);
      continue;
    }
    for (const Simplex<D>& half : bisect(simplex)) open.push_back(half);
  }
}

extern template class Refinable<2>;
extern template class Refinable<3>;
static_assert(RefinableModel<Refinable<2>> && RefinableModel<Refinable<3>>);

}  // namespace lode::diamond
